"""What ``validate`` renders of a character, with any maps and tiles, and what it judges: packs, or other characters."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from facezip.character.atlas import Atlas
from facezip.character.folder import load_surface
from facezip.character.maps import ALBEDO, MapKind
from facezip.character.scans import NEUTRAL, Character
from facezip.character.surface import Surface
from facezip.errors import ErrorCode, FaceZipError
from facezip.pack.errors import surface_errors, texture_surface_errors
from facezip.pack.facts import pack_facts
from facezip.pack.surface_footprint import SurfaceFootprint
from facezip.pack.surface_manifest import read_any_manifest
from facezip.pack.surface_model import CompressedSurface
from facezip.pack.version_1 import is_pack
from facezip.pack.version_2 import read_surface

if TYPE_CHECKING:
    from render.skins import SkinMaps
    from render.validation import Candidate

# Gives a map on a tile for an expression: values, as of MapKind.
Values = Callable[[MapKind, int, str], NDArray[np.float32]]


def staged_character(surface: Surface) -> Character:
    """The meshes of a surface, with the UV layout of all its tiles in one square."""
    return replace(surface.whole, topology=Atlas.of(surface.tiles).topology(surface.topology))


def staged_original(surface: Surface) -> "Callable[[str], SkinMaps]":
    """What is rendered of the scans, by the name of an expression or ``neutral``."""

    def values(kind: MapKind, tile: int, name: str) -> NDArray[np.float32]:
        return kind.values(surface.parts[kind.name, tile].texture(name))

    return _skin(surface, values)


def candidate(surface: Surface, path: Path) -> "Candidate":
    """A pack, or a second character in its place: textures that another tool made are judged the same way.

    Raises
    ------
    FaceZipError
        What the readers raise, and ``UNKNOWN_NAME`` or ``SIZE_MISMATCH`` where it does not belong to ``surface``.
    """
    from render.validation import Candidate

    if not path.exists():
        reason = "no such pack or character; give a NAME.facezip or the folder of a character"
        raise FaceZipError(ErrorCode.MISSING_FILE, f"{path}: {reason}")
    if is_pack(path):
        model = read_surface(path)
        _check_same(surface, path, model)
        errors = surface_errors(surface, model)
        facts = pack_facts(path, read_any_manifest(path))
        return Candidate(path.stem, _skin(surface, _of_model(model)), {**facts, **_errors(surface, errors)})
    other = load_surface(path)
    _check_same(surface, path, other)
    cost = SurfaceFootprint.of_scans(other)
    raw, blocks = cost.bytes_raw, cost.bytes_raw_bc7
    facts = {"method": "textures", "bytes_on_gpu": raw, "bytes_on_disk": None, "bytes_raw": raw, "fetches": None}
    facts |= {"bytes_bc7": blocks, "bytes_raw_bc7": blocks}
    errors = texture_surface_errors(surface, other)
    return Candidate(other.whole.name, staged_original(other), {**facts, **_errors(surface, errors)})


def _of_model(model: CompressedSurface) -> Values:
    def values(kind: MapKind, tile: int, name: str) -> NDArray[np.float32]:
        return model.blend(kind, tile, {} if name == NEUTRAL else {name: 1.0})

    return values


def _skin(surface: Surface, values: Values) -> "Callable[[str], SkinMaps]":
    from render.skins import RENDERED, SkinMaps

    atlas, kinds = Atlas.of(surface.tiles), [kind for kind in surface.maps if kind.name in RENDERED]

    def skin(name: str) -> "SkinMaps":
        joined = {kind.name: atlas.joined({tile: values(kind, tile, name) for tile in surface.tiles}) for kind in kinds}
        return SkinMaps(**joined)

    return skin


def _errors(surface: Surface, errors: dict[str, dict[str, Any]]) -> dict[str, Any]:
    albedo = errors[ALBEDO]
    found = {"texture_rmse": albedo["rmse"], "texture_rmse_per_expression": albedo["rmse_per_expression"]}
    return found if surface.ordinary else {**found, "map_errors": errors}


def _check_same(surface: Surface, path: Path, other: Surface | CompressedSurface) -> None:
    whole = surface.whole
    missing = [name for name in whole.expressions if name not in other.whole.expressions]
    if missing:
        raise FaceZipError(
            ErrorCode.UNKNOWN_NAME, f"{path}: has no expression '{missing[0]}'; was it made from {whole.name}?"
        )
    for (name, tile), part in surface.parts.items():
        theirs = other.parts.get((name, tile))
        if theirs is None or theirs.neutral.shape != part.neutral.shape:
            found = (
                "is missing" if theirs is None else f"has {theirs.neutral.shape[1]}x{theirs.neutral.shape[0]} texels"
            )
            raise FaceZipError(
                ErrorCode.SIZE_MISMATCH,
                f"{path}: its {name} on tile {tile} {found}, {whole.name} has "
                f"{part.neutral.shape[1]}x{part.neutral.shape[0]}; compress it again",
            )
