"""What ``character.toml`` says of a character: which files are what, which part is the face, how its meshes stand."""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

from facezip.character.maps import ENCODINGS, KNOWN, Map, is_map_name
from facezip.character.placement import Placement
from facezip.documents.document import Toml
from facezip.errors import ErrorCode, FaceZipError, Refuse, raised
from facezip.files.reading import reading

SETTINGS = "character.toml"
MAX_SETTINGS = 2**20
MASK_FILE = "mask.png"
_PLACEMENT = {each.name for each in fields(Placement)}


@dataclass(frozen=True)
class MapPattern:
    """How the files of one map are called and read; ``files`` is a pattern, the rest as of ``MapFiles``."""

    kind: Map
    files: str
    keeps_floats: bool
    green_down: bool


@dataclass(frozen=True)
class Patterns:
    """How files are called: patterns of their paths in the folder (:mod:`facezip.character.patterns`).

    Attributes
    ----------
    meshes, masks : of the meshes and the masks.
    maps : by name.
    """

    meshes: str
    masks: str
    maps: dict[str, MapPattern]


@dataclass(frozen=True)
class Settings:
    """All of it.

    Attributes
    ----------
    part : the mesh or material that is the face; None where that is not said.
    neutral : what the mesh of the face at rest is called; None where that is not said.
    placement : how all meshes stand.
    patterns : which files are what; None where nothing is said of files, and custom holds.
    """

    part: str | None = None
    neutral: str | None = None
    placement: Placement = field(default_factory=Placement)
    patterns: Patterns | None = None


def read_settings(folder: Path, refuse: Refuse = raised) -> Settings:
    """What ``character.toml`` in a folder says; nothing where there is none.

    Raises
    ------
    FaceZipError
        ``BAD_CHARACTER`` where it says something else than it may (where that is no question of files, ``refuse`` takes
        the error); ``TOO_LARGE`` or ``CANNOT_READ``.
    """
    path = folder / SETTINGS
    with reading(path):
        document = _document(path)
    stated = {key: document.pop(key) for key in _PLACEMENT & {*document}}
    part = _name(document, "part", _bad(path, "part is the name of a mesh or a material"), refuse)
    neutral = _name(document, "neutral", _bad(path, "neutral is the name of the mesh of the face at rest"), refuse)
    try:
        placement = Placement.of(stated)
    except ValueError as error:
        refuse(_bad(path, error))
        placement = Placement()
    try:
        return Settings(part, neutral, placement, _patterns(document) if document else None)
    except ValueError as error:
        raise _bad(path, error) from None


def _document(path: Path) -> Toml:
    if not path.is_file():
        return {}
    if path.stat().st_size > MAX_SETTINGS:
        raise FaceZipError(ErrorCode.TOO_LARGE, f"{path}: larger than {MAX_SETTINGS} bytes")
    try:
        return tomllib.loads(path.read_bytes().decode())
    except (ValueError, RecursionError) as error:
        raise _bad(path, error) from None


def _name(document: Toml, key: str, fault: FaceZipError, refuse: Refuse) -> str | None:
    name = document.pop(key, None)
    if name is None or (isinstance(name, str) and name):
        return name
    refuse(fault)
    return None


def _bad(path: Path, why: object) -> FaceZipError:
    return FaceZipError(ErrorCode.BAD_CHARACTER, f"{path}: {why}")


def _patterns(document: Mapping[str, Any]) -> Patterns:
    if odd := {*document} - {"meshes", "mask", "maps"}:
        raise ValueError(
            f"'{min(odd)}' is not known; it holds neutral, meshes, mask, part, up, front, unit and [maps.NAME]"
        )
    maps = document.get("maps", {})
    if not isinstance(maps, dict) or not all(isinstance(entry, dict) for entry in maps.values()):
        raise ValueError("maps holds a table for each map, such as [maps.albedo]")
    stated = {name: _map_pattern(name, entry) for name, entry in maps.items()}
    return Patterns(document.get("meshes", "{name}.obj"), document.get("mask", MASK_FILE), stated)


def _map_pattern(name: str, entry: Mapping[str, Any]) -> MapPattern:
    known = KNOWN.get(name, Map(name, "data"))
    stated: Toml = {"files": None, "encoding": known.encoding, "float": False, "green": "up"}
    if not is_map_name(name):
        raise ValueError(f"a map cannot be called '{name}'; use small letters, digits and _")
    if odd := {*entry} - {*stated}:
        raise ValueError(f"'{min(odd)}' of maps.{name} is not known; it has {', '.join(stated)}")
    stated |= entry
    encoding, keeps_floats, green = stated["encoding"], stated["float"], stated["green"]
    if encoding not in ENCODINGS or green not in ("up", "down") or not isinstance(keeps_floats, bool):
        raise ValueError(
            f"maps.{name}: encoding is one of {', '.join(ENCODINGS)}; green is up or down; float is true or false"
        )
    kind = Map(name, encoding, -1.0 if encoding == "normal" else 0.0, 1.0)
    return MapPattern(kind, stated["files"], keeps_floats, green == "down")
