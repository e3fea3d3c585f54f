"""Reading one texture of a map, some rows at a time: from what the file stores to the numbers that are fitted."""

from itertools import takewhile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.character.layout import MapFiles
from facezip.character.maps import MAX_RANGE, MAX_SLOPE
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.decoding import Bands, decoded_bands
from facezip.files.images import encode_srgb
from facezip.machine.rows import BLOCK

# Shallower is 84° or more.
LEAST_Z = 1 / (1 + MAX_SLOPE**2) ** 0.5
# Normals of 8 bits lose nothing in 16 bits of slope, and take half the memory of floats.
_NARROW = np.uint16(65535)


def value_rows(path: Path, how: MapFiles) -> Bands:
    """The rows of a texture of colours or data: integers as stored, floats as values (colours encoded).

    Raises
    ------
    FaceZipError
        What :mod:`facezip.files.decoding` raises; ``BAD_TEXELS`` for NaN, infinite or huge values, for those outside
        [0, 1] unless the map keeps them, and for data whose channels differ.
    """
    low, high = np.inf, -np.inf
    for top, height, texels in _decoded(path):
        stored = _without_alpha(texels)
        if how.kind.encoding == "data":
            stored = _one_channel(path, stored)
        if stored.dtype.kind == "u":
            yield top, height, stored if stored.itemsize <= 2 else (stored >> 16).astype(np.uint16)
            continue
        values = _finite(path, top, stored)
        low, high = min(low, float(values.min())), max(high, float(values.max()))
        yield top, height, encode_srgb(values) if how.kind.encoding == "srgb" else values
    if not how.keeps_floats and (low < 0 or high > 1):
        raise FaceZipError(
            ErrorCode.BAD_TEXELS,
            f"{path}: values from {low:.3g} to {high:.3g}; rescale them to 0..1, or keep them with --float",
        )


def normal_rows(path: Path, how: MapFiles, signed: bool, seen: NDArray[np.bool_]) -> Bands:
    """The rows of a normal map as fitted slopes ``(H, W, 2)``: uint16 of 8-bit files, else float32.

    Parameters
    ----------
    path, how : which.
    signed : whether floats are components in [-1, 1]; otherwise (v + 1) / 2, as integers are.
    seen : ``(H, W)``, of the image's size: texels that matter. Others may hold what they like; where that is no normal,
        they become flat.

    Raises
    ------
    FaceZipError
        What :func:`facezip.files.decoding.decode` raises; ``BAD_TEXELS`` for what is no normal or steeper than 84°.
    """
    for top, height, stored in _decoded(path):
        if stored.shape[2] == 1:
            raise FaceZipError(ErrorCode.BAD_TEXELS, f"{path}: one channel; a normal map has x, y and z, or x and y")
        vectors = _vectors(path, top, stored[:, :, :3], signed)
        if how.green_down:
            vectors[..., 1] *= -1
        steep = vectors[..., 2] < LEAST_Z
        wrong = steep & seen[top : top + len(steep)]
        if wrong.any():
            row, column = np.argwhere(wrong)[0]
            raise FaceZipError(
                ErrorCode.BAD_TEXELS,
                f"{path}: no normal, or steeper than 84 degrees, at column {column}, row {top + row}; give a "
                "tangent-space normal map, or leave such texels out of the mask",
            )
        vectors[steep] = (0, 0, 1)
        fitted = how.kind.encode(vectors)
        yield top, height, np.rint(fitted * _NARROW).astype(np.uint16) if stored.dtype.itemsize == 1 else fitted


def states_signs(path: Path) -> bool:
    """Whether the floats of a normal map are components in [-1, 1]: then some of them are negative."""
    floats = takewhile(lambda rows: rows[2].dtype.kind == "f", _decoded(path))
    return any(bool(stored.min() < -0.01) for _, _, stored in floats)


def _decoded(path: Path) -> Bands:
    """An image as it is stored, so few rows at a time that several copies of them as floats may be made."""
    for first, height, band in decoded_bands(path):
        for top in range(0, len(band), BLOCK):
            yield first + top, height, band[top : top + BLOCK]


def _vectors(path: Path, top: int, stored: NDArray[Any], signed: bool) -> NDArray[np.float32]:
    values = _finite(path, top, stored) if stored.dtype.kind == "f" else stored / np.float32(np.iinfo(stored.dtype).max)
    if not (signed and stored.dtype.kind == "f"):
        values = 2 * values - 1
    if values.shape[2] == 2:
        rest = np.maximum(1 - np.square(values).sum(axis=2, keepdims=True), 0)
        values = np.concatenate([values, np.sqrt(rest)], axis=2)
    length = np.sqrt(np.square(values).sum(axis=2, keepdims=True))
    vectors: NDArray[np.float32] = (values / np.maximum(length, 1e-6)).astype(np.float32)
    return vectors


def _without_alpha(stored: NDArray[Any]) -> NDArray[Any]:
    return stored[:, :, :-1] if stored.shape[2] in (2, 4) else stored


def _one_channel(path: Path, stored: NDArray[Any]) -> NDArray[Any]:
    first = stored[:, :, :1]
    if stored.shape[2] > 1 and not (stored == first).all():
        raise FaceZipError(
            ErrorCode.BAD_TEXELS, f"{path}: its channels differ; a map of one number a texel is grey, export it so"
        )
    return first


def _finite(path: Path, top: int, stored: NDArray[Any]) -> NDArray[np.float32]:
    with np.errstate(over="ignore"):
        values: NDArray[np.float32] = stored.astype(np.float32)
    wrong = ~(np.abs(values) <= MAX_RANGE)
    if wrong.any():
        row, column = np.argwhere(wrong.any(axis=2))[0]
        where = f"column {column}, row {top + row}"
        raise FaceZipError(
            ErrorCode.BAD_TEXELS,
            f"{path}: NaN, infinite or huge value at {where}; repaint or export that texel again",
        )
    return values
