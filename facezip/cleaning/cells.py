"""Scans in small: means over cells of 8 x 8 texels, which neither noise nor a texel of misregistration moves much."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from facezip.character.scans import Stack
from facezip.machine import memory
from facezip.machine.kernels import kernel
from facezip.machine.rows import map_rows

# Texels a side of a cell; those at the right and lower border may be smaller.
CELL = 8
# A cell belongs to the face where the mask shows this much of it.
SHOWN = 0.5


class Cells(NamedTuple):
    """Of one map on one tile, values in [0, 1].

    Attributes
    ----------
    neutral : ``(h, w, C)`` float32 means.
    scans : ``(N, h, w, C)`` float32 means.
    gaps : ``(N, h, w)`` float32, mean squares of I_n - I_0.
    face : ``(h, w)`` bool.
    """

    neutral: NDArray[np.float32]
    scans: NDArray[np.float32]
    gaps: NDArray[np.float32]
    face: NDArray[np.bool_]


def cells_of(stack: Stack) -> Cells:
    """The cells of a stack."""
    count, channels = len(stack.textures), stack.channels
    height, width = (-(-size // CELL) for size in stack.resolution)
    found = Cells(
        np.empty((height, width, channels), np.float32),
        memory.empty((count, height, width, channels), np.float32),
        memory.empty((count, height, width), np.float32),
        np.empty((height, width), np.bool_),
    )
    mask = np.ones((1, 1), np.float32) if stack.mask is None else stack.mask
    texels = (stack.textures, stack.neutral, stack.scale, mask)
    map_rows(lambda top, bottom: _gather(top, bottom, *texels, *found), height)
    return found


@kernel()
def _gather(
    top: int,
    bottom: int,
    textures: NDArray[np.uint8],
    neutral: NDArray[np.uint8],
    scale: np.float32,
    mask: NDArray[np.float32],
    still: NDArray[np.float32],
    moved: NDArray[np.float32],
    gaps: NDArray[np.float32],
    face: NDArray[np.bool_],
) -> None:
    count, height, width, channels = textures.shape
    sums = np.empty(channels)
    for i in range(top, bottom):
        for j in range(face.shape[1]):
            lower, right = min(CELL * (i + 1), height), min(CELL * (j + 1), width)
            texels = (lower - CELL * i) * (right - CELL * j)
            shown = 0.0
            sums[:] = 0
            for y in range(CELL * i, lower):
                for x in range(CELL * j, right):
                    shown += mask[min(y, len(mask) - 1), min(x, mask.shape[1] - 1)]
                    for c in range(channels):
                        sums[c] += neutral[y, x, c]
            face[i, j] = shown > SHOWN * texels
            for c in range(channels):
                still[i, j, c] = scale * sums[c] / texels
            for n in range(count):
                sums[:] = 0
                square = np.float32(0)
                for y in range(CELL * i, lower):
                    for x in range(CELL * j, right):
                        for c in range(channels):
                            sums[c] += textures[n, y, x, c]
                            gap = np.float32(textures[n, y, x, c]) - np.float32(neutral[y, x, c])
                            square += gap * gap
                gaps[n, i, j] = scale * scale * square / (texels * channels)
                for c in range(channels):
                    moved[n, i, j, c] = scale * sums[c] / texels
