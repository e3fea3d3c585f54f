"""The UV chart: a grid around the head, dense where faces are looked at, cut from crown to nape.

Columns run around the head from the nape's cut over the right ear, the face and the left ear back to it; rows from
the neck's base to the crown. Both are spaced by densities, so that eyes, nose and mouth get the most of them.
"""

import numpy as np
from numpy.typing import NDArray

from facezip.files.obj import Topology

# The chart keeps this distance from the border of the texture.
MARGIN = 0.004

COLUMNS = 193
ROWS = 134


def _spaced(count: int, low: float, high: float, peaks: list[tuple[float, float, float]]) -> NDArray[np.float64]:
    """``count`` values from ``low`` to ``high`` with density 1 + Σ height·exp(-((x - centre)/width)²)."""
    x = np.linspace(low, high, 4000)
    density = np.ones_like(x)
    for centre, width, height in peaks:
        density += height * np.exp(-(((x - centre) / width) ** 2))
    mass = np.concatenate([[0], np.cumsum((density[1:] + density[:-1]) / 2)])
    return np.interp(np.linspace(0, mass[-1], count), mass, x)


def azimuths() -> NDArray[np.float64]:
    """Angles of the columns in radians, 0 ahead, from -π to π; the middle one is exactly 0."""
    half = _spaced(COLUMNS // 2 + 1, 0.0, np.pi, [(0.0, 0.62, 3.4), (1.75, 0.28, 1.3)])
    return np.concatenate([-half[:0:-1], half])


def heights() -> NDArray[np.float64]:
    """Row parameters: heights on the axis in cm; above :data:`POLE` they continue as an angle to the crown."""
    peaks = [(0.5, 1.3, 2.6), (-6.1, 1.3, 2.8), (-3.2, 1.2, 1.8), (-1.5, 7.5, 1.0)]
    return _spaced(ROWS, -16.5, 13.0, peaks)


POLE = 2.0
CROWN = 13.0


def axis() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Heights of the head's axis, from below, and how far forward it lies at each of them, cm."""
    return np.array([-16.5, -12.0, -8.0, -2.0, POLE]), np.array([-4.0, -3.0, 0.4, 1.0, 0.0])


def rays(h: NDArray[np.float64], a: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Origins on the head's axis and unit directions outwards, ``(rows, columns, 3)``, for heights and azimuths.

    Rays leave the axis level, and spread over the skull up to the crown.
    """
    lift = np.clip((h - POLE) / (CROWN - POLE), 0, 1) * np.pi / 2
    level = np.clip(h, -100, POLE)
    direction = np.stack([np.sin(a) * np.cos(lift), np.sin(lift), np.cos(a) * np.cos(lift)], axis=2)
    origin = np.stack([np.zeros_like(h), level, np.interp(level, *axis())], axis=2)
    return origin, direction


def grid_topology(rows: int = ROWS, columns: int = COLUMNS) -> Topology:
    """Triangles and UVs of the grid, its first and last column sharing vertices, its last row being the crown."""
    cell = np.arange(columns)[None, :] + columns * np.arange(rows)[:, None]
    a, b, c, d = cell[:-1, :-1], cell[:-1, 1:], cell[1:, 1:], cell[1:, :-1]
    # All diagonals run one way: where they turned, normals would too, and show a crease.
    face_uv = np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)], 2).reshape(-1, 3).astype(np.int32)
    u, v = np.meshgrid(np.linspace(MARGIN, 1 - MARGIN, columns), np.linspace(MARGIN, 1 - MARGIN, rows))
    vertex = np.arange(rows * columns)
    welded = np.where(vertex % columns == columns - 1, vertex - columns + 1, vertex)
    vertex = (welded - welded // columns).astype(np.int32)
    return Topology(vertex[face_uv], np.stack([u, v], -1).reshape(-1, 2).astype(np.float32), face_uv)
