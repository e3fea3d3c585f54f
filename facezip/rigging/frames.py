"""Triangles as frames: edges, deformation gradients, and the vertices whose edges fit best (a Poisson problem).

Frames are those of Sumner and Popović (2004) and of Li, Weise and Pauly (2010): M = [v2 - v1, v3 - v1, n].
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import splu

# A triangle with less area than this part of the mean has no direction to speak of.
FLAT = 1e-6
# How much the place of a vertex counts beside the edges around it. Edges give the detail within some five rings of
# triangles; over longer ways their errors would add up, and parts that touch no other would go anywhere.
PLACE = 0.3


def edges(vertices: NDArray[np.floating[Any]], faces: NDArray[np.int32]) -> NDArray[np.float64]:
    """Both edge columns of every frame, ``(..., F, 3, 2)``, for vertices or displacements ``(..., V, 3)``."""
    corners: NDArray[np.float64] = vertices[..., faces, :].astype(np.float64)
    first, second, third = corners[..., 0, :], corners[..., 1, :], corners[..., 2, :]
    return np.stack([second - first, third - first], axis=-1)


def frames(columns: NDArray[np.float64]) -> NDArray[np.float64]:
    """Whole frames ``(..., F, 3, 3)`` of edge columns: the third one is the normal, as long as an edge is."""
    normal = np.cross(columns[..., 0], columns[..., 1])
    length = np.linalg.norm(normal, axis=-1, keepdims=True)
    unit = normal / np.sqrt(np.maximum(length, np.finfo(np.float64).tiny))
    return np.concatenate([columns, unit[..., None]], axis=-1)


def inverse_frames(columns: NDArray[np.float64]) -> NDArray[np.float64]:
    """Inverses ``(F, 3, 3)`` of the frames of edge columns; zero where a triangle is flat to a line."""
    area = np.linalg.norm(np.cross(columns[..., 0], columns[..., 1]), axis=-1)
    flat = area <= FLAT * area.mean()
    whole = frames(columns)
    whole[flat] = np.eye(3)
    inverse = np.asarray(np.linalg.inv(whole), np.float64)
    inverse[flat] = 0
    return inverse


@dataclass(frozen=True, eq=False)
class Integrator:
    """Displacements of vertices from displacements of edges; factored once for a mesh.

    Minimises ‖G u - e‖² + Σ_v h_v ‖u_v - a_v‖², G the differences along both edges of every triangle. The anchors a
    hold what no edge tells: where a part that is connected to nothing else goes.

    Attributes
    ----------
    faces : ``(F, 3)`` int32.
    resting : ``(V,)`` bool, vertices that no shape and no scan moves.
    """

    faces: NDArray[np.int32]
    resting: NDArray[np.bool_]

    def __call__(self, edge_columns: NDArray[np.floating[Any]], anchors: NDArray[np.float32]) -> NDArray[np.float32]:
        """``(M, V, 3)`` for edge columns ``(F, M, 3, 2)`` and anchors ``(M, V, 3)``; resting vertices stay."""
        count, vertices, _ = anchors.shape
        sides = np.moveaxis(edge_columns, 3, 0).reshape(2 * len(self.faces), -1)
        held = np.moveaxis(anchors, 1, 0).reshape(vertices, -1) * self._holds[:, None]
        solved = self._factors.solve(self._differences.T @ sides + held)
        moved = np.moveaxis(solved.reshape(vertices, count, 3), 0, 1).astype(np.float32)
        moved[:, self.resting] = 0
        return moved

    @cached_property
    def _holds(self) -> NDArray[np.float64]:
        return np.where(self.resting, 1.0, PLACE)

    @cached_property
    def _differences(self) -> sparse.csr_matrix:
        """G, ``(2F, V)``: all first edges, then all second ones."""
        count = len(self.faces)
        rows = np.tile(np.arange(2 * count), 2)
        columns = np.concatenate([self.faces[:, 1], self.faces[:, 2], self.faces[:, 0], self.faces[:, 0]])
        signs = np.repeat([1.0, -1.0], 2 * count)
        return sparse.csr_matrix((signs, (rows, columns)), (2 * count, len(self.resting)))

    @cached_property
    def _factors(self) -> Any:
        normal = (self._differences.T @ self._differences + sparse.diags(self._holds)).tocsc()
        return splu(normal, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
