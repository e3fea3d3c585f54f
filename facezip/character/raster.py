"""From texels to the surface: which triangle lies under each texel, and where in it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from facezip.files.obj import Topology
from facezip.machine.kernels import kernel
from facezip.machine.rows import by_rows


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
        return self.face >= 0

    def interpolate(self, values: NDArray[np.float32]) -> NDArray[np.float32]:
        """Values at vertices ``(V, ...)`` as a map ``(H, W, ...)``, zero outside the chart."""
        corners = values[self.faces[np.maximum(self.face, 0)]]
        mixed: NDArray[np.float32] = np.einsum("hwj,hwj...->hw...", self.barycentric, corners)
        return mixed

    def dilated(self) -> "Raster":
        """The same chart with every texel outside it looking where its nearest neighbour inside looks."""
        if self.covered.all() or not self.covered.any():
            return self
        rows, columns = distance_transform_edt(~self.covered, return_distances=False, return_indices=True)
        return Raster(self.faces, self.face[rows, columns], self.barycentric[rows, columns])


def rasterise(topology: Topology, resolution: tuple[int, int]) -> Raster:
    """Look up the triangle under every texel centre, at ((x + 0.5) / W, 1 - (y + 0.5) / H) in UV.

    Where triangles overlap the last one wins.
    """
    return Raster(topology.faces, *_rows(topology, resolution, slice(0, resolution[0])))


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
