"""Eyes in motion: lids that slide over the eyeball, and gaze that moves the iris under them."""

import numpy as np
from numpy.typing import NDArray

from scenes.face.features import LID_HALF_WIDTH
from scenes.face.head import Head
from scenes.face.sculpt import EYE

# The surface on which lids slide: the ellipsoid of the sculpt.
_LID_RADII = np.array([1.62, 1.40, 1.44])

# How far the upper and the lower lid travel, as shares of the open eye, and the name of the shape.
_LID_SHAPES = {
    "eyeBlink": (-0.97, 0.02),
    "eyeWide": (0.24, -0.06),
    "eyeSquint": (-0.16, 0.36),
    "eyeLookDown": (-0.42, -0.03),
}
_GAZE_SHAPES = {
    "eyeLookDown": (0.0, -0.34),
    "eyeLookUp": (0.0, 0.28),
    "eyeLookIn": (-0.36, 0.0),
    "eyeLookOut": (0.36, 0.0),
}


def lids(head: Head) -> dict[str, NDArray[np.float64]]:
    """Displacements ``(V, 3)`` of the shapes that move lids, for both sides."""
    return {
        f"{name}{side}": _lids(head, sign, *travel)
        for name, travel in _LID_SHAPES.items()
        for side, sign in (("Left", 1), ("Right", -1))
    }


def gaze(head: Head) -> dict[str, NDArray[np.float64]]:
    """Displacements ``(V, 3)`` of the shapes that turn the eyes; looking down takes the upper lid along."""
    shapes = {}
    for name, (dx, dy) in _GAZE_SHAPES.items():
        for side, sign in (("Left", 1), ("Right", -1)):
            moved = _gaze(head, sign, dx * sign, dy)
            shapes[f"{name}{side}"] = moved + (_lids(head, sign, *_LID_SHAPES[name]) if name in _LID_SHAPES else 0)
    return shapes


def _eye_columns(head: Head, sign: int) -> NDArray[np.float64]:
    """How much of an eye's height each column has, 1 at its middle and 0 beyond its corners."""
    x = head.grid(head.vertices)[head.rows.lower_lid, :, 0] * sign
    front = head.grid(head.vertices)[head.rows.lower_lid, :, 2] > 4
    return front * np.sqrt(np.maximum(1 - ((x - EYE[0]) / LID_HALF_WIDTH) ** 2, 0))


def _lids(head: Head, sign: int, upper: float, lower: float) -> NDArray[np.float64]:
    grid = head.grid(head.vertices).astype(np.float64)
    columns = _eye_columns(head, sign) > 0
    y = grid[..., 1]
    low, high = y[head.rows.lower_lid], y[head.rows.upper_lid]
    opening = np.where(columns, high - low, 0)
    t = np.clip((y - low) / np.maximum(high - low, 1e-6), 0, 1)
    # Skin above the upper margin follows it less and less up to the crease, and below the lower one likewise.
    above = np.clip(1 - (y - high) / 1.15, 0, 1) ** 2
    below = np.clip(1 - (low - y) / 1.3, 0, 1) ** 2
    share = np.where(y > high, upper * above, np.where(y < low, lower * below, lower + t * (upper - lower)))
    dy = share * opening * (np.abs(y - EYE[1]) < 3)
    moved = np.zeros_like(grid)
    moved[..., 1] = dy
    moved[..., 2] = np.where(dy != 0, _lid_depth(grid, y + dy) - _lid_depth(grid, y), 0)
    return moved.reshape(-1, 3)


def _lid_depth(grid: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
    dx, dy = (np.abs(grid[..., 0]) - EYE[0]) / _LID_RADII[0], (y - EYE[1]) / _LID_RADII[1]
    return _LID_RADII[2] * np.sqrt(np.maximum(1 - dx * dx - dy * dy, 0.08))


def _gaze(head: Head, sign: int, dx: float, dy: float) -> NDArray[np.float64]:
    moved = np.zeros((*head.shape, 3))
    columns = _eye_columns(head, sign)
    steps = head.rows.upper_lid - head.rows.lower_lid
    for step in range(1, steps):
        rest = 1 - (2 * step / steps - 1) ** 2
        moved[head.rows.lower_lid + step, :, 0] = dx * columns**2 * rest
        moved[head.rows.lower_lid + step, :, 1] = dy * columns**2 * rest
    return moved.reshape(-1, 3)
