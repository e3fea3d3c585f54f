"""``manifest.json``: what a pack holds, with a range for every field and a checksum over all bytes, its own too."""

import hashlib
import json
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from facezip.errors import ErrorCode, FaceZipError
from facezip.files.reading import reading
from facezip.pack.footprint import Footprint
from facezip.pack.ranges import first_out_of_range

if TYPE_CHECKING:
    from facezip.pack.surface_manifest import AnyManifest

FORMAT = "facezip-pack/1"
# Several maps or tiles: facezip.surface.manifest.
LAYERED = "facezip-pack/2"
FILE_NAME = "manifest.json"
# A parsed list takes up to 30 times its text.
MAX_BYTES = 2 * 2**20

_START = re.compile(rb'\{\n "sha256": "([0-9a-f]{64})",\n "format": "facezip-pack/')
_SURROGATE = re.compile(rb"\\u[dD][89a-fA-F]")


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
    name : what the character is called; where the file says nothing, the stem of the folder's name.
    method : what fitted the textures; for people.
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
        return signed(FORMAT, asdict(self))


Kind = TypeVar("Kind", bound="AnyManifest")
# By the format that a file states: its fields as a manifest, and the first of them that is out of range.
Versions = Mapping[str, tuple[Callable[[dict[str, Any]], Kind], Callable[[Kind], str | None]]]


def signed(format_: str, document: dict[str, Any]) -> bytes:
    """A manifest's content: its format and fields behind the SHA-256 of all its bytes with those digits set to 0."""
    whole = {"sha256": "0" * 64, "format": format_, **document}
    blank = json.dumps(whole, indent=1, ensure_ascii=False, allow_nan=False).encode() + b"\n"
    return blank.replace(b"0" * 64, hashlib.sha256(blank).hexdigest().encode(), 1)


def read_manifest(folder: Path) -> Manifest:
    """Read and check ``manifest.json`` of a pack of one albedo.

    Raises
    ------
    FaceZipError
        ``MISSING_FILE`` without such a folder, ``DAMAGED_PACK`` where a byte is not as it was written, ``OTHER_FORMAT``
        for a version that this function does not read, ``BAD_PACK`` where there is no manifest or a field is outside
        its range, ``CANNOT_READ``.
    """
    return read_version(folder, VERSION)


def read_version(folder: Path, versions: Versions[Kind]) -> Kind:
    """Read and check ``manifest.json`` of one of some versions; raises as :func:`read_manifest`."""
    path = folder / FILE_NAME
    with reading(folder):
        content = _content(folder, path)
    _check_own_checksum(folder, content)
    try:
        document = _parsed(content)
        build, first_out = _version(folder, versions, document.pop("format"))
        del document["sha256"]
        manifest = build(document)
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise bad_pack(folder, f"{FILE_NAME} is not valid ({error})") from None
    wrong = first_out(manifest)
    if wrong:
        raise bad_pack(folder, f"'{wrong}' in {FILE_NAME} is out of range")
    return manifest if manifest.name else replace(manifest, name=folder.resolve().stem)


def begins_like_a_manifest(path: Path) -> bool:
    """Whether a file starts as the manifest of some version of the format does; damage further down is not seen."""
    if path.is_symlink() or not path.is_file():
        return False
    with open(path, "rb") as file:
        return _START.match(file.read(256)) is not None


def bad_pack(folder: Path, reason: str) -> FaceZipError:
    """The error for what the format does not allow."""
    return FaceZipError(ErrorCode.BAD_PACK, f"{folder}: not a usable pack: {reason}")


def damaged_pack(folder: Path, reason: str) -> FaceZipError:
    """The error for bytes that are not as they were written."""
    return FaceZipError(ErrorCode.DAMAGED_PACK, f"{folder}: not a usable pack: {reason}; restore it or compress again")


def _content(folder: Path, path: Path) -> bytes:
    if not folder.is_dir():
        raise FaceZipError(ErrorCode.MISSING_FILE, f"{folder}: no such pack; give a folder NAME.facezip")
    if path.is_symlink() or not path.is_file():
        raise bad_pack(folder, f"no {FILE_NAME} in it; give the folder that 'facezip compress' wrote")
    with open(path, "rb") as file:
        content = file.read(MAX_BYTES + 1)
    if len(content) > MAX_BYTES:
        raise bad_pack(folder, f"{FILE_NAME} is larger than {MAX_BYTES} bytes")
    return content


def _check_own_checksum(folder: Path, content: bytes) -> None:
    match = _START.match(content)
    if match is None:
        raise damaged_pack(folder, f"{FILE_NAME} does not begin with its checksum and format")
    blank = content[: match.start(1)] + b"0" * 64 + content[match.end(1) :]
    if hashlib.sha256(blank).hexdigest().encode() != match.group(1):
        raise damaged_pack(folder, f"{FILE_NAME} was changed or damaged after it was written")


def _parsed(content: bytes) -> dict[str, Any]:
    """The JSON, in UTF-8 and nothing but: no key twice, no number that is none, no half of a surrogate pair."""
    document: dict[str, Any] = json.loads(
        content.decode(), object_pairs_hook=_object, parse_float=_number, parse_constant=_number
    )
    if _SURROGATE.search(content):
        json.dumps(document, ensure_ascii=False).encode()
    return document


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    document = dict(pairs)
    if len(document) < len(pairs):
        raise ValueError("a key stands there twice")
    return document


def _number(text: str) -> float:
    number = float(text)
    if not math.isfinite(number):
        raise ValueError(f"{text} is not a finite number")
    return number


def _version(folder: Path, versions: Versions[Kind], stated: Any) -> Any:
    if stated in versions:
        return versions[stated]
    if stated == LAYERED:
        reason = "holds several maps or tiles; decompress, info, verify, validate and export to engines take it, this"
        raise FaceZipError(ErrorCode.OTHER_FORMAT, f"{folder}: {reason} takes one albedo on one tile")
    raise FaceZipError(
        ErrorCode.OTHER_FORMAT,
        f"{folder}: its format is '{stated}', this program reads '{FORMAT}' and '{LAYERED}'; update facezip",
    )


def _from_document(document: dict[str, Any]) -> Manifest:
    return Manifest(**with_files(document, Manifest))


def with_files(document: dict[str, Any], kind: type[Any]) -> dict[str, Any]:
    """The fields of a manifest, all of them and no others, with lists as tuples."""
    odd = {*document} ^ {each.name for each in fields(kind)}
    if odd:
        raise ValueError(f"field '{min(odd)}' is {'unknown' if min(odd) in document else 'missing'}")
    files = {name: StoredFile(**entry) for name, entry in document.pop("files").items()}
    return {"files": files, **{key: frozen(value) for key, value in document.items()}}


def frozen(value: Any) -> Any:
    """Lists of lists as tuples."""
    return tuple(frozen(item) for item in value) if isinstance(value, list) else value


VERSION: Versions[Manifest] = {FORMAT: (_from_document, first_out_of_range)}
