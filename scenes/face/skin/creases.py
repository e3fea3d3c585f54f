"""The lines of a face on its chart: for every texel the nearest of their points, and what folds there.

A fold is a valley between two ridges. How deep it is follows from the strain across it, so that a line shows under
those expressions that press it together, and its place on the chart never moves.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from facezip.machine.kernels import inner, kernel
from scenes.face.head import Head
from scenes.face.skin.lines import Line, lines_of
from scenes.face.skin.sampling import TexelGrid, at_texel, tangents, texels_of
from scenes.face.skin.strain import frames_of, skin_of
from scenes.face.traits import Traits

LAYERS = 2
# A point for every step along a line (cm), and how far from a line its fold reaches, in widths of it.
STEP, REACH = 0.03, 4.2


class Creases(NamedTuple):
    """The lines of a face; kernels take them as they are.

    Attributes
    ----------
    nearest : ``(LAYERS, R, R)`` int32, which point of ``points`` is nearest to a texel, -1 where none is near.
    points : ``(P, 13)`` float32: place (3) and unit vector across the line along the skin (3), cm; the factors of the
        strain's three numbers in the stretch across; width, strength, slope, what is there at rest.
    """

    nearest: NDArray[np.int32]
    points: NDArray[np.float32]

    @staticmethod
    def of(head: Head, texels: TexelGrid, person: Traits) -> "Creases":
        """Those of a person on the texels of a texture."""
        lines, grid = lines_of(person), texels.grid
        frames = np.ascontiguousarray(frames_of(grid).reshape(*grid.shape[:2], 6)).astype(np.float32)
        # Vertices of the front, from which the search for a place on the chart begins.
        cells = np.argwhere((skin_of(head) > 0) & (grid[..., 2] > 0))
        front = KDTree(grid[cells[:, 0], cells[:, 1], :2])
        side = len(texels.row_of)
        nearest, away = np.full((LAYERS, side, side), -1, np.int32), np.empty((side, side), np.float32)
        tables: list[NDArray[np.float32]] = []
        for layer in range(LAYERS):
            away.fill(np.inf)
            for line in (line for line in lines if line.layer == layer):
                places = _charted(grid, line.points, cells[front.query(line.points)[1]])
                table = _table(grid, frames, places, line)
                _draw(texels, places, table, sum(map(len, tables)), nearest[layer], away)
                tables.append(table)
        return Creases(nearest, np.concatenate(tables))


def _charted(grid: NDArray[np.float32], points: NDArray[np.float64], cells: NDArray[np.int64]) -> NDArray[np.float64]:
    """Rows and columns ``(P, 2)`` of a curve through points ``(K, 2)`` near vertices of the grid, a point a step."""
    corners = cells.astype(np.float64)
    _refine(grid, points, corners)
    length = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
    at = np.linspace(0, len(points) - 1, max(int(length / STEP), 2))
    return np.stack([np.interp(at, np.arange(len(points)), corners[:, c]) for c in range(2)], axis=1)


@kernel()
def _refine(grid: NDArray[np.float32], points: NDArray[np.float64], places: NDArray[np.float64]) -> None:
    """Move places on the chart, in place, to where x and y are those of the points: Newton's method."""
    here, right, up = np.empty(3), np.empty(3), np.empty(3)
    for n in range(len(points)):
        for _ in range(6):
            row, column = places[n]
            at_texel(grid, row, column, here)
            at_texel(grid, row, column + 0.2, right)
            at_texel(grid, row + 0.2, column, up)
            a, b, c, d = right[0] - here[0], up[0] - here[0], right[1] - here[1], up[1] - here[1]
            determinant = a * d - b * c
            if abs(determinant) < 1e-9:
                break
            x, y = points[n, 0] - here[0], points[n, 1] - here[1]
            places[n, 1] = column + min(max(0.2 * (d * x - b * y) / determinant, -1.0), 1.0)
            places[n, 0] = row + min(max(0.2 * (a * y - c * x) / determinant, -1.0), 1.0)


def _table(
    grid: NDArray[np.float32], frames: NDArray[np.float32], places: NDArray[np.float64], line: Line
) -> NDArray[np.float32]:
    """The points ``(P, 13)`` of one line, as :class:`Creases` has them; it runs out at its ends."""
    at, frame = np.empty((len(places), 3)), np.empty((len(places), 6))
    _look_up(grid, places, at)
    _look_up(frames, places, frame)
    first, second = frame[:, :3], frame[:, 3:]
    along = np.gradient(at, axis=0)
    # Along the line in the frame of the skin, turned by a right angle.
    u, v = -np.sum(along * second, axis=1), np.sum(along * first, axis=1)
    size = np.maximum(np.hypot(u, v), 1e-9)
    u, v = u / size, v / size
    across = u[:, None] * first + v[:, None] * second
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    t = np.linspace(0, 1, len(places))
    tip = np.minimum(1, np.minimum(t, 1 - t) / 0.25) ** 0.75
    values = [u * u, 2 * u * v, v * v, line.width * (0.6 + 0.4 * tip), line.strength * tip]
    values += [np.full(len(t), line.steep), line.permanent * tip]
    table: NDArray[np.float32] = np.concatenate([at, across, np.stack(values, axis=1)], axis=1).astype(np.float32)
    return table


@kernel()
def _look_up(grid: NDArray[np.float32], places: NDArray[np.float64], out: NDArray[np.float64]) -> None:
    for n in range(len(places)):
        at_texel(grid, places[n, 0], places[n, 1], out[n])


@kernel()
def _draw(
    texels: TexelGrid,
    places: NDArray[np.float64],
    table: NDArray[np.float32],
    first: int,
    nearest: NDArray[np.int32],
    away: NDArray[np.float32],
) -> None:
    """Enter the points of a line where they are nearer, in widths of their folds, than what is there."""
    p, side = np.empty(3), len(texels.row_of)
    per_row, per_column = texels_of(texels)
    for n in range(len(places)):
        across, down = tangents(texels.grid, places[n, 0], places[n, 1])
        reach = REACH * max(table[n, 9], least_width(texels.texel))
        wide = np.sqrt(across[0] ** 2 + across[1] ** 2 + across[2] ** 2)
        tall = np.sqrt(down[0] ** 2 + down[1] ** 2 + down[2] ** 2)
        di, dj = int(reach / wide * per_column) + 1, int(reach / tall * per_row) + 1
        y = int((texels.row_of[0] - places[n, 0]) * per_row)
        x = int((places[n, 1] - texels.column_of[0]) * per_column)
        for j in range(max(y - dj, 0), min(y + dj + 2, side)):
            for i in range(max(x - di, 0), min(x + di + 2, side)):
                at_texel(texels.grid, texels.row_of[j], texels.column_of[i], p)
                apart = (p[0] - table[n, 0]) ** 2 + (p[1] - table[n, 1]) ** 2 + (p[2] - table[n, 2]) ** 2
                apart /= reach * reach
                if apart < min(away[j, i], 1.0):
                    away[j, i], nearest[j, i] = apart, first + n


@inner()
def least_width(texel: float) -> float:
    """The narrowest valley that texels can hold, cm."""
    return 1.1 * texel


@kernel()
def depths(point: NDArray[np.float32], f: NDArray[np.float64]) -> tuple[float, float]:
    """How deep a line is at rest and under a strain, 0..1: a little of it raises no fold, and stretch smooths."""
    stretch = np.sqrt(max(1 + point[6] * f[0] + point[7] * f[1] + point[8] * f[2], 0.05)) - 1
    rest = point[12]
    if stretch >= 0:
        return rest, rest * np.exp(-7.0 * stretch)
    return rest, rest + (1 - rest) * point[10] * (1 - np.exp(-6.0 * max(-stretch - 0.025, 0.0)))


@kernel()
def profile(
    point: NDArray[np.float32], p: NDArray[np.float64], depth: float, texel: float
) -> tuple[float, float, float]:
    """How much of the valley and of the ridges a place lies on, 0..1 each, and the valley's width (cm).

    The deeper the fold, the wider; where the line itself is narrower than texels, it is fainter instead.
    """
    width = point[9] * (0.75 + 0.45 * depth)
    seen = max(width, least_width(texel))
    x = ((p[0] - point[0]) * point[3] + (p[1] - point[1]) * point[4] + (p[2] - point[2]) * point[5]) / seen
    along = (p[0] - point[0]) ** 2 + (p[1] - point[1]) ** 2 + (p[2] - point[2]) ** 2 - (x * seen) ** 2
    # Beyond the end of a line only its last point is near.
    share = width / seen * np.exp(-max(along, 0.0) / (1.5 * seen * seen))
    beside = abs(x) - 2.0
    return share * np.exp(-x * x), share * np.exp(-beside * beside / (0.5 if beside < 0 else 1.1)), width
