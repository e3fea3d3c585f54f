"""The neutral of a map as the image that a pack stores: an ordinary albedo, roughness or normal map."""

from typing import Any

import numpy as np

from facezip.surface.maps import MapKind
from facezip.textures import Texels, to_float


def packed_neutral(fitted: Texels, kind: MapKind, bits: int) -> Texels:
    """Integers ``(H, W, C)``: t of the map's range; of a normal (n + 1) / 2, in three channels."""
    texels = 0.5 * kind.values(fitted) + 0.5 if kind.is_normal else to_float(fitted)
    most = 2**bits - 1
    return np.rint(np.clip(texels, 0, 1) * np.float32(most)).astype(np.uint8 if bits == 8 else np.uint16)


def unpacked_neutral(stored: Texels, kind: MapKind) -> Texels:
    """Inverse of :func:`packed_neutral`; of a normal, z is rebuilt from x and y, as a GPU does from two channels."""
    if not kind.is_normal:
        return stored
    across = 2 * to_float(stored[..., :2]) - 1
    z = np.sqrt(np.maximum(1 - np.square(across).sum(axis=2, keepdims=True), 0))
    return kind.fitted(np.concatenate([across, z], axis=2))


def as_packed(fitted: Texels, kind: MapKind, bits: int) -> Texels:
    """Fitted texels, of the same type, as a pack gives them back: what difference textures are best fitted to."""
    if not kind.is_normal:
        return fitted
    back = unpacked_neutral(packed_neutral(fitted, kind, bits), kind)
    return np.rint(back * np.float32(65535)).astype(np.uint16) if fitted.dtype.kind == "u" else back


def neutral_bits(dtype: np.dtype[Any], is_normal: bool) -> int:
    """Bits a channel that keep what a file held, by the type of the fitted texels."""
    return 8 if dtype.itemsize == 1 or (is_normal and dtype.kind == "u") else 16
