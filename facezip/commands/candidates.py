"""What ``validate`` judges: packs, or other characters with the same expressions."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from facezip.character import Character, load_character
from facezip.commands.facts import pack_facts
from facezip.errors import ErrorCode, FaceZipError
from facezip.footprint import Footprint
from facezip.manifest import read_manifest
from facezip.measure import mean_rmse, texture_errors
from facezip.pack import is_pack, read_pack

if TYPE_CHECKING:
    from render.validation import Candidate


def candidate(scans: Character, path: Path) -> "Candidate":
    """A pack, or a second character in its place: textures that another tool made are judged the same way.

    Raises
    ------
    FaceZipError
        What the readers raise, and ``UNKNOWN_NAME`` or ``SIZE_MISMATCH`` where it does not belong to ``scans``.
    """
    if is_pack(path):
        model = read_pack(path)
        _check_same(scans, path, model.expressions, model.neutral.shape)
        return _candidate(path.stem, scans, model.reconstruct, pack_facts(path, read_manifest(path)))
    other = load_character(path)
    _check_same(scans, path, other.expressions, other.neutral.shape)
    size, channels = other.resolution, other.neutral.shape[2]
    raw = Footprint(size, channels, 0, len(other.expressions), (1, 1)).bytes_raw
    facts = {"method": "textures", "bytes_on_gpu": raw, "bytes_on_disk": None, "bytes_raw": raw, "fetches": None}
    return _candidate(other.name, scans, other.texture, facts)


def _candidate(
    name: str, scans: Character, texture: Callable[[str], NDArray[np.float32]], facts: dict[str, Any]
) -> "Candidate":
    from render.validation import Candidate

    errors = texture_errors(scans, texture)
    return Candidate(name, texture, {**facts, "texture_rmse": mean_rmse(errors), "texture_rmse_per_expression": errors})


def _check_same(scans: Character, path: Path, expressions: tuple[str, ...], shape: tuple[int, ...]) -> None:
    missing = [name for name in scans.expressions if name not in expressions]
    if missing:
        raise FaceZipError(
            ErrorCode.UNKNOWN_NAME, f"{path}: has no expression '{missing[0]}'; was it made from {scans.name}?"
        )
    if shape != scans.neutral.shape:
        raise FaceZipError(
            ErrorCode.SIZE_MISMATCH,
            f"{path}: textures of {_size(shape)}, {scans.name} has {_size(scans.neutral.shape)}; compress it again",
        )


def _size(shape: tuple[int, ...]) -> str:
    return f"{shape[1]}x{shape[0]} and {shape[2]} channels"
