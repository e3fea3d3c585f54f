"""From float maps to the bytes that a pack stores and a GPU samples, and back."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facezip.model import CompressedTextures, Meshes
from facezip.textures import Texels, to_float

# Zero is this byte exactly, so that texels which no expression changes stay untouched.
ZERO = 128


@dataclass(frozen=True, eq=False)
class QuantisedMaps:
    """The maps of a pack as integers, with the ranges that turn texels t = byte / 255 back into values.

    Attributes
    ----------
    neutral : ``(H, W, C)`` uint8 or uint16.
    differences : ``(R, H, W, C)`` uint8; D = (t - 128/255) · ``difference_scale``.
    difference_scale : ``(R, C)`` float32, one range a texture and channel.
    weights : ``(N, h, w, R)`` uint8, W = t · ``weight_scale`` + ``weight_offset``; or float32 ``(N, 1, 1, R)`` as they
        are where weights are uniform: those are shader constants, not texels.
    weight_scale, weight_offset : ``(R,)`` float32, one range a slot; 1 and 0 for uniform weights.
    """

    neutral: Texels
    differences: NDArray[np.uint8]
    difference_scale: NDArray[np.float32]
    weights: NDArray[np.uint8] | NDArray[np.float32]
    weight_scale: NDArray[np.float32]
    weight_offset: NDArray[np.float32]

    @property
    def uniform(self) -> bool:
        """Whether every weight map is a single number (PCA)."""
        return self.weights.shape[1:3] == (1, 1)


def quantise(model: CompressedTextures, neutral_bits: int = 8) -> QuantisedMaps:
    """Round a model to 8 bits a channel (the neutral to 8 or 16), each range stretched to use them fully."""
    difference_scale = np.abs(model.differences).max(axis=(1, 2)) * np.float32(255 / 127)
    steps = _divide(model.differences, difference_scale[:, None, None, :]) * np.float32(255)
    differences = (np.rint(steps) + ZERO).astype(np.uint8)
    return QuantisedMaps(
        _quantise_neutral(model.neutral, neutral_bits), differences, difference_scale, *_weights(model)
    )


def dequantise(
    maps: QuantisedMaps, expressions: tuple[str, ...], method: str, meshes: Meshes | None
) -> CompressedTextures:
    """The model that a reader of the stored maps sees; inverse of :func:`quantise` up to rounding."""
    differences = maps.differences.astype(np.float32)
    differences -= np.float32(ZERO)
    differences *= (maps.difference_scale / np.float32(255))[:, None, None, :]
    weights = maps.weights.astype(np.float32)
    if not maps.uniform:
        weights = weights * (maps.weight_scale / np.float32(255)) + maps.weight_offset
    return CompressedTextures(to_float(maps.neutral), differences, weights, expressions, method, meshes)


def _quantise_neutral(neutral: NDArray[np.float32], bits: int) -> Texels:
    if bits == 16:
        wide: NDArray[np.uint16] = np.rint(neutral * np.float32(65535)).astype(np.uint16)
        return wide
    return _round(neutral)


def _weights(
    model: CompressedTextures,
) -> tuple[NDArray[np.uint8] | NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]:
    weights = model.weights
    slots = weights.shape[3]
    if weights.shape[1:3] == (1, 1):
        return weights, np.ones(slots, np.float32), np.zeros(slots, np.float32)
    offset = weights.min(axis=(0, 1, 2))
    scale = weights.max(axis=(0, 1, 2)) - offset
    return _round(_divide(weights - offset, scale)), scale, offset


def _round(values: NDArray[np.float32]) -> NDArray[np.uint8]:
    rounded: NDArray[np.uint8] = np.rint(values * np.float32(255)).astype(np.uint8)
    return rounded


def _divide(values: NDArray[np.float32], scale: NDArray[np.float32]) -> NDArray[np.float32]:
    """``values / scale``; where the range is empty the values are zero and stay so."""
    return np.divide(values, np.where(scale > 0, scale, 1), dtype=np.float32)
