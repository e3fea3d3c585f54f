"""Reading ``manifest.json`` of any version: its own checksum first, then strict JSON, then the range of every field."""

import hashlib
import json
import math
import re
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

from facezip.errors import ErrorCode, FaceZipError
from facezip.files.packs import MANIFEST, START
from facezip.files.reading import reading
from facezip.names import one_form
from facezip.pack import version_1, version_2
from facezip.pack.checks import first_out_of_range
from facezip.pack.manifest import (
    FORMAT,
    HEAD_FILE,
    Fields,
    GeometryEntry,
    Manifest,
    MapEntry,
    MasksEntry,
    StoredFile,
    TextureEntry,
    TileEntry,
)

# A parsed list takes up to 30 times its text.
MAX_BYTES = 2 * 2**20

_SURROGATE = re.compile(rb"\\u[dD][89a-fA-F]")


def read_manifest(folder: Path) -> Manifest:
    """Read and check ``manifest.json`` of a pack.

    Raises
    ------
    FaceZipError
        ``MISSING_FILE`` without such a folder, ``DAMAGED_PACK`` where a byte is not as it was written, ``OTHER_FORMAT``
        for a version that this program does not read, ``BAD_PACK`` where there is no manifest or a field is outside
        its range, ``CANNOT_READ``.
    """
    with reading(folder / MANIFEST):
        content = _content(folder, folder / MANIFEST)
        _check_own_checksum(folder, content)
    try:
        document = _parsed(content)
        version = _version(folder, document.pop("format"))
        del document["sha256"]
        manifest = manifest_of(version(frozen(document)))
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError, IndexError) as error:
        raise bad_pack(folder, f"{MANIFEST} is not valid ({error})") from None
    wrong = first_out_of_range(manifest)
    if wrong:
        raise bad_pack(folder, f"'{wrong}' in {MANIFEST} is out of range")
    # Packs of earlier versions may hold names as a file system wrote them.
    expressions = tuple(map(one_form, manifest.expressions))
    return replace(manifest, expressions=expressions, name=manifest.name or folder.resolve().stem)


def bad_pack(folder: Path, reason: str) -> FaceZipError:
    """The error for what the format does not allow."""
    return FaceZipError(ErrorCode.BAD_PACK, f"{folder}: not a usable pack: {reason}")


def damaged_pack(folder: Path, reason: str) -> FaceZipError:
    """The error for bytes that are not as they were written."""
    return FaceZipError(ErrorCode.DAMAGED_PACK, f"{folder}: not a usable pack: {reason}; restore it or compress again")


def manifest_of(document: Fields) -> Manifest:
    """A manifest of version 3's document, lists as tuples; ValueError, TypeError or KeyError for any other."""
    known = {each.name for each in fields(Manifest)}
    odd = {*document} ^ known
    if odd - {"masks"}:
        first = min(odd - {"masks"})
        raise ValueError(f"field '{first}' is {'missing' if first in known else 'unknown'}")
    document = dict(document)
    geometry, masks = document.pop("geometry"), document.pop("masks", None)
    return Manifest(
        maps=tuple(MapEntry(**entry) for entry in document.pop("maps")),
        tiles=tuple(_tile(dict(entry)) for entry in document.pop("tiles")),
        geometry=None if geometry is None else GeometryEntry(**geometry),
        masks=None if masks is None else MasksEntry(**masks),
        files={name: StoredFile(**entry) for name, entry in document.pop("files").items()},
        **document,
    )


def frozen(value: Any) -> Any:
    """Lists as tuples, all the way down."""
    if isinstance(value, dict):
        return {key: frozen(item) for key, item in value.items()}
    return tuple(frozen(item) for item in value) if isinstance(value, list) else value


def _tile(entry: Fields) -> TileEntry:
    textures = tuple(TextureEntry(**texture) for texture in entry.pop("textures"))
    return TileEntry(textures=textures, **entry)


def _content(folder: Path, path: Path) -> bytes:
    if not folder.is_dir():
        what = "is a file, and no pack" if folder.exists() else "no such pack"
        raise FaceZipError(ErrorCode.MISSING_FILE, f"{folder}: {what}; give a folder NAME.facezip")
    if path.is_symlink() or not path.is_file():
        raise bad_pack(folder, f"no {MANIFEST} in it; give the folder that 'facezip compress' wrote")
    with open(path, "rb") as file:
        content = file.read(MAX_BYTES + 1)
    if len(content) > MAX_BYTES:
        raise bad_pack(folder, f"{MANIFEST} is larger than {MAX_BYTES} bytes")
    return content


def _check_own_checksum(folder: Path, content: bytes) -> None:
    match = START.match(content)
    if match is None:
        raise damaged_pack(folder, f"{MANIFEST} does not begin with its checksum and format")
    blank = content[: match.start(1)] + b"0" * 64 + content[match.end(1) :]
    if hashlib.sha256(blank).hexdigest().encode() != match.group(1):
        raise damaged_pack(folder, f"{MANIFEST} was changed or damaged after it was written")


def _parsed(content: bytes) -> Fields:
    """The JSON, in UTF-8 and nothing but: no key twice, no number that is none, no half of a surrogate pair."""
    document: Fields = json.loads(
        content.decode(), object_pairs_hook=_object, parse_float=_number, parse_constant=_number
    )
    if _SURROGATE.search(content):
        json.dumps(document, ensure_ascii=False).encode()
    return document


def _object(pairs: list[tuple[str, Any]]) -> Fields:
    document = dict(pairs)
    if len(document) < len(pairs):
        raise ValueError("a key stands there twice")
    return document


def _number(text: str) -> float:
    number = float(text)
    if not math.isfinite(number):
        raise ValueError(f"{text} is not a finite number")
    return number


def _of_version_3(document: Fields) -> Fields:
    if document["geometry"] is not None and document["geometry"]["files"] != (HEAD_FILE,):
        raise ValueError(f"its meshes are not in '{HEAD_FILE}'")
    return document


# By the format that a file states: its document as that of version 3.
VERSIONS: dict[str, Callable[[Fields], Fields]] = {
    version_1.FORMAT: version_1.as_version_3,
    version_2.FORMAT: version_2.as_version_3,
    FORMAT: _of_version_3,
}


def _version(folder: Path, stated: Any) -> Callable[[Fields], Fields]:
    if stated not in VERSIONS:
        raise FaceZipError(
            ErrorCode.OTHER_FORMAT,
            f"{folder}: its format is '{stated}', this program reads '{version_1.FORMAT}' to '{FORMAT}'; update "
            "facezip",
        )
    return VERSIONS[stated]
