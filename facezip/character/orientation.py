"""Which way a head looks, from its geometry: where expressions move it, its symmetry, and the relief of a face.

The skin that moves is in front, so that its mean normal points ahead. A face is symmetric to the plane between left and
right alone. In this plane a generic face is laid on it upright and upside down, with all turns about the axis from ear
to ear, sizes and shifts: what lies closer is right. How close, and how sure that is, was measured on many heads
(docs/meshes.md).
"""

from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from itertools import product
from typing import NamedTuple

import numpy as np
from scipy.spatial import KDTree

from facezip.character.meshes import Meshes
from facezip.character.motion import Points, nearest_axes
from facezip.character.surface import NORMALS, Surface

FACE = "face.npz"
# Points of a head that are looked at; meshes of fewer vertices say nothing.
COUNT, FEWEST = 4000, 100
# Points that are mirrored, at most so far from the middle of what moves, and of the generic face.
MIRRORED, NEAR = 500, 1.6
# Mirrors that are tried, and steps to the best one near each.
MIRRORS, STEPS = 6, 8
# Of every step, so many of the pairs that lie closest count.
KEPT = 0.85
# Where a fit of the generic face begins: turns in degrees, sizes and shifts; and where turns and sizes end.
TURNS, SIZES, SHIFTS = (-20.0, 20.0), (0.75, 1.25), (-0.5, 0.0, 0.5)
# After so many steps from each of them, so many go on.
FIRST, GOOD = 3, 4
MOST_TURN, LEAST_SIZE, MOST_SIZE = 50.0, 0.6, 1.6


@dataclass(frozen=True, eq=False)
class Orientation:
    """How a head stands.

    Attributes
    ----------
    axes : ``(3, 3)``, one a row: to the character's left, up, ahead.
    facing : length of the mean normal of what moves, in [0, 1]: how surely it has a front.
    symmetric : by what factor mirroring between left and right fits better than any other mirror.
    upright : by what factor a generic face fits better so than upside down.
    off : how far off it the face lies, of the spread of what moves.
    off_usual : the same of a head that looks at +z with y up.
    """

    axes: Points
    facing: float
    symmetric: float
    upright: float
    off: float
    off_usual: float


def orientation_of(meshes: Meshes) -> Orientation | None:
    """How the neutral stands; None for what is no head with expressions."""
    if len(meshes.neutral) < FEWEST:
        return None
    surface = Surface.of(meshes, COUNT)
    if surface is None:
        return None
    ahead = np.average(surface.normals, axis=0, weights=np.square(surface.active))
    facing = float(np.linalg.norm(ahead))
    if facing < 1e-6:
        return None
    left, middle, symmetric = _mirror(surface, ahead / facing)
    ahead -= (ahead @ left) * left
    ahead /= np.linalg.norm(ahead)
    axes = np.stack([left, np.cross(ahead, left), ahead])
    front = surface.turned(axes, shift=np.array([-middle @ left, 0, 0]))
    (off, turn), (other, other_turn) = (_laid(front, around) for around in (1.0, -1.0))
    flip = np.diag([-1.0, -1.0, 1.0])
    axes = turn.T @ axes if off <= other else flip @ other_turn.T @ axes
    least, most = min(off, other), max(off, other)
    usual = least if np.array_equal(nearest_axes(axes), np.eye(3)) else _laid(surface, 1.0)[0]
    return Orientation(axes, facing, symmetric, most / max(least, 1e-9), least, usual)


def _mirror(surface: Surface, ahead: Points) -> tuple[Points, Points, float]:
    """Normal of the best mirror that holds the direction ahead, a point on it, and the ratio to the next best."""
    across = np.cross(ahead, np.eye(3)[np.abs(ahead).argmin()])
    across /= np.linalg.norm(across)
    down = np.cross(ahead, across)
    tree = KDTree(surface.coordinates)
    some = surface.only(np.flatnonzero(np.linalg.norm(surface.points, axis=1) < NEAR)[:MIRRORED])
    angles = np.arange(MIRRORS) * np.pi / MIRRORS
    found = [_settled(surface, tree, some, np.cos(a) * across + np.sin(a) * down) for a in angles]
    off, left, middle = min(found, key=lambda one: one[0])
    others = [one[0] for one in found if abs(one[1] @ left) < np.cos(np.radians(40))]
    return left, middle, min(others, default=10 * off) / max(off, 1e-9)


def _settled(surface: Surface, tree: KDTree, some: Surface, normal: Points) -> tuple[float, Points, Points]:
    """From one mirror to the best near it: how far points lie off what they are mirrored to, normal, a point on it."""
    middle = np.zeros(3)
    for _ in range(STEPS):
        mirror = np.eye(3) - 2 * np.outer(normal, normal)
        mirrored = some.turned(mirror, shift=2 * (middle @ normal) * normal)
        off, nearest = map(np.asarray, tree.query(mirrored.coordinates))
        kept = np.argsort(off)[: int(KEPT * len(off))]
        here, there = some.only(kept), surface.only(nearest[kept])
        centres = here.points.mean(axis=0), there.points.mean(axis=0)
        middle = (centres[0] + centres[1]) / 2
        both = (here.points - centres[0]).T @ (there.points - centres[1]) + NORMALS**2 * here.normals.T @ there.normals
        normal = np.linalg.eigh(both + both.T)[1][:, 0]
    return float(np.sqrt(np.square(off[kept]).mean())), normal, middle


@cache
def generic_face() -> Surface:
    """The face of the embedded character, looking at +z, y up (``scenes.generic_face``)."""
    with (files("facezip.character") / FACE).open("rb") as file, np.load(file) as stored:
        return Surface(*(stored[name].astype(np.float64) for name in ("points", "normals", "active")))


def _laid(head: Surface, around: float) -> tuple[float, Points]:
    """Lay the generic face on a head seen from +z: how far off it lies at best, and its turn about the x axis.

    ``around`` is 1 for upright, -1 for upside down.
    """
    front = head.seen()
    tree = KDTree(front.coordinates)
    face = generic_face().turned(np.diag([around, around, 1.0]))
    starts = [
        _Fit(np.inf, np.radians(turn), size, np.array([0.0, shift, 0.0]))
        for turn, size, shift in product(TURNS, SIZES, SHIFTS)
    ]
    some = sorted((_fitted(front, tree, face, fit, FIRST) for fit in starts), key=lambda fit: fit.off)[:GOOD]
    best = min((_fitted(front, tree, face, fit, STEPS) for fit in some), key=lambda fit: fit.off)
    return best.off, _about_x(best.angle)


class _Fit(NamedTuple):
    """How far off the generic face lies when it is turned about the x axis, resized and moved."""

    off: float
    angle: float
    size: float
    move: Points


def _fitted(front: Surface, tree: KDTree, face: Surface, start: _Fit, steps: int) -> _Fit:
    """So many steps from one fit to a better one (iterated closest points, Besl and McKay 1992)."""
    _, angle, size, move = start
    for _ in range(steps):
        laid = face.turned(_about_x(angle), size, move)
        off, nearest = map(np.asarray, tree.query(laid.coordinates))
        kept = np.argsort(off)[: int(KEPT * len(off))]
        here, there = face.only(kept), front.only(nearest[kept])
        centres = here.points.mean(axis=0), there.points.mean(axis=0)
        mine, theirs = here.points - centres[0], there.points - centres[1]
        both = mine.T @ theirs + NORMALS**2 * here.normals.T @ there.normals
        angle = np.arctan2(both[1, 2] - both[2, 1], both[1, 1] + both[2, 2])
        angle = float(np.clip(angle, -np.radians(MOST_TURN), np.radians(MOST_TURN)))
        turned = mine @ _about_x(angle).T
        size = float(np.clip(np.sum(turned * theirs) / np.square(mine).sum(), LEAST_SIZE, MOST_SIZE))
        move = centres[1] - size * _about_x(angle) @ centres[0]
        move[0] = 0
    return _Fit(float(np.sqrt(np.square(off[kept]).mean())), angle, size, move)


def _about_x(angle: float) -> Points:
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.array([[1, 0, 0], [0, cosine, -sine], [0, sine, cosine]])
