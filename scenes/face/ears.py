"""Ears, modelled as reliefs in planes of their own and grafted onto blocks of the grid.

Rings of a block lead from the head up the back of the ear to its rim, and over the rim into the relief of its front:
helix, scapha, antihelix, concha, tragus and lobe. Rays from inside the head could not see the back.
"""

import numpy as np
from numpy.typing import NDArray

from scenes.face.steps import smooth_step

Array = NDArray[np.float64]

# The plane of the left ear: backwards (flaring out from the head), upwards (leaning back), and out of it.
ORIGIN = np.array([6.95, -0.55, 0.25])
BACK, UP, OUT = np.array([0.42, -0.03, -0.907]), np.array([0.06, 0.985, -0.16]), np.array([0.905, 0.0, 0.425])
CENTRE = np.array([1.5, 0.45])
# Where the rim lies between the middle of the block (0) and its border (1).
RIM = 0.74
# Extent of the blocks: heights, and depths, of the head's surface under the ear.
_HEIGHTS = (-4.9, 3.7)
_DEPTHS = (1.4, -4.3)


def graft_ears(positions: Array) -> None:
    """Replace the vertices around both ears, in place ``(rows, columns, 3)``; columns run from -x over +z to +x."""
    middle = positions.shape[1] // 2
    for half, side in ((positions[:, middle:], 1.0), (positions[:, middle::-1], -1.0)):
        rows, columns = _block(half)
        half[rows, columns] = _ear(half[rows, columns] * [side, 1, 1]) * [side, 1, 1]


def _block(half: Array) -> tuple[slice, slice]:
    """Rows and columns under the ear, of the half of the grid that runs from the face to the nape."""
    column = int(np.abs(half[:, :, 2].mean(axis=0) - ORIGIN[2]).argmin())
    rows = np.flatnonzero((half[:, column, 1] > _HEIGHTS[0]) & (half[:, column, 1] < _HEIGHTS[1]))
    row = int(np.abs(half[:, column, 1] - ORIGIN[1]).argmin())
    columns = np.flatnonzero((half[row, :, 2] < _DEPTHS[0]) & (half[row, :, 2] > _DEPTHS[1]))
    return slice(int(rows[0]), int(rows[-1]) + 1), slice(int(columns[0]), int(columns[-1]) + 1)


def _ear(base: Array) -> Array:
    """The left ear over the head's surface ``(rows, columns, 3)``."""
    t, s = np.meshgrid(*map(_sides, base.shape[:2]), indexing="ij")
    # Rings are squares of the grid, or the rim would cross its lines in a zigzag.
    ring = np.maximum(np.abs(s), np.abs(t))
    angle = np.arctan2(t, s)
    climb = np.clip((ring - RIM) / (1 - RIM), 0, 1)[..., None]
    rim = _front(np.ones_like(ring), angle)
    # Towards the face the ear has no back: it runs out into the cheek.
    face = _ramp(_from_face(angle + 0.25), 1.25, 0.65)[..., None]
    middle = ORIGIN + CENTRE[0] * BACK + CENTRE[1] * UP
    under = rim + (1 - face) * (-0.16 * (rim - middle) - 0.5 * OUT) - face * 0.12 * OUT
    curl = rim + np.sin(np.pi / 2 * climb) * (under - rim)
    back = curl + _ramp(climb, 0.0, 1.0) * (base - curl)
    return np.where((ring < RIM)[..., None], _front(np.minimum(ring / RIM, 1), angle), back)


def _sides(count: int) -> Array:
    """Where lines of a block lie, -1 to 1, one of them at the rim."""
    even = np.linspace(-1, 1, count)
    rim = even[np.abs(even - RIM).argmin()]
    return np.interp(even, [-1, -rim, rim, 1], [-1, -RIM, RIM, 1])


def _front(r: Array, angle: Array) -> Array:
    """Points of the ear's front at r (0 in the middle, 1 on the rim) and angle (0 backwards, π/2 upwards)."""
    c, s = np.cos(angle), np.sin(angle)
    width = np.where(c > 0, 1.72, 1.42) * (1 + 0.10 * s)
    height = np.where(s > 0, 2.65, 3.35)
    # The outline narrows to the lobe.
    radius = (1 - 0.16 * np.exp(-(((angle + 0.85) / 0.45) ** 2))) / np.hypot(c / width, s / height)
    back, up = CENTRE[0] + r * radius * c, CENTRE[1] + r * radius * s
    out = _relief(1 - r, angle, back, up)
    front: Array = ORIGIN + back[..., None] * BACK + up[..., None] * UP + out[..., None] * OUT
    return front


def _relief(d: Array, angle: Array, back: Array, up: Array) -> Array:
    """Height over the ear's plane; ``d`` is 0 on the rim and 1 in the middle."""

    def blob(p: float, q: float, width: float, height: float) -> Array:
        return np.exp(-(((back - p) / width) ** 2) - (((up - q) / height) ** 2))

    def band(at: float, width: float) -> Array:
        return np.exp(-(((d - at) / width) ** 2))

    around = np.mod(angle + np.pi / 2, 2 * np.pi) - np.pi / 2
    helix = _ramp(around, -0.95, -0.45) * _ramp(-around, -3.3, -2.7)
    antihelix = _ramp(around, -1.15, -0.8) * _ramp(-around, -1.7, -1.1)
    cheek = _ramp(_from_face(angle), 0.9, 0.4)
    out = 0.10 + helix * (0.26 * band(0.07, 0.085) - 0.17 * band(0.24, 0.09)) + 0.24 * antihelix * band(0.47, 0.13)
    concha = 0.68 * blob(0.95, 0.0, 0.55, 0.85) + 0.10 * blob(1.4, 1.75, 0.4, 0.4)
    tragus = 0.38 * blob(0.20, -0.40, 0.30, 0.50) + 0.20 * blob(0.80, -1.30, 0.40, 0.28)
    crus, lobe = 0.14 * blob(0.60, 0.38, 0.5, 0.24), 0.06 * blob(0.95, -2.1, 0.6, 0.6)
    return out - concha + tragus + crus + lobe - 0.16 * cheek * band(0.0, 0.3)


def _from_face(angle: Array) -> Array:
    """Angle from the direction of the face, 0 to π."""
    return np.abs(np.mod(angle, 2 * np.pi) - np.pi)


def _ramp(x: Array, start: float, end: float) -> Array:
    """Smooth step from 0 at ``start`` to 1 at ``end``."""
    return smooth_step((x - start) / (end - start))
