"""How poses strain the skin: what is compressed and what is stretched at every vertex, and along which direction.

A wrinkle comes where skin is compressed, blood leaves it where it is stretched: how far a place moves tells less.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import splu

from facezip.rigging.frames import FLAT, edges

# Skin is stiff: strain is smoothed over this part of the mesh's size, the standard deviation of its vertices.
REACH = 0.056
# Of an edge's length: compressed or stretched further than this, a triangle is a fold or a fault.
SHRUNK, STRETCHED = -0.9, 1.0
# Values of a symmetric tensor: three on the diagonal and three beside it, which count twice in a product.
TENSOR = 6
_ROWS, _COLUMNS = np.array([0, 1, 2, 0, 0, 1]), np.array([0, 1, 2, 1, 2, 2])
_FACTORS = np.sqrt([1, 1, 1, 2, 2, 2])
# Cotangents of angles beyond these bounds belong to slivers.
MOST_COTANGENT = 10.0


def strains(neutral: NDArray[np.float32], poses: NDArray[np.float32], faces: NDArray[np.int32]) -> NDArray[np.float32]:
    """Compression and stretch ``(V, P, 12)`` at the vertices of poses ``(P, V, 3)``, smoothed over the skin.

    The stretch tensor U of a triangle, U² = FᵀF of its deformation F, less one (Biot's strain), stands on the neutral's
    surface in space. Of the mean around a vertex the negative part comes first, then the positive one, each as
    :data:`TENSOR` values whose products are those of the tensors.
    """
    vertices = neutral.astype(np.float64)
    frame, inverse, areas = _triangles(vertices, faces)
    smooth, tangents = _Smoothing(vertices, faces, areas), _tangents(vertices, faces)
    found = np.empty((len(neutral), len(poses), 2 * TENSOR), np.float32)
    for n, pose in enumerate(poses):
        found[:, n] = _parts(smooth(_biot(edges(pose, faces) @ inverse, frame)), tangents)
    return found


def _triangles(
    vertices: NDArray[np.float64], faces: NDArray[np.int32]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Frames ``(F, 3, 2)`` on the triangles, inverses ``(F, 2, 2)`` of their edges in them, areas; 0 for flat ones."""
    sides = edges(vertices, faces)
    areas = np.linalg.norm(np.cross(sides[..., 0], sides[..., 1]), axis=-1) / 2
    flat = areas <= FLAT * areas.mean()
    sides[flat] = np.eye(3)[:, :2]
    frame, corners = np.linalg.qr(sides)
    inverse = np.linalg.inv(corners)
    inverse[flat] = 0
    return frame, inverse, np.where(flat, 0.0, areas)


def _biot(deformation: NDArray[np.float64], frame: NDArray[np.float64]) -> NDArray[np.float64]:
    """Tensors ``(F, 6)`` of the deformations ``(F, 3, 2)`` of triangles in their frames."""
    metric = np.swapaxes(deformation, 1, 2) @ deformation
    root = np.sqrt(np.maximum(np.linalg.det(metric), 0))
    trace = np.sqrt(metric[:, 0, 0] + metric[:, 1, 1] + 2 * root)
    # The root of a matrix of two rows: (C + √det C) / √(tr C + 2 √det C).
    stretch = (metric + root[:, None, None] * np.eye(2)) / np.maximum(trace, np.finfo(float).tiny)[:, None, None]
    strain = np.clip(stretch - np.eye(2), SHRUNK, STRETCHED)
    strain[trace == 0] = 0
    return _packed(frame @ strain @ np.swapaxes(frame, 1, 2))


def _tangents(vertices: NDArray[np.float64], faces: NDArray[np.int32]) -> NDArray[np.float64]:
    """Two directions on the surface at every vertex, ``(V, 3, 2)``."""
    corners = vertices[faces]
    normals = np.zeros_like(vertices)
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    np.add.at(normals, faces.ravel(), np.repeat(across, 3, axis=0))
    # Householder's reflection of the axis onto the normal: its other two columns.
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.finfo(float).tiny)
    mirror = normals + np.where(normals[:, 2:] < 0, -1.0, 1.0) * [0, 0, 1]
    scale = 2 / np.square(mirror).sum(axis=1)
    return (np.eye(3) - scale[:, None, None] * mirror[:, :, None] * mirror[:, None])[:, :, :2]


def _parts(tensors: NDArray[np.float64], tangents: NDArray[np.float64]) -> NDArray[np.float64]:
    """``(V, 12)`` of tensors ``(V, 6)``, as far as they lie on the surface: what is negative, and what is positive."""
    plane = np.swapaxes(tangents, 1, 2) @ _unpacked(tensors) @ tangents
    mean = (plane[:, 0, 0] + plane[:, 1, 1]) / 2
    radius = np.hypot((plane[:, 0, 0] - plane[:, 1, 1]) / 2, plane[:, 0, 1])
    high, low = mean + radius, mean - radius
    # Of eigenvalues of either sign, the positive part is high (E - low) / (high - low).
    share = np.maximum(high, 0) / np.maximum(high - np.minimum(low, 0), np.finfo(float).tiny)
    share[low >= 0] = 1
    above = share[:, None, None] * (plane - np.minimum(low, 0)[:, None, None] * np.eye(2))
    both = (plane - above, above)
    return np.concatenate([_packed(tangents @ part @ np.swapaxes(tangents, 1, 2)) for part in both], axis=1)


def _packed(matrices: NDArray[np.float64]) -> NDArray[np.float64]:
    """``(..., 6)`` of symmetric ``(..., 3, 3)``; products of the one are those of the other."""
    return matrices[..., _ROWS, _COLUMNS] * _FACTORS


def _unpacked(tensors: NDArray[np.float64]) -> NDArray[np.float64]:
    matrices = np.empty((*tensors.shape[:-1], 3, 3))
    matrices[..., _ROWS, _COLUMNS] = matrices[..., _COLUMNS, _ROWS] = tensors / _FACTORS
    return matrices


class _Smoothing:
    """From triangles to vertices: (M + r² L)⁻¹ M, a step of diffusion with the cotangents' Laplacian L."""

    def __init__(self, vertices: NDArray[np.float64], faces: NDArray[np.int32], areas: NDArray[np.float64]) -> None:
        count = len(vertices)
        corners = np.repeat(np.arange(len(faces)), 3)
        self._gather = sparse.csr_matrix((np.repeat(areas / 3, 3), (faces.ravel(), corners)), (count, len(faces)))
        mass = np.asarray(self._gather.sum(axis=1)).ravel()
        # A vertex of no triangle stays with no strain.
        mass = np.where(mass > 0, mass, mass.max())
        reach = REACH * float(np.sqrt(vertices.var(axis=0).sum()))
        system = sparse.diags(mass) + reach**2 * _laplacian(vertices, faces)
        self._factors: Any = splu(system.tocsc(), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})

    def __call__(self, tensors: NDArray[np.float64]) -> NDArray[np.float64]:
        solved: NDArray[np.float64] = self._factors.solve(np.asarray(self._gather @ tensors))
        return solved


def _laplacian(vertices: NDArray[np.float64], faces: NDArray[np.int32]) -> sparse.csr_matrix:
    corners, count = vertices[faces], len(vertices)
    rows, columns, weights = [], [], []
    for corner in range(3):
        one, other = faces[:, (corner + 1) % 3], faces[:, (corner + 2) % 3]
        first, second = (corners[:, (corner + turn) % 3] - corners[:, corner] for turn in (1, 2))
        sine = np.linalg.norm(np.cross(first, second), axis=1)
        cotangent = np.sum(first * second, axis=1) / np.maximum(sine, np.finfo(float).tiny)
        rows += [one, other]
        columns += [other, one]
        weights += 2 * [np.clip(cotangent, 0, MOST_COTANGENT) / 2]
    shape = (count, count)
    off = sparse.csr_matrix((np.concatenate(weights), (np.concatenate(rows), np.concatenate(columns))), shape)
    return sparse.diags(np.asarray(off.sum(axis=1)).ravel()) - off
