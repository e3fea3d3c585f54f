"""The transfer function of sRGB (IEC 61966-2-1), between linear light and what 8-bit textures store."""

import numpy as np
from numpy.typing import NDArray


def encode_srgb(linear: NDArray[np.float32]) -> NDArray[np.float32]:
    """sRGB opto-electronic transfer function (IEC 61966-2-1) on linear values in [0, 1]."""
    high = 1.055 * np.power(np.maximum(linear, 0.0031308), 1 / 2.4) - 0.055
    return np.where(linear <= 0.0031308, linear * 12.92, high).astype(np.float32)


def decode_srgb(encoded: NDArray[np.float32]) -> NDArray[np.float32]:
    """Inverse of :func:`encode_srgb`: encoded values in [0, 1] to linear ones."""
    high = np.power((np.maximum(encoded, 0.04045) + 0.055) / 1.055, 2.4)
    return np.where(encoded <= 0.04045, encoded / 12.92, high).astype(np.float32)
