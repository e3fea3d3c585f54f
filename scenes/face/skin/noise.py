"""Noise over the skin, in centimetres, faded out where it is finer than a texel."""

import numpy as np

from facezip.machine.kernels import inner, kernel


@kernel()
def hashed(i: int, j: int, k: int, seed: int) -> float:
    """A number in [0, 1) for a lattice point, the same on every machine."""
    h = (i * 0x8DA6B343) ^ (j * 0xD8163841) ^ (k * 0xCB1AB31F) ^ (seed * 0x9E3779B1)
    h &= 0xFFFFFFFF
    h = ((h ^ (h >> 15)) * 0x2C1B3C6D) & 0xFFFFFFFF
    h = ((h ^ (h >> 12)) * 0x297A2D39) & 0xFFFFFFFF
    return (h ^ (h >> 15)) / 4294967296.0


@inner()
def smooth(low: float, high: float, x: float) -> float:
    """Hermite step from 0 at ``low`` to 1 at ``high``."""
    t = min(max((x - low) / (high - low), 0.0), 1.0)
    return t * t * (3 - 2 * t)


@kernel()
def value_noise(x: float, y: float, z: float, seed: int) -> float:
    """Smooth noise in [-1, 1] with features of one unit."""
    i, j, k = int(np.floor(x)), int(np.floor(y)), int(np.floor(z))
    u, v, w = x - i, y - j, z - k
    u, v, w = u * u * (3 - 2 * u), v * v * (3 - 2 * v), w * w * (3 - 2 * w)
    total = 0.0
    for a in range(2):
        for b in range(2):
            for c in range(2):
                weight = (u if a else 1 - u) * (v if b else 1 - v) * (w if c else 1 - w)
                total += weight * hashed(i + a, j + b, k + c, seed)
    return 2 * total - 1


@kernel()
def fractal(x: float, y: float, z: float, wavelength: float, octaves: int, texel: float, seed: int) -> float:
    """Octaves of noise from a wavelength in cm downwards, each faded out as it nears two texels."""
    total, amplitude = 0.0, 1.0
    for octave in range(octaves):
        visible = smooth(1.5 * texel, 3.0 * texel, wavelength)
        if visible > 0:
            f = 1 / wavelength
            total += visible * amplitude * value_noise(x * f, y * f, z * f, seed + octave)
        wavelength *= 0.5
        amplitude *= 0.6
    return total


@kernel()
def cells(x: float, y: float, z: float, size: float, seed: int) -> tuple[float, float]:
    """Distance (in cells) to the nearest of scattered points, one a cell of ``size`` cm, and that point's number."""
    nearest, _, number = two_cells(x, y, z, size, seed)
    return nearest, number


@inner()
def two_cells(x: float, y: float, z: float, size: float, seed: int) -> tuple[float, float, float]:
    """As :func:`cells`, with the distance to the second nearest point between: where both are equal, cells meet."""
    x, y, z = x / size, y / size, z / size
    i, j, k = int(np.floor(x)), int(np.floor(y)), int(np.floor(z))
    nearest, second, number = 9.0, 9.0, 0.0
    for a in range(i - 1, i + 2):
        for b in range(j - 1, j + 2):
            for c in range(k - 1, k + 2):
                dx = a + hashed(a, b, c, seed) - x
                dy = b + hashed(a, b, c, seed + 1) - y
                dz = c + hashed(a, b, c, seed + 2) - z
                d = dx * dx + dy * dy + dz * dz
                if d < nearest:
                    nearest, second, number = d, nearest, hashed(a, b, c, seed + 3)
                elif d < second:
                    second = d
    return np.sqrt(nearest), np.sqrt(second), number
