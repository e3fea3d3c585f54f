"""Strokes on the chart: curves that start at a place and run in a direction of space, along the skin."""

import numpy as np
from numpy.typing import NDArray

from facezip.machine.kernels import inner, kernel
from scenes.face.skin.sampling import TexelGrid


@inner()
def stroke(
    texels: TexelGrid,
    row: float,
    column: float,
    way: NDArray[np.float64],
    length: float,
    bend: float,
    thickness: float,
    cover: NDArray[np.float32],
) -> None:
    """One hair from its root along ``way``, turned by ``bend`` radians in the x-y plane up to its thin tip."""
    across, down = _tangents(texels.grid, row, column)
    aa, ad, dd = _dot(across, across), _dot(across, down), _dot(down, down)
    determinant = aa * dd - ad * ad
    if determinant < 1e-9:
        return
    last = len(texels.row_of) - 1
    # A texel's share of a cell of the grid.
    per_column, per_row = (
        last / (texels.column_of[-1] - texels.column_of[0]),
        last / (texels.row_of[0] - texels.row_of[-1]),
    )
    # Where the chart is folded, a texel has no area to speak of.
    area = max(np.sqrt(determinant) / (per_column * per_row), 0.2 * texels.texel * texels.texel)
    steps = max(int(length / (0.5 * texels.texel)), 2)
    ds = length / steps
    for n in range(steps):
        t = (n + 0.5) / steps
        c, s = np.cos(bend * t), np.sin(bend * t)
        d = c * way[0] - s * way[1], s * way[0] + c * way[1], way[2]
        da, dn = _dot(d, across), _dot(d, down)
        step_c, step_r = (dd * da - ad * dn) / determinant, (aa * dn - ad * da) / determinant
        size = np.sqrt(max(step_c * step_c * aa + 2 * step_c * step_r * ad + step_r * step_r * dd, 1e-9))
        column += ds * step_c / size
        row += ds * step_r / size
        _drop(
            cover,
            (texels.row_of[0] - row) * per_row,
            (column - texels.column_of[0]) * per_column,
            thickness * (1 - 0.75 * t * t) * ds / area,
        )


@inner()
def _drop(cover: NDArray[np.float32], y: float, x: float, amount: float) -> None:
    """Add an amount to the four texels around a point."""
    j, i = int(np.floor(y)), int(np.floor(x))
    if j < 0 or i < 0 or j >= cover.shape[0] - 1 or i >= cover.shape[1] - 1:
        return
    v, u = y - j, x - i
    cover[j, i] += amount * (1 - v) * (1 - u)
    cover[j, i + 1] += amount * (1 - v) * u
    cover[j + 1, i] += amount * v * (1 - u)
    cover[j + 1, i + 1] += amount * v * u


@kernel()
def _tangents(
    grid: NDArray[np.float32], row: float, column: float
) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """How far a point moves for a column and for a row, cm."""
    j, i = min(max(int(row), 0), grid.shape[0] - 2), min(max(int(column), 0), grid.shape[1] - 2)
    a, b, c = grid[j, i], grid[j, i + 1], grid[j + 1, i]
    return (
        (float(b[0] - a[0]), float(b[1] - a[1]), float(b[2] - a[2])),
        (float(c[0] - a[0]), float(c[1] - a[1]), float(c[2] - a[2])),
    )


@kernel()
def area(grid: NDArray[np.float32], j: int, i: int) -> float:
    """Of a cell of the grid, square cm."""
    across, down = _tangents(grid, j, i)
    aa, ad, dd = _dot(across, across), _dot(across, down), _dot(down, down)
    return np.sqrt(max(aa * dd - ad * ad, 0.0))


@inner()
def _dot(a: tuple[float, float, float], b: tuple[float, float, float]) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
