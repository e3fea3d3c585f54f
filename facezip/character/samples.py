"""What a fit sees of a map on a tile: texels as stored, and how much each one counts."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from facezip.character.scans import Stack
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.images import Texels
from facezip.machine.rows import by_rows, map_rows

# What a fit gives to texels off the mask: ears and necks are seen too, and that little costs the face nothing.
BESIDE_THE_FACE = 0.03


class Stored(NamedTuple):
    """Texels as files hold them: what a kernel reads.

    Attributes
    ----------
    textures : ``(N, H, W, C)`` uint8, uint16 or float32.
    neutral : ``(H, W, C)`` of the same type.
    scale : factor from stored differences to values in [0, 1].
    """

    textures: Texels
    neutral: Texels
    scale: np.float32


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

    @property
    def stored(self) -> Stored:
        """The texels without their weights."""
        return Stored(self.textures, self.neutral, self.scale)


def stored_texels(stack: Stack) -> Stored:
    """A map's texels on a tile, as they are."""
    return Stored(stack.textures, stack.neutral, stack.scale)


def samples_of(stack: Stack, importance: NDArray[np.float32] | None = None, beside: float = 0) -> Samples:
    """All texels, weighted by the mask (at least ``beside``) times ``importance`` ``(H, W)`` ≥ 0.

    Raises
    ------
    FaceZipError
        ``SIZE_MISMATCH``: the importance has another size. ``BAD_TEXELS``: it is negative, not finite, or 0 everywhere.
    """
    shape, mask = stack.resolution, stack.mask
    if importance is not None:
        _check_importance(importance, mask, shape)
    one, least = np.ones((1, shape[1]), np.float32), np.float32(beside)

    def weights(rows: slice) -> NDArray[np.float32]:
        weight = np.maximum(one if mask is None else mask[rows], least)
        return weight if importance is None else weight * importance[rows]

    # Kernels read rows as they lie.
    textures = np.require(stack.textures, requirements="C")
    neutral = np.require(stack.neutral, requirements="C")
    return Samples(textures, neutral, stack.scale, by_rows(weights, shape, np.float32))


def _check_importance(
    importance: NDArray[np.float32], mask: NDArray[np.float32] | None, shape: tuple[int, int]
) -> None:
    if importance.shape != shape:
        sizes = [f"{size[1]}x{size[0]}" for size in (importance.shape, shape)]
        raise FaceZipError(ErrorCode.SIZE_MISMATCH, f"importance of {sizes[0]}, textures of {sizes[1]}; resize it")

    def extent(top: int, bottom: int) -> tuple[float, float]:
        part = importance[top:bottom]
        return float(part.min()), float((part if mask is None else part * mask[top:bottom]).max())

    parts = map_rows(extent, shape[0])
    if not (np.isfinite(parts).all() and min(low for low, _ in parts) >= 0 and max(high for _, high in parts) > 0):
        reason = "must be finite, not negative, and not 0 on the whole face"
        raise FaceZipError(ErrorCode.BAD_TEXELS, f"importance: values {reason}")


def thinned(samples: Samples, step: int) -> Samples:
    """One texel of every ``step`` x ``step``, for statistics that do not need them all."""
    some = slice(step // 2, None, step)

    def copied(texels: NDArray[Any], axis: int) -> NDArray[Any]:
        seen = texels[..., some, some, :] if axis else texels[some, some]
        return by_rows(lambda rows: seen[:, rows] if axis else seen[rows], seen.shape, seen.dtype, axis)

    return Samples(
        copied(samples.textures, 1), copied(samples.neutral, 0), samples.scale, copied(samples.importance, 0)
    )
