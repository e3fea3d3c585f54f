"""From texels to the surface of the head: the chart is a grid, so a texel's place in it is two numbers."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from facezip.machine.kernels import inner
from scenes.face.chart import MARGIN
from scenes.face.head import Head


class TexelGrid(NamedTuple):
    """Where texel centres lie on the grid of the chart; kernels take it as it is.

    Attributes
    ----------
    grid : ``(rows, columns, 3)`` float32 positions, the first column repeated at the end.
    row_of, column_of : ``(R,)`` fractional row of each texel row, fractional column of each texel column.
    texel : the side of a texel on the face, in cm.
    """

    grid: NDArray[np.float32]
    row_of: NDArray[np.float64]
    column_of: NDArray[np.float64]
    texel: float

    @staticmethod
    def of(head: Head, resolution: int) -> "TexelGrid":
        """Texel centres of a ``resolution`` x ``resolution`` texture of the head, row 0 at the crown."""
        rows, columns = head.shape[0], head.shape[1] + 1
        centre = ((np.arange(resolution) + 0.5) / resolution - MARGIN) / (1 - 2 * MARGIN)
        across = np.clip(centre, 0, 1)
        texel = 24.0 / resolution
        return TexelGrid(closed(head, head.vertices), (1 - across) * (rows - 1), across * (columns - 1), texel)


def closed(head: Head, values: NDArray[np.float32]) -> NDArray[np.float32]:
    """Values at vertices ``(V, C)`` on the grid of the chart, ``(rows, columns + 1, C)``, first column repeated."""
    grid = head.grid(values)
    return np.ascontiguousarray(np.concatenate([grid, grid[:, :1]], axis=1))


@inner()
def texels_of(texels: TexelGrid) -> tuple[float, float]:
    """How many texels lie between two rows of the chart's grid, and how many between two columns."""
    last = len(texels.row_of) - 1
    return last / (texels.row_of[0] - texels.row_of[-1]), last / (texels.column_of[-1] - texels.column_of[0])


@inner()
def tangents(
    grid: NDArray[np.float32], row: float, column: float
) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """How far a point of ``(rows, columns, 3)`` moves for a column and for a row, cm."""
    j, i = min(max(int(row), 0), grid.shape[0] - 2), min(max(int(column), 0), grid.shape[1] - 2)
    a, b, c = grid[j, i], grid[j, i + 1], grid[j + 1, i]
    return (
        (float(b[0] - a[0]), float(b[1] - a[1]), float(b[2] - a[2])),
        (float(c[0] - a[0]), float(c[1] - a[1]), float(c[2] - a[2])),
    )


@inner()
def at_texel(grid: NDArray[np.float32], row: float, column: float, out: NDArray[np.float64]) -> None:
    """Bilinear interpolation of ``(rows, columns, C)`` into ``out``, ``(C,)``."""
    j = min(int(row), grid.shape[0] - 2)
    i = min(int(column), grid.shape[1] - 2)
    v, u = row - j, column - i
    for c in range(grid.shape[2]):
        low = grid[j, i, c] + u * (grid[j, i + 1, c] - grid[j, i, c])
        high = grid[j + 1, i, c] + u * (grid[j + 1, i + 1, c] - grid[j + 1, i, c])
        out[c] = low + v * (high - low)
