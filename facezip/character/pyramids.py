"""Textures reduced, level by level, to what neither light nor blood moves: log luminance without its local mean."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter

from facezip.character.alignment import GRID
from facezip.machine.kernels import kernel
from facezip.machine.rows import by_rows

# A pyramid level: how much smaller its image is, and the standard deviation of its windows in cells of the grid.
LEVELS = ((8, 4.0), (4, 3.0), (2, 2.0), (1, 1.25))
# Images of fewer rows or columns than this tell nothing.
SMALLEST = 4
# Side of the neighbourhood whose mean is taken away, in texels of a level.
NEIGHBOURHOOD = 9
# Added to values in [0, 1] before the logarithm, so that the noise of black texels does not count.
DARK = 0.05


def pyramid(luminance: NDArray[np.float32], scale: np.float32) -> list[NDArray[np.float32]]:
    """Log luminance without its local mean, at every level: a gain of the exposure changes nothing."""
    levels = [reduced(luminance[:, :, None], step) for step in steps_down(luminance)]
    logs = [np.log(level * scale + np.float32(DARK)) for level in levels]
    return [log - uniform_filter(log, NEIGHBOURHOOD) for log in logs]


def steps_down(image: NDArray[np.float32]) -> list[int]:
    """How much smaller the levels of a pyramid are, the smallest first."""
    return [step for step, _ in LEVELS if min(image.shape) >= SMALLEST * step]


def reduced(texels: NDArray[Any], factor: int) -> NDArray[np.float32]:
    """The mean ``(H / factor, W / factor)`` over channels and blocks of factor x factor; a part block is left out."""
    shape = texels.shape[0] // factor, texels.shape[1] // factor
    return by_rows(lambda rows: _means(texels[rows.start * factor : rows.stop * factor], factor), shape, np.float32)


@kernel()
def _means(texels: NDArray[np.uint8], factor: int) -> NDArray[np.float32]:
    height, width, channels = texels.shape
    out = np.empty((height // factor, width // factor), np.float32)
    share = np.float32(1 / (factor * factor * channels))
    for y in range(out.shape[0]):
        for x in range(out.shape[1]):
            total = np.float32(0)
            for j in range(y * factor, (y + 1) * factor):
                for i in range(x * factor, (x + 1) * factor):
                    for c in range(channels):
                        total += np.float32(texels[j, i, c])
            out[y, x] = total * share
    return out


def in_cells(weight: NDArray[np.float32]) -> NDArray[np.float32]:
    """The mean weight of every cell of the grid."""
    rows, columns = (np.arange(size) * GRID // size for size in weight.shape)
    cells, counts = np.zeros((GRID, GRID), np.float32), np.zeros((GRID, GRID), np.float32)
    np.add.at(cells, (rows[:, None], columns[None]), weight)
    np.add.at(counts, (rows[:, None], columns[None]), 1)
    return (cells / np.maximum(counts, 1)).astype(np.float32)
