"""How an expression stretches and folds the skin: the strain of the surface, on the grid of the chart."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from scenes.face.head import Head
from scenes.face.skin.sampling import closed


@dataclass(frozen=True, eq=False)
class Strain:
    """The strain of the skin between the neutral and a deformed head.

    Attributes
    ----------
    excess : ``(rows, columns, 3)`` float32, what the metric C = FᵀF has more than one: C₁₁ - 1, C₁₂, C₂₂ - 1 in the
        frames of :func:`frames_of`; a unit vector u is stretched by √(1 + uᵀ excess u).
    area : ``(rows, columns)`` float32, relative change of area, negative where blood is pressed together.
    """

    excess: NDArray[np.float32]
    area: NDArray[np.float32]

    @property
    def fields(self) -> NDArray[np.float32]:
        """``(rows, columns, 4)``: all of it, to be interpolated."""
        return np.concatenate([self.excess, self.area[..., None]], axis=2)


def strain(head: Head, vertices: NDArray[np.float32]) -> Strain:
    """Strain of the head's skin for deformed ``vertices`` ``(V, 3)``; none on eyeballs and in the mouth."""
    before, after = (_tangents(closed(head, points).astype(np.float64)) for points in (head.vertices, vertices))
    frame = _frames(before)
    # Tangents in the neutral's frame; F maps the neutral's to the deformed ones.
    local = np.einsum("rcki,rcji->rckj", frame, before)
    deformation = np.einsum("rcji,rcjk->rcik", after, _inverse(local))
    metric = np.einsum("rcik,rcil->rckl", deformation, deformation)
    skin = skin_of(head)[..., None, None]
    excess = _smoothed((metric - np.eye(2)) * skin) * skin
    whole = np.maximum(np.linalg.det(np.eye(2) + excess), 0.0025)
    upper = np.stack([excess[..., 0, 0], excess[..., 0, 1], excess[..., 1, 1]], axis=2)
    return Strain(upper.astype(np.float32), (np.sqrt(whole) - 1).astype(np.float32))


def frames_of(grid: NDArray[np.float32]) -> NDArray[np.float64]:
    """Orthonormal frames of the skin ``(rows, columns, 2, 3)`` over positions ``(rows, columns, 3)``."""
    return _frames(_tangents(grid.astype(np.float64)))


def _tangents(grid: NDArray[np.float64]) -> NDArray[np.float64]:
    """``(rows, columns, 2, 3)``: central differences along columns and rows."""
    return np.stack([np.gradient(grid, axis=1), np.gradient(grid, axis=0)], axis=2)


def _frames(tangents: NDArray[np.float64]) -> NDArray[np.float64]:
    """Orthonormal tangent frames ``(rows, columns, 2, 3)``."""
    first = tangents[..., 0, :] / np.maximum(np.linalg.norm(tangents[..., 0, :], axis=2, keepdims=True), 1e-9)
    rest = tangents[..., 1, :] - np.sum(tangents[..., 1, :] * first, axis=2, keepdims=True) * first
    second = rest / np.maximum(np.linalg.norm(rest, axis=2, keepdims=True), 1e-9)
    return np.stack([first, second], axis=2)


def _inverse(matrices: NDArray[np.float64]) -> NDArray[np.float64]:
    """Inverses of ``(..., 2, 2)`` matrices; zero where the grid's cells have no area."""
    (a, b), (c, d) = np.moveaxis(matrices, (-2, -1), (0, 1))
    determinant = a * d - b * c
    scale = np.where(np.abs(determinant) > 1e-9, 1 / np.where(determinant == 0, 1, determinant), 0)
    return np.moveaxis(scale * np.array([[d, -b], [-c, a]]), (0, 1), (-2, -1))


def skin_of(head: Head) -> NDArray[np.float64]:
    """1 on skin, 0 where rows cross an eye or fold into the mouth, where the grid is no surface that wrinkles."""
    rows = head.rows
    grid = closed(head, head.vertices)
    skin = np.ones(grid.shape[:2])
    front = grid[..., 2] > 4
    x = np.abs(grid[..., 0])
    eye = front & (x > 1.5) & (x < 4.8)
    skin[rows.lower_lid - 1 : rows.upper_lid + 2][eye[rows.lower_lid - 1 : rows.upper_lid + 2]] = 0
    mouth = front & (x < 2.6)
    # At the crown the columns meet in a point.
    skin[-3:] = 0
    skin[rows.lower_lip - 1 : rows.upper_lip + 2][mouth[rows.lower_lip - 1 : rows.upper_lip + 2]] = 0
    return skin


def _smoothed(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Skin is stiff: strain spreads over about a centimetre."""
    return gaussian_filter(np.clip(values, -0.9, 1.5), (3.0, 4.0, 0, 0))
