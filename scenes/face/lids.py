"""Eyes in motion: lids that slide over the eyeball, and gaze that moves the iris under them."""

import numpy as np
from numpy.typing import NDArray

from scenes.face.features import LID_HALF_WIDTH
from scenes.face.head import Head
from scenes.face.sculpt import EYE

# How far the upper and the lower lid travel, as shares of the open eye, and the name of the shape.
_LID_SHAPES = {
    "eyeBlink": (-1.0, 0.03),
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
    """Turn the lids about the eyeball by shares of its opening; rows between the margins are squeezed or stretched."""
    grid = head.grid(head.vertices).astype(np.float64)
    elevation, radius = _about_eye(grid)
    low, high = elevation[head.rows.lower_lid], elevation[head.rows.upper_lid]
    opening = (high - low) * np.minimum(_eye_columns(head, sign) / 0.2, 1)
    rows = np.arange(head.shape[0])[:, None]
    over, under = rows >= head.rows.upper_lid, rows <= head.rows.lower_lid
    # Skin above the upper margin follows it less and less up to the brow, and below the lower one likewise.
    above = np.clip(1 - (elevation - high) / 0.52, 0, 1) ** 1.6
    below = np.clip(1 - (low - elevation) / 0.7, 0, 1) ** 2
    t = np.clip((elevation - low) / np.maximum(high - low, 0.02), 0, 1.2)
    share = np.where(over, upper * above, np.where(under, lower * below, _between(t, upper, lower)))
    front = grid[..., 2] > EYE[2]
    turned = elevation + share * opening * front
    # The closed lid comes to lie on the lower one.
    closed = np.clip(lower - upper, 0, 1) ** 3 * (_eye_columns(head, sign) > 0) * front
    lying = closed * np.where(over, above * (radius[head.rows.lower_lid] - radius[head.rows.upper_lid]), 0)
    settled = radius + lying - 0.05 * closed * ~(over | under)
    moved = np.zeros_like(grid)
    moved[..., 1] = settled * np.sin(turned) - radius * np.sin(elevation)
    moved[..., 2] = settled * np.cos(turned) - radius * np.cos(elevation)
    return moved.reshape(-1, 3)


def _between(t: NDArray[np.float64], upper: float, lower: float) -> NDArray[np.float64]:
    """Motion at ``t`` (0 on the lower margin, 1 on the upper) as gentle to the iris as can be without folding over."""
    steep, shallow = (float(np.clip(0.9 / max(abs(travel), 1e-6), 1, 4)) for travel in (upper, lower))
    return upper * t**steep + lower * np.clip(1 - t, 0, 1) ** shallow


def _about_eye(grid: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Elevation in radians and distance of points from the horizontal axis through the eyeballs' centres."""
    y, z = grid[..., 1] - EYE[1], grid[..., 2] - EYE[2]
    return np.arctan2(y, z), np.hypot(y, z)


def _gaze(head: Head, sign: int, dx: float, dy: float) -> NDArray[np.float64]:
    moved = np.zeros((*head.shape, 3))
    columns = _eye_columns(head, sign)
    steps = head.rows.upper_lid - head.rows.lower_lid
    for step in range(1, steps):
        rest = 1 - (2 * step / steps - 1) ** 2
        moved[head.rows.lower_lid + step, :, 0] = dx * columns**2 * rest
        moved[head.rows.lower_lid + step, :, 1] = dy * columns**2 * rest
    return moved.reshape(-1, 3)
