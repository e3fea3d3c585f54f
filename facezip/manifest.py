"""``manifest.json``: what a pack holds, with a range for every field and a checksum over all bytes, its own too."""

import hashlib
import json
import math
import re
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from facezip.errors import ErrorCode, FaceZipError
from facezip.footprint import Footprint
from facezip.textures import MAX_SIDE

FORMAT = "facezip-pack/1"
FILE_NAME = "manifest.json"
MAX_BYTES = 16 * 2**20
MAX_EXPRESSIONS = 4096
MAX_DIFFERENCES = 8

_CHECKSUM = re.compile(rb'^\{\n "sha256": "([0-9a-f]{64})"')
_NAME = re.compile(r"[^/\\:\x00-\x1f\x7f]{1,128}")


@dataclass(frozen=True)
class StoredFile:
    """Length in bytes and SHA-256 (hexadecimal) of one file of the pack."""

    bytes: int
    sha256: str


@dataclass(frozen=True)
class Manifest:
    """The fields of ``manifest.json``, checked against their ranges when it is read.

    Attributes
    ----------
    name : what the character is called.
    method : what fitted the textures.
    size : rows and columns of neutral and differences.
    channels, neutral_bits : channels of every texture; bits of a neutral channel (8 or 16).
    encoding : always ``srgb``: maps blend in encoded values and become linear last.
    expressions : N names in the order of the weight maps.
    difference_scale : R lists of C ranges; D = (t - 128/255) · scale.
    weight_size : rows and columns of one weight map; ``[1, 1]`` for uniform weights.
    weight_columns : weight maps per row of the atlas.
    weight_scale, weight_offset : R numbers each; W = t · scale + offset.
    uniform_weights : N lists of R numbers where weights are uniform, else empty.
    vertices, triangles, texture_coordinates : sizes of the meshes; zeros without.
    made_with : options and measured errors; for people, ignored by readers.
    files : every other file in the folder.
    """

    name: str
    method: str
    size: tuple[int, int]
    channels: int
    neutral_bits: int
    expressions: tuple[str, ...]
    difference_scale: tuple[tuple[float, ...], ...]
    weight_size: tuple[int, int]
    weight_columns: int
    weight_scale: tuple[float, ...]
    weight_offset: tuple[float, ...]
    uniform_weights: tuple[tuple[float, ...], ...]
    vertices: int
    triangles: int
    texture_coordinates: int
    made_with: dict[str, Any]
    files: dict[str, StoredFile]
    encoding: str = field(default="srgb")

    @property
    def footprint(self) -> Footprint:
        """Bytes and fetches at run time."""
        slots, count = len(self.difference_scale), len(self.expressions)
        return Footprint(self.size, self.channels, slots, count, self.weight_size)

    def to_bytes(self) -> bytes:
        """The file's content; its first field is the SHA-256 of all its bytes with that field's digits set to 0."""
        document = {"sha256": "0" * 64, "format": FORMAT, **asdict(self)}
        blank = json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False).encode() + b"\n"
        return blank.replace(b"0" * 64, hashlib.sha256(blank).hexdigest().encode(), 1)


def read_manifest(folder: Path) -> Manifest:
    """Read and check ``manifest.json``.

    Raises
    ------
    FaceZipError
        ``BAD_PACK``: missing, damaged, of a newer format, or a field outside its range.
    """
    path = folder / FILE_NAME
    if path.is_symlink() or not path.is_file():
        raise _bad(folder, f"no {FILE_NAME} in it; give the folder that 'facezip compress' wrote")
    if path.stat().st_size > MAX_BYTES:
        raise _bad(folder, f"{FILE_NAME} is larger than {MAX_BYTES} bytes")
    content = path.read_bytes()
    _check_own_checksum(folder, content)
    try:
        document = json.loads(content)
        stated = document.pop("format")
        del document["sha256"]
        if stated != FORMAT:
            raise _bad(folder, f"its format is '{stated}', this program reads '{FORMAT}'; update facezip")
        manifest = _from_document(document)
        _check_ranges(manifest)
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise _bad(folder, f"{FILE_NAME} is not valid ({error})") from None
    return manifest


def is_safe_name(name: str) -> bool:
    """Whether an expression's name can serve as a file name on every system."""
    return bool(_NAME.fullmatch(name)) and not name.startswith(".") and name == name.strip()


def _check_own_checksum(folder: Path, content: bytes) -> None:
    match = _CHECKSUM.match(content)
    if match is None:
        raise _bad(folder, f"{FILE_NAME} does not begin with its checksum; write the pack again")
    blank = content[: match.start(1)] + b"0" * 64 + content[match.end(1) :]
    if hashlib.sha256(blank).hexdigest().encode() != match.group(1):
        raise _bad(folder, f"{FILE_NAME} was changed or damaged after it was written; restore it or write it again")


def _from_document(document: dict[str, Any]) -> Manifest:
    files = {name: StoredFile(**entry) for name, entry in document.pop("files").items()}
    frozen = {key: _frozen(value) for key, value in document.items()}
    return Manifest(files=files, **frozen)


def _frozen(value: Any) -> Any:
    return tuple(_frozen(item) for item in value) if isinstance(value, list) else value


def _check_ranges(manifest: Manifest) -> None:
    slots, count = len(manifest.difference_scale), len(manifest.expressions)
    uniform = manifest.weight_size == (1, 1)
    numbers = (*manifest.weight_scale, *manifest.weight_offset, *_flat(manifest.difference_scale))
    checks = {
        "size": _is_size(manifest.size) and _is_size(manifest.weight_size),
        "channels": manifest.channels in (1, 2, 3, 4) and manifest.neutral_bits in (8, 16),
        "encoding": manifest.encoding == "srgb",
        "expressions": 1 <= count <= MAX_EXPRESSIONS and len({*manifest.expressions}) == count,
        "names": all(isinstance(name, str) and is_safe_name(name) for name in (*manifest.expressions, *manifest.files)),
        "difference_scale": 1 <= slots <= MAX_DIFFERENCES
        and all(len(row) == manifest.channels for row in manifest.difference_scale),
        "weight ranges": len(manifest.weight_scale) == len(manifest.weight_offset) == slots,
        "weight_columns": _is_count(manifest.weight_columns, 1, count),
        "uniform_weights": [len(row) for row in manifest.uniform_weights] == ([slots] * count if uniform else []),
        "numbers": all(_is_number(value) for value in (*numbers, *_flat(manifest.uniform_weights))),
        "mesh": all(
            _is_count(value, 0, 2**31 - 1)
            for value in (manifest.vertices, manifest.triangles, manifest.texture_coordinates)
        ),
        "files": all(_is_count(file.bytes, 0, 2**40) for file in manifest.files.values()),
    }
    failed = [name for name, passed in checks.items() if not passed]
    if failed:
        raise ValueError(f"'{failed[0]}' is out of range")


def _flat(rows: tuple[tuple[float, ...], ...]) -> tuple[float, ...]:
    return tuple(value for row in rows for value in row)


def _is_size(size: Any) -> bool:
    return isinstance(size, tuple) and len(size) == 2 and all(_is_count(side, 1, MAX_SIDE) for side in size)


def _is_count(value: Any, low: int, high: int) -> bool:
    return type(value) is int and low <= value <= high


def _is_number(value: Any) -> bool:
    return type(value) in (int, float) and math.isfinite(value)


def _bad(folder: Path, reason: str) -> FaceZipError:
    return FaceZipError(ErrorCode.BAD_PACK, f"{folder}: not a usable pack: {reason}")
