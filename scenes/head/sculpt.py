"""The sculpt: a signed distance of smoothly joined ellipsoids and swept curves, and rays that find its surface."""

import math
from dataclasses import dataclass, field

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Columns of a primitive: kind, operation, blend radius, group, then 15 numbers of geometry.
ELLIPSOID, CONE = 0.0, 1.0
UNION, CARVE = 0.0, 1.0


@dataclass
class Sculpt:
    """A list of primitives in the order in which they are joined."""

    rows: list[list[float]] = field(default_factory=list)
    groups: int = 0

    def ellipsoid(
        self,
        centre: tuple[float, float, float],
        radii: tuple[float, float, float],
        blend: float,
        turn: tuple[float, float, float] = (0.0, 0.0, 0.0),
        carve: bool = False,
    ) -> None:
        """Add an ellipsoid turned by Euler angles in degrees (x, then y, then z), and its mirror image if off axis."""
        for side in (1.0, -1.0) if centre[0] != 0 else (1.0,):
            self.groups += 1
            axes = _rotation(turn[0], side * turn[1], side * turn[2]).T.ravel()
            head = [ELLIPSOID, CARVE if carve else UNION, blend, float(self.groups)]
            self.rows.append([*head, side * centre[0], centre[1], centre[2], *radii, *axes])

    def sweep(self, points: list[tuple[float, float, float, float]], blend: float, carve: bool = False) -> None:
        """Add a curve of round cones through (x, y, z, radius), and its mirror image where it is off the axis."""
        curve = _refined(np.array(points))
        for side in (1.0, -1.0) if np.abs(curve[:, 0]).max() > 1e-9 and curve[:, 0].min() > -1e-9 else (1.0,):
            self.groups += 1
            for start, end in zip(curve[:-1], curve[1:], strict=True):
                head = [CONE, CARVE if carve else UNION, blend, float(self.groups)]
                a, b = start[:3] * [side, 1, 1], end[:3] * [side, 1, 1]
                self.rows.append([*head, *a, *b, start[3], end[3], *[0.0] * 7])

    def table(self) -> Array:
        """``(P, 19)`` primitives for the compiled functions."""
        return np.array(self.rows)


def _rotation(x: float, y: float, z: float) -> Array:
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_euler("xyz", [x, y, z], degrees=True).as_matrix())


def _refined(points: Array, times: int = 4) -> Array:
    from scipy.interpolate import PchipInterpolator

    knots = np.arange(len(points))
    fine = np.linspace(0, len(points) - 1, (len(points) - 1) * times + 1)
    return np.asarray(PchipInterpolator(knots, points)(fine))


@njit(cache=True, nogil=True)
def _ellipsoid(q: Array, x: float, y: float, z: float) -> float:
    dx, dy, dz = x - q[4], y - q[5], z - q[6]
    a = q[10] * dx + q[11] * dy + q[12] * dz
    b = q[13] * dx + q[14] * dy + q[15] * dz
    c = q[16] * dx + q[17] * dy + q[18] * dz
    a, b, c = a / q[7], b / q[8], c / q[9]
    near = math.sqrt(a * a + b * b + c * c)
    a, b, c = a / q[7], b / q[8], c / q[9]
    slope = math.sqrt(a * a + b * b + c * c) + 1e-12
    return near * (near - 1.0) / slope


@njit(cache=True, nogil=True)
def _cone(q: Array, x: float, y: float, z: float) -> float:
    ux, uy, uz = q[7] - q[4], q[8] - q[5], q[9] - q[6]
    px, py, pz = x - q[4], y - q[5], z - q[6]
    t = (px * ux + py * uy + pz * uz) / (ux * ux + uy * uy + uz * uz + 1e-12)
    t = min(max(t, 0.0), 1.0)
    px, py, pz = px - t * ux, py - t * uy, pz - t * uz
    return math.sqrt(px * px + py * py + pz * pz) - (q[10] + t * (q[11] - q[10]))


@njit(cache=True, nogil=True)
def _join(distance: float, other: float, carve: float, blend: float) -> float:
    """Smooth union or subtraction with a quadratic fillet of size ``blend``."""
    a, b = (-distance, other) if carve == 1.0 else (distance, other)
    h = max(blend - abs(a - b), 0.0)
    joined = min(a, b) - h * h / (4.0 * blend)
    return -joined if carve == 1.0 else joined


@njit(cache=True, nogil=True)
def distance(table: Array, x: float, y: float, z: float) -> float:
    """Signed distance (about; negative inside) of one point to the sculpt."""
    total = 1e9
    i = 0
    while i < table.shape[0]:
        q = table[i]
        group = q[3]
        if q[0] == ELLIPSOID:
            d = _ellipsoid(q, x, y, z)
            i += 1
        else:
            d = 1e9
            while i < table.shape[0] and table[i, 3] == group:
                d = min(d, _cone(table[i], x, y, z))
                i += 1
        total = _join(total, d, q[1], q[2])
    return total


@njit(cache=True, nogil=True)
def shoot(table: Array, origins: Array, directions: Array, reach: float) -> Array:
    """March rays from outside (``reach`` along each direction from its origin) back in, to the first surface.

    Parameters
    ----------
    table : ``(P, 19)`` of :meth:`Sculpt.table`.
    origins, directions : ``(N, 3)``; directions are unit vectors that point outwards.
    reach : cm.

    Returns
    -------
    Array
        ``(N, 3)`` points on the surface.
    """
    points = np.empty_like(origins)
    for n in range(len(origins)):
        s = reach
        for _ in range(160):
            x = origins[n, 0] + s * directions[n, 0]
            y = origins[n, 1] + s * directions[n, 1]
            z = origins[n, 2] + s * directions[n, 2]
            d = distance(table, x, y, z)
            s -= 0.7 * d
            if abs(d) < 1e-4 or s < -8.0:
                break
        for axis in range(3):
            points[n, axis] = origins[n, axis] + s * directions[n, axis]
    return points


@njit(cache=True, nogil=True)
def settle(table: Array, points: Array, steps: int) -> Array:
    """Move points ``(N, 3)`` along the gradient onto the surface."""
    moved = points.copy()
    e = 1e-3
    for n in range(len(points)):
        for _ in range(steps):
            x, y, z = moved[n]
            d = distance(table, x, y, z)
            gx = (distance(table, x + e, y, z) - d) / e
            gy = (distance(table, x, y + e, z) - d) / e
            gz = (distance(table, x, y, z + e) - d) / e
            square = gx * gx + gy * gy + gz * gz + 1e-9
            moved[n, 0] -= d * gx / square
            moved[n, 1] -= d * gy / square
            moved[n, 2] -= d * gz / square
    return moved
