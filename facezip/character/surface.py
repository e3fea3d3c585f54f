"""Points of a mesh, each with the side it faces and how much expressions move it: what orientation is read from."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facezip.character.meshes import Meshes
from facezip.character.motion import Points, activity

# How much a turn of a normal (of length 1) and how much the activity (about 1 on a face) count beside distances of the
# size of the moving face.
NORMALS, ACTIVITY = 0.4, 0.15
# Points that tell where the face is, and how far from its middle the others are, of its spread.
FEW, REACH = 1000, 2.5
# Of the grid on which points hide others from sight, and how far behind the foremost they are still seen.
CELL, DEPTH = 0.08, 0.12


@dataclass(frozen=True, eq=False)
class Surface:
    """P points of a mesh.

    Attributes
    ----------
    points : ``(P, 3)``. Of :meth:`of`, about the middle of what moves, and of its spread.
    normals : ``(P, 3)`` unit vectors, outwards.
    active : ``(P,)`` ≥ 0, how far expressions move a point; 1 in a mean over the moving face.
    """

    points: Points
    normals: Points
    active: NDArray[np.float64]

    @staticmethod
    def of(meshes: Meshes, count: int, seed: int = 0) -> "Surface | None":
        """``count`` points, spread evenly by area around what moves; None where nothing moves, or there is no area."""
        rng, neutral = np.random.default_rng(seed), meshes.neutral.astype(np.float64)
        a, b, c = (neutral[corner] for corner in meshes.topology.faces.T)
        across = np.cross(b - a, c - a)
        areas = np.linalg.norm(across, axis=1)
        # Triangles wound clockwise show their back: a head bulges outwards.
        centres = (a + b + c) / 3
        outwards = np.sum(np.einsum("fc,fc->f", centres - np.average(neutral, axis=0), across))
        middle, reach = neutral.mean(axis=0), np.inf
        for some in (FEW, count):
            near = np.where(np.linalg.norm(centres - middle, axis=1) < reach, areas, 0)
            if not near.sum() > 0:
                return None
            chosen, inside = rng.choice(len(areas), some, p=near / near.sum()), rng.dirichlet([1, 1, 1], some)
            corners = meshes.topology.faces[chosen]
            points, *posed = (np.einsum("pj,pjc->pc", inside, one[corners]) for one in (neutral, *meshes.vertices))
            moving = activity(points, posed)
            if not moving.sum() > 0:
                return None
            middle = np.average(points, axis=0, weights=moving)
            spread = np.sqrt(np.average(np.square(points - middle).sum(axis=1), weights=moving))
            reach = REACH * spread
        normals = np.copysign(1 / areas[chosen, None], outwards) * across[chosen]
        return Surface((points - middle) / spread, normals, np.sqrt(moving / np.average(moving, weights=moving)))

    @property
    def coordinates(self) -> Points:
        """``(P, 7)``: points near each other here are at a like place, face a like side and move alike."""
        return np.hstack([self.points, NORMALS * self.normals, ACTIVITY * self.active[:, None]])

    def turned(self, axes: Points, scale: float = 1.0, shift: Points | float = 0.0) -> "Surface":
        """In coordinates along ``axes`` ``(3, 3)``, one a row."""
        return Surface(scale * self.points @ axes.T + shift, self.normals @ axes.T, self.active)

    def only(self, some: NDArray[np.generic]) -> "Surface":
        """Some of the points."""
        return Surface(self.points[some], self.normals[some], self.active[some])

    def seen(self) -> "Surface":
        """What is seen from +z: on a grid of :data:`CELL`, the foremost points and those that are not far behind."""
        at = np.floor(self.points[:, :2] / CELL).astype(np.int64)
        _, place = np.unique(at, axis=0, return_inverse=True)
        foremost = np.full(place.max() + 1, -np.inf)
        np.maximum.at(foremost, place.ravel(), self.points[:, 2])
        return self.only(self.points[:, 2] > foremost[place.ravel()] - DEPTH)
