"""What a fit sees of a character: texels as stored, and how much each one counts."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facezip.character import Character
from facezip.errors import ErrorCode, FaceZipError
from facezip.fragments import texel_scale
from facezip.textures import Texels

# What a fit gives to texels off the mask: ears and necks are seen too, and that little costs the face nothing.
BESIDE_THE_FACE = 0.03


@dataclass(frozen=True, eq=False)
class Samples:
    """Texels and their weights.

    Attributes
    ----------
    textures : ``(N, H, W, C)`` uint8, uint16 or float32.
    neutral : ``(H, W, C)`` of the same type.
    scale : factor from stored differences to values in [0, 1].
    importance : ``(H, W)`` float32 ≥ 0, the weight of a texel's squared error.
    """

    textures: Texels
    neutral: Texels
    scale: np.float32
    importance: NDArray[np.float32]


def samples_of(character: Character, importance: NDArray[np.float32] | None = None, beside: float = 0) -> Samples:
    """All texels, weighted by the mask (at least ``beside``) times ``importance`` ``(H, W)`` ≥ 0.

    Raises
    ------
    FaceZipError
        ``SIZE_MISMATCH``: the importance has another size. ``BAD_TEXELS``: it is negative, not finite, or 0 everywhere.
    """
    mask = np.ones(character.resolution, np.float32) if character.mask is None else character.mask
    weight = np.maximum(mask, np.float32(beside))
    if importance is not None:
        if importance.shape != weight.shape:
            sizes = [f"{size[1]}x{size[0]}" for size in (importance.shape, weight.shape)]
            raise FaceZipError(ErrorCode.SIZE_MISMATCH, f"importance of {sizes[0]}, textures of {sizes[1]}; resize it")
        weight = weight * importance
        if not (np.isfinite(weight).all() and weight.min() >= 0 and (mask * importance).max() > 0):
            reason = "must be finite, not negative, and not 0 on the whole face"
            raise FaceZipError(ErrorCode.BAD_TEXELS, f"importance: values {reason}")
    # Kernels read rows as they lie.
    textures = np.require(character.textures, requirements="C")
    neutral = np.require(character.neutral, requirements="C")
    return Samples(textures, neutral, texel_scale(character), weight.astype(np.float32))


def thinned(samples: Samples, step: int) -> Samples:
    """One texel of every ``step`` x ``step``, for statistics that do not need them all."""
    some = slice(step // 2, None, step)
    return Samples(
        samples.textures[:, some, some].copy(),
        samples.neutral[some, some].copy(),
        samples.scale,
        samples.importance[some, some].copy(),
    )
