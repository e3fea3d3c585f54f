"""The neutral of a map as the image that a pack stores: an ordinary albedo, roughness or normal map."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import Map
from facezip.files.images import Texels, as_texels, to_float
from facezip.machine.rows import by_rows


def packed_neutral(texels: Texels, kind: Map, bits: int) -> Texels:
    """Integers ``(H, W, C)``: t of the map's range; of a normal (n + 1) / 2, in three channels."""
    dtype, most = (np.uint8, np.float32(255)) if bits == 8 else (np.uint16, np.float32(65535))
    shape = (*texels.shape[:-1], 3) if kind.is_normal else texels.shape

    def packed(rows: slice) -> Texels:
        some = texels[rows]
        values = 0.5 * kind.decode(some) + 0.5 if kind.is_normal else to_float(some)
        return np.rint(np.clip(values, 0, 1) * most).astype(dtype)

    return by_rows(packed, shape, dtype)


def unpacked_neutral(stored: Texels, kind: Map) -> Texels:
    """Inverse of :func:`packed_neutral`; of a normal, z is rebuilt from x and y, as a GPU does from two channels."""
    if not kind.is_normal:
        return stored

    def unpacked(rows: slice) -> NDArray[np.float32]:
        across = 2 * to_float(stored[rows, :, :2]) - 1
        z = np.sqrt(np.maximum(1 - np.square(across).sum(axis=2, keepdims=True), 0))
        return kind.encode(np.concatenate([across, z], axis=2))

    return by_rows(unpacked, (*stored.shape[:2], 2), np.float32)


def as_packed(texels: Texels, kind: Map, bits: int) -> Texels:
    """Texels, of the same type, as a pack gives them back: what difference textures are best fitted to."""
    if not kind.is_normal:
        return texels
    return as_texels(to_float(unpacked_neutral(packed_neutral(texels, kind, bits), kind)), texels.dtype)


def neutral_bits(dtype: np.dtype[Any], is_normal: bool) -> int:
    """Bits a channel that keep what a file held, by the type of its texels."""
    return 8 if dtype.itemsize == 1 or (is_normal and dtype.kind == "u") else 16
