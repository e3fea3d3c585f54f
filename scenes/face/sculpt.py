"""The neutral head as a signed-distance sculpt: smooth unions of ellipsoids and capsules at anatomical places.

Frame: centimetres, y up, the face looks to +z, +x is the character's left; the origin lies between the ears. The
proportions are those of an adult: chin to crown 23 cm, eyes at half that height, pupils 6.3 cm apart.
"""

import numpy as np
from numpy.typing import NDArray

from facezip.machine.kernels import inner, kernel

# Centre of the left eyeball.
EYE = np.array([3.15, 0.55, 6.55])


@inner()
def ellipsoid(x: float, y: float, z: float, cx: float, cy: float, cz: float, rx: float, ry: float, rz: float) -> float:
    """Approximate signed distance to an axis-aligned ellipsoid."""
    px, py, pz = (x - cx) / rx, (y - cy) / ry, (z - cz) / rz
    k0 = np.sqrt(px * px + py * py + pz * pz)
    k1 = np.sqrt((px / rx) ** 2 + (py / ry) ** 2 + (pz / rz) ** 2)
    return k0 * (k0 - 1) / max(k1, 1e-9)


@inner()
def capsule(
    x: float,
    y: float,
    z: float,
    ax: float,
    ay: float,
    az: float,
    bx: float,
    by: float,
    bz: float,
    ra: float,
    rb: float,
) -> float:
    """Distance to a segment less a radius that runs from ``ra`` to ``rb``."""
    dx, dy, dz = bx - ax, by - ay, bz - az
    t = ((x - ax) * dx + (y - ay) * dy + (z - az) * dz) / (dx * dx + dy * dy + dz * dz)
    t = min(max(t, 0.0), 1.0)
    px, py, pz = x - ax - t * dx, y - ay - t * dy, z - az - t * dz
    return np.sqrt(px * px + py * py + pz * pz) - (ra + t * (rb - ra))


@inner()
def join(a: float, b: float, k: float) -> float:
    """Smooth union: the smaller of two distances, blended over a width ``k``."""
    h = max(k - abs(a - b), 0.0) / k
    return min(a, b) - h * h * k * 0.25


@inner()
def carve(a: float, b: float, k: float) -> float:
    """Smooth subtraction of ``b`` from ``a``."""
    return -join(-a, b, k)


@inner()
def _skull(x: float, y: float, z: float) -> float:
    d = ellipsoid(x, y, z, 0.0, 3.7, -0.9, 7.25, 8.2, 9.3)
    d = join(d, ellipsoid(x, y, z, 0.0, 2.6, 2.2, 6.7, 6.6, 6.5), 2.0)
    d = join(d, ellipsoid(x, y, z, 0.0, -3.6, 2.9, 5.7, 7.0, 5.4), 2.5)
    d = join(d, capsule(x, y, z, 5.0, -5.6, 0.0, 1.3, -9.7, 6.3, 1.35, 1.15), 2.2)
    d = join(d, ellipsoid(x, y, z, 0.0, -9.7, 6.9, 1.9, 1.35, 1.45), 1.6)
    d = join(d, ellipsoid(x, y, z, 4.5, -1.8, 5.0, 1.9, 1.4, 1.9), 2.2)
    d = join(d, capsule(x, y, z, 5.6, -1.2, 4.0, 6.7, -0.6, 0.0, 0.8, 0.7), 1.6)
    d = join(d, ellipsoid(x, y, z, 3.5, -4.2, 5.5, 2.5, 3.1, 2.15), 2.4)
    d = join(d, capsule(x, y, z, 0.9, 2.15, 7.75, 4.6, 2.5, 5.8, 0.70, 0.6), 1.5)
    # The temples are hollow.
    return carve(d, ellipsoid(x, y, z, 8.3, 2.4, 3.6, 1.6, 2.6, 2.2), 1.6)


@inner()
def _neck(x: float, y: float, z: float) -> float:
    d = capsule(x, y, z, 0.0, -5.0, -2.6, 0.0, -20.0, -4.4, 5.1, 5.5)
    d = join(d, capsule(x, y, z, 6.0, -3.5, -1.6, 1.2, -17.5, 1.2, 0.9, 1.0), 2.4)
    d = join(d, ellipsoid(x, y, z, 0.0, -12.0, 1.4, 0.9, 1.4, 1.0), 2.0)
    return join(d, capsule(x, y, z, 3.0, -14.0, -5.4, 9.0, -20.5, -5.2, 2.0, 2.4), 4.0)


@inner()
def _eye(d: float, x: float, y: float, z: float) -> float:
    d = carve(d, ellipsoid(x, y, z, 3.1, 0.80, 8.75, 2.0, 1.10, 1.7), 1.3)
    d = carve(d, ellipsoid(x, y, z, 1.55, 0.9, 8.75, 0.6, 0.9, 0.9), 0.9)
    d = join(d, ellipsoid(x, y, z, 3.15, 0.50, 6.55, 1.58, 1.36, 1.40), 0.5)
    # The crease above the upper lid, and the trough below the lower one.
    d = carve(d, capsule(x, y, z, 1.9, 1.50, 8.10, 4.6, 1.30, 7.30, 0.20, 0.22), 0.55)
    return carve(d, capsule(x, y, z, 2.0, -0.95, 8.75, 3.9, -1.35, 8.30, 0.05, 0.05), 1.5)


@inner()
def _nose(d: float, x: float, y: float, z: float) -> float:
    d = join(d, capsule(x, y, z, 0.0, 1.6, 7.75, 0.0, -2.2, 9.70, 0.62, 0.80), 1.1)
    d = join(d, capsule(x, y, z, 0.0, 0.4, 7.2, 0.62, -2.9, 8.6, 1.0, 1.30), 1.0)
    d = join(d, ellipsoid(x, y, z, 0.0, -2.70, 9.98, 0.92, 0.78, 0.82), 0.6)
    d = join(d, ellipsoid(x, y, z, 1.30, -3.05, 8.90, 0.66, 0.66, 0.92), 0.45)
    d = join(d, capsule(x, y, z, 0.0, -3.15, 10.05, 0.0, -3.75, 8.9, 0.36, 0.40), 0.35)
    # From the tip to the wing runs the edge of the nostril.
    d = join(d, capsule(x, y, z, 0.30, -3.15, 10.10, 1.40, -3.30, 9.10, 0.28, 0.34), 0.6)
    # The groove behind the wing of the nose, and the nostril, which leads upwards.
    d = carve(d, capsule(x, y, z, 2.15, -2.35, 9.15, 2.45, -3.5, 8.75, 0.22, 0.22), 0.9)
    return carve(d, capsule(x, y, z, 0.46, -3.80, 9.62, 0.76, -3.64, 9.15, 0.17, 0.25), 0.45)


@inner()
def _mouth(d: float, x: float, y: float, z: float) -> float:
    d = join(d, ellipsoid(x, y, z, 0.0, -5.9, 6.1, 3.3, 3.0, 3.05), 1.8)
    d = join(d, capsule(x, y, z, 0.42, -5.62, 9.02, 2.55, -6.05, 7.80, 0.52, 0.20), 0.30)
    d = join(d, capsule(x, y, z, 0.0, -6.68, 8.90, 2.35, -6.16, 7.80, 0.64, 0.22), 0.30)
    # The philtrum, the corner of the mouth, and the fold above the chin.
    d = carve(d, capsule(x, y, z, 0.0, -4.25, 9.55, 0.0, -5.05, 9.72, 0.20, 0.26), 0.5)
    d = carve(d, ellipsoid(x, y, z, 3.0, -6.2, 8.75, 0.35, 0.55, 0.45), 1.2)
    return carve(d, capsule(x, y, z, 0.0, -7.95, 9.5, 1.6, -7.85, 9.0, 0.45, 0.35), 1.0)


@kernel()
def distance(x: float, y: float, z: float) -> float:
    """Signed distance (cm, negative inside) to the head without ears, its eyes and its mouth still closed."""
    # A trace of asymmetry: no face is its own mirror image.
    x = x + 0.05 * np.sin(0.35 * y + 0.6) + 0.03 * np.sin(0.5 * z)
    y = y + 0.010 * x
    # Rounded, or what lies on both sides would meet in a crease: in a broad one what is large.
    side, broad = np.sqrt(x * x + 0.04), np.sqrt(x * x + 0.5)
    d = join(_skull(broad, y, z), _neck(broad, y, z), 2.2)
    d = _mouth(d, side, y, z)
    d = _nose(d, side, y, z)
    return _eye(d, side, y, z)


@kernel()
def outermost(origins: NDArray[np.float64], directions: NDArray[np.float64], far: float) -> NDArray[np.float64]:
    """Walk in from ``far`` along each ray until the surface: distances ``(V,)`` from the origins."""
    found = np.empty(len(origins))
    for i in range(len(origins)):
        t = far
        for _ in range(160):
            p = origins[i] + t * directions[i]
            d = distance(p[0], p[1], p[2])
            if d < 1e-4:
                break
            t -= 0.75 * d
            if t < 0.2:
                break
        found[i] = t
    return found
