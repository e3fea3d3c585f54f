"""Strokes on the chart: curves that start at a place and run in a direction of space, along the skin."""

import numpy as np
from numpy.typing import NDArray

from facezip.machine.kernels import inner
from scenes.face.skin.sampling import TexelGrid, tangents, texels_of


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
    across, down = tangents(texels.grid, row, column)
    aa, ad, dd = _dot(across, across), _dot(across, down), _dot(down, down)
    determinant = aa * dd - ad * ad
    if determinant < 1e-9:
        return
    per_row, per_column = texels_of(texels)
    # Where the chart is folded, a texel has no area to speak of.
    whole = max(np.sqrt(determinant) / (per_column * per_row), 0.2 * texels.texel * texels.texel)
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
            thickness * (1 - 0.75 * t * t) * ds / whole,
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


@inner()
def area(grid: NDArray[np.float32], j: int, i: int) -> float:
    """Of a cell of the grid, square cm."""
    across, down = tangents(grid, j, i)
    aa, ad, dd = _dot(across, across), _dot(across, down), _dot(down, down)
    return np.sqrt(max(aa * dd - ad * ad, 0.0))


@inner()
def _dot(a: tuple[float, float, float], b: tuple[float, float, float]) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
