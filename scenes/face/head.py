"""The neutral head as a mesh: the sculpt seen from the grid of the chart, with eyes opened and mouth cut."""

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from facezip.files.obj import Topology
from facezip.machine.rows import map_rows
from scenes.face.chart import azimuths, grid_topology, heights, rays
from scenes.face.ears import graft_ears
from scenes.face.features import Rows, cut_mouth, find_rows, open_eyes, warp_heights
from scenes.face.profile import follow
from scenes.face.relax import relax
from scenes.face.sculpt import outermost

FAR = 27.0


@dataclass(frozen=True, eq=False)
class Head:
    """The neutral head.

    Attributes
    ----------
    topology : 51k triangles over 25.7k vertices, one UV chart.
    vertices : ``(V, 3)`` float32, cm, y up, face to +z, +x the character's left.
    rows : which rows of the grid carry lids and lips.
    shape : rows and columns of vertices; the column at the nape is not repeated.
    """

    topology: Topology
    vertices: NDArray[np.float32]
    rows: Rows
    shape: tuple[int, int]

    def grid(self, values: NDArray[np.float32]) -> NDArray[np.float32]:
        """Values at vertices ``(V, ...)`` as they lie on the grid, ``(rows, columns, ...)``."""
        return values.reshape(*self.shape, *values.shape[1:])


@cache
def build_head() -> Head:
    """Sculpt, project, and open the head; deterministic."""
    h, a = np.meshgrid(heights(), azimuths(), indexing="ij")
    rows = find_rows(h[:, 0])
    first = _surface(h, a)
    warped = warp_heights(h, first[..., 0], rows)
    positions = _surface(warped, a)
    follow(positions, warped, a[0])
    relax(positions)
    graft_ears(positions)
    open_eyes(positions, rows)
    cut_mouth(positions, rows)
    vertices = positions[:, :-1].astype(np.float32)
    return Head(grid_topology(), vertices.reshape(-1, 3), rows, vertices.shape[:2])


def _surface(h: NDArray[np.float64], a: NDArray[np.float64]) -> NDArray[np.float64]:
    origins, directions = rays(h, a)

    def trace(top: int, bottom: int) -> NDArray[np.float64]:
        o, d = (x[top:bottom].reshape(-1, 3) for x in (origins, directions))
        return (o + outermost(o, d, FAR)[:, None] * d).reshape(bottom - top, -1, 3)

    return np.concatenate(map_rows(trace, len(h)))
