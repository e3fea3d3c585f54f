"""What errors of maps do to one image, to first order, as weights of their squares: see :mod:`render.importance`."""

import numpy as np
from numpy.typing import NDArray

from facezip.files.srgb import decode_srgb
from render.operator import Channels, ImageOperator


def squared_error_weight(operator: ImageOperator, encoded: NDArray[np.float32]) -> NDArray[np.float32]:
    """Jᵀ J 1 of one image, over its number of head pixels and channels, summed over channels: ``(h, w)`` ≥ 0.

    Parameters
    ----------
    operator : of the image.
    encoded : ``(h, w, 3)`` texture in [0, 1], about which the error is small.
    """
    slope, (shown, values) = _decode_slope(encoded), display_slope(operator, encoded)
    weights = slope * operator.transposed(np.square(shown) * operator.apply(slope))
    total: NDArray[np.float32] = weights.sum(axis=2) / np.float32(values)
    return total


def slope_weight(matrices: Channels, shown: NDArray[np.float32]) -> NDArray[np.float32]:
    """|A|ᵀ S² |A| 1 of one channel of a map, summed over colour channels: ``(h · w,)`` ≥ 0.

    Parameters
    ----------
    matrices : A, of :func:`render.operator.map_slopes`.
    shown : S, ``(H, W, 3)``, what a display makes of a small change of a pixel's radiance.
    """
    squares = np.square(shown).reshape(-1, 3)
    total = np.zeros(matrices[0].shape[1], np.float32)
    for channel, matrix in enumerate(matrices):
        answers = abs(matrix)
        total += answers.T @ (squares[:, channel] * answers.sum(axis=1))
    return total


def display_slope(operator: ImageOperator, encoded: NDArray[np.float32]) -> tuple[NDArray[np.float32], int]:
    """The slope of the display at every value ``(H, W, 3)`` of an image, 0 beside the head; how many are on it."""
    head = operator.coverage >= 0.5
    shown = _encode_slope(operator.image(decode_srgb(encoded))) * head[:, :, None]
    return shown, max(3 * int(head.sum()), 1)


def _decode_slope(encoded: NDArray[np.float32]) -> NDArray[np.float32]:
    """Derivative of :func:`facezip.files.srgb.decode_srgb`."""
    high = 2.4 / 1.055 * np.power((np.maximum(encoded, 0.04045) + 0.055) / 1.055, 1.4)
    return np.where(encoded <= 0.04045, 1 / 12.92, high).astype(np.float32)


def _encode_slope(linear: NDArray[np.float32]) -> NDArray[np.float32]:
    """Derivative of what a display shows: of clipping to [0, 1] and :func:`facezip.files.srgb.encode_srgb`."""
    high = 1.055 / 2.4 * np.power(np.maximum(linear, 0.0031308), 1 / 2.4 - 1)
    slope = np.where(linear <= 0.0031308, 12.92, high)
    return np.where((linear < 0) | (linear > 1), 0, slope).astype(np.float32)
