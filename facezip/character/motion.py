"""How a head moves between two of its meshes: as a whole, and besides that."""

from itertools import permutations, product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]

# A head moves as a whole as most of its points do; so many of them, and found in so many steps.
MOST, STEPS = 0.7, 4


class Motion(NamedTuple):
    """A similarity: a point p of the neutral comes to ``scale · turn p + shift``.

    Attributes
    ----------
    scale : > 0.
    turn : ``(3, 3)`` orthogonal; its determinant is -1 where the mesh is mirrored.
    shift : ``(3,)``.
    rest : root mean square of what other motion there is, of the moved head's spread.
    """

    scale: float
    turn: Points
    shift: Points
    rest: float

    @property
    def degrees(self) -> float:
        """By how much it turns; 0 to 180."""
        return angle_between(np.eye(3), self.turn)

    def squares_off(self, neutral: Points, moved: Points) -> NDArray[np.float64]:
        """``(V,)``: squared distances of what a mesh has moved to from where the motion alone brings the neutral."""
        off: NDArray[np.float64] = np.square(self.scale * neutral @ self.turn.T + self.shift - moved).sum(axis=1)
        return off


def angle_between(one: Points, other: Points) -> float:
    """Degrees, 0 to 180, of the turn from one orthogonal ``(3, 3)`` to another; 180 between a mirrored and another."""
    turn = one.T @ other
    return float(np.degrees(np.arccos(np.clip((np.trace(turn) - 1) / 2, -1, 1)))) if np.linalg.det(turn) > 0 else 180.0


def nearest_axes(turn: Points) -> Points:
    """Of those that map axes to axes, the orthogonal ``(3, 3)`` of the same determinant next to one."""
    orders, signs = permutations(range(3)), list(product((1.0, -1.0), repeat=3))
    every = [np.diag(sign) @ np.eye(3)[list(order)] for order in orders for sign in signs]
    alike = [axes for axes in every if np.linalg.det(axes) * np.linalg.det(turn) > 0]
    return max(alike, key=lambda axes: float(np.sum(axes * turn)))


def spread_of(points: Points) -> float:
    """Root mean square distance from their middle."""
    return float(np.sqrt(np.square(points - points.mean(axis=0)).sum(axis=1).mean()))


def motion_between(neutral: Points, moved: Points) -> Motion:
    """The similarity that most points of a neutral ``(V, 3)`` follow to ``moved`` ``(V, 3)``.

    Least squares (Umeyama 1991), again and again on the 70 % of the points that follow best: what an expression moves
    is no motion of the head.
    """
    found = _similarity(neutral, moved)
    for _ in range(STEPS):
        off = found.squares_off(neutral, moved)
        some = np.argpartition(off, int(MOST * (len(off) - 1)))[: int(MOST * len(off)) + 1]
        found = _similarity(neutral[some], moved[some])
    off = found.squares_off(neutral, moved)
    return found._replace(rest=float(np.sqrt(off.mean())) / max(spread_of(moved), 1e-30))


def _similarity(neutral: Points, moved: Points) -> Motion:
    middle, other = neutral.mean(axis=0), moved.mean(axis=0)
    u, stretches, vt = np.linalg.svd((moved - other).T @ (neutral - middle))
    turn = u @ vt
    # A flat mesh is its own mirror image.
    if np.linalg.det(turn) < 0 and stretches[2] < 1e-6 * stretches[0]:
        turn = u @ np.diag([1.0, 1.0, -1.0]) @ vt
    scale = float(stretches.sum() / max(np.square(neutral - middle).sum(), 1e-30))
    return Motion(scale, turn, other - scale * turn @ middle, np.nan)


def activity(neutral: Points, expressions: list[Points]) -> NDArray[np.float64]:
    """``(V,)`` ≥ 0: by what mean square expressions move a point beside the head's motion, each in its own unit."""
    total = np.zeros(len(neutral))
    for moved in expressions:
        found = motion_between(neutral, moved)
        off = found.squares_off(neutral, moved)
        if found.rest > 1e-6:
            total += off / off.mean()
    return total / max(len(expressions), 1)
