"""From texels to the surface: which triangle lies under each texel, and where in it."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from facezip.files.obj import Topology
from facezip.machine import memory
from facezip.machine.kernels import kernel
from facezip.machine.rows import by_rows, map_rows

# What SciPy holds of each texel to find the nearest ones of a chart, whatever the limit of memory: whether it is beside
# it, in 8 bytes and in 1, and two indices.
BYTES_OF_NEAREST = 17


@dataclass(frozen=True, eq=False)
class Raster:
    """The UV chart, seen from the centre of every texel.

    Attributes
    ----------
    faces : ``(F, 3)`` int32, the mesh's triangles.
    face : ``(H, W)`` int32, the triangle under a texel, -1 outside the chart.
    barycentric : ``(H, W, 3)`` float32, summing to one; zero outside the chart.
    """

    faces: NDArray[np.int32]
    face: NDArray[np.int32]
    barycentric: NDArray[np.float32]

    @property
    def covered(self) -> NDArray[np.bool_]:
        """``(H, W)``: whether a texel's centre lies in the chart."""
        return by_rows(lambda rows: self.face[rows] >= 0, self.face.shape, np.bool_)

    def interpolate(self, values: NDArray[np.float32]) -> NDArray[np.float32]:
        """Values at vertices ``(V, ...)`` as a map ``(H, W, ...)``, zero outside the chart."""
        corners = values[self.faces[np.maximum(self.face, 0)]]
        mixed: NDArray[np.float32] = np.einsum("hwj,hwj...->hw...", self.barycentric, corners)
        return mixed

    def dilated(self) -> "Raster":
        """The same chart with every texel outside it looking where its nearest neighbour inside looks."""
        beside = by_rows(lambda rows: self.face[rows] < 0, self.face.shape, np.bool_)
        parts = map_rows(lambda top, bottom: int(beside[top:bottom].sum()), len(beside))
        if sum(parts) in (0, beside.size):
            return self
        memory.let_go()
        near, across = distance_transform_edt(beside, return_distances=False, return_indices=True)

        def seen(texels: NDArray[Any]) -> NDArray[Any]:
            return by_rows(lambda rows: texels[near[rows], across[rows]], texels.shape, texels.dtype)

        return Raster(self.faces, seen(self.face), seen(self.barycentric))


def rasterise(topology: Topology, resolution: tuple[int, int]) -> Raster:
    """Look up the triangle under every texel centre, at ((x + 0.5) / W, 1 - (y + 0.5) / H) in UV.

    Where triangles overlap the last one wins.
    """
    face: NDArray[np.int32] = memory.empty(resolution, np.int32)
    barycentric: NDArray[np.float32] = memory.empty((*resolution, 3), np.float32)

    def block(top: int, bottom: int) -> None:
        face[top:bottom], barycentric[top:bottom] = _rows(topology, resolution, slice(top, bottom))

    map_rows(block, resolution[0])
    return Raster(topology.faces, face, barycentric)


def covered(topology: Topology, resolution: tuple[int, int]) -> NDArray[np.bool_]:
    """:attr:`Raster.covered` without the rest of a raster, which takes sixteen times as much."""
    return by_rows(lambda rows: _rows(topology, resolution, rows)[0] >= 0, resolution, np.bool_)


def _rows(
    topology: Topology, resolution: tuple[int, int], rows: slice
) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """Some rows of a raster's ``face`` and ``barycentric``."""
    height, width = resolution
    face = np.full((rows.stop - rows.start, width), -1, np.int32)
    barycentric = np.zeros((*face.shape, 3), np.float32)
    pixels = topology.uv.astype(np.float64) * [width, -height] + [-0.5, height - 0.5]
    _rasterise(rows.start, pixels, topology.face_uv, face, barycentric)
    return face, barycentric


@kernel()
def _rasterise(
    top: int,
    pixels: NDArray[np.float64],
    face_uv: NDArray[np.int32],
    face: NDArray[np.int32],
    barycentric: NDArray[np.float32],
) -> None:
    height, width = face.shape
    slack = 1e-9
    for f in range(len(face_uv)):
        ax, ay = pixels[face_uv[f, 0]]
        bx, by = pixels[face_uv[f, 1]]
        cx, cy = pixels[face_uv[f, 2]]
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if area == 0:
            continue
        upper, lower = int(np.ceil(min(ay, by, cy))), int(np.floor(max(ay, by, cy)))
        for y in range(max(top, upper), min(top + height - 1, lower) + 1):
            for x in range(max(0, int(np.ceil(min(ax, bx, cx)))), min(width - 1, int(np.floor(max(ax, bx, cx)))) + 1):
                u = ((x - ax) * (cy - ay) - (y - ay) * (cx - ax)) / area
                v = ((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / area
                if u >= -slack and v >= -slack and u + v <= 1 + slack:
                    face[y - top, x] = f
                    barycentric[y - top, x, 0] = 1 - u - v
                    barycentric[y - top, x, 1] = u
                    barycentric[y - top, x, 2] = v
