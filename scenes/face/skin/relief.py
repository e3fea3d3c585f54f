"""The relief of the skin in millimetres and below: pores and grain of the neutral, folds of expressions.

Its slopes are the normal map, and with the oil of the skin it makes the roughness. It lies where the albedo of
:mod:`scenes.face.skin.albedo` has its pores, and that of :mod:`scenes.face.skin.wrinkles` its folds.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from facezip.machine.rows import map_rows
from scenes.face.features import LID_HALF_WIDTH, MOUTH_HALF_WIDTH
from scenes.face.head import Head
from scenes.face.skin.albedo import EYE_X
from scenes.face.skin.noise import cells, fractal, smooth
from scenes.face.skin.sampling import TexelGrid, at_texel
from scenes.face.skin.strain import Strain
from scenes.face.skin.wrinkles import depth_of, fields_of, folds
from scenes.face.skin.zones import bump, lips, propensity, scalp

# Steeper folds shade themselves; no scan sees into them.
STEEPEST = 1.5


@dataclass(frozen=True, eq=False)
class Relief:
    """What light meets besides colour.

    Attributes
    ----------
    slopes : ``(R, R, 2)`` float32, x/z and y/z of the tangent-space normal, x along u and y along v.
    roughness : ``(R, R, 1)`` float32 in [0, 1], as of a principled BSDF.
    """

    slopes: NDArray[np.float32]
    roughness: NDArray[np.float32]


def relief(head: Head, skin_strain: Strain, resolution: int, seed: int) -> Relief:
    """The relief of the person with this seed under a strain, on ``resolution`` x ``resolution`` texels."""
    texels = TexelGrid.of(head, resolution)
    fields = fields_of(skin_strain)
    height = np.empty((resolution, resolution), np.float32)
    roughness = np.empty((resolution, resolution, 1), np.float32)
    slopes = np.empty((resolution, resolution, 2), np.float32)
    rows = (head.rows.lower_lid, head.rows.upper_lid, head.rows.lower_lip, head.rows.upper_lip)
    map_rows(lambda top, bottom: _raise(top, bottom, *texels.arrays, rows, fields, seed, height, roughness), resolution)
    map_rows(lambda top, bottom: _incline(top, bottom, *texels.arrays[:3], height, slopes), resolution)
    return Relief(slopes, roughness)


@njit(cache=True, nogil=True)
def _raise(
    top: int,
    bottom: int,
    grid: NDArray[np.float32],
    row_of: NDArray[np.float64],
    column_of: NDArray[np.float64],
    texel: float,
    rows: tuple[int, int, int, int],
    fields: NDArray[np.float32],
    seed: int,
    height: NDArray[np.float32],
    roughness: NDArray[np.float32],
) -> None:
    p, f = np.empty(3), np.empty(8)
    for j in range(top, bottom):
        for i in range(len(column_of)):
            at_texel(grid, row_of[j], column_of[i], p)
            at_texel(fields, row_of[j], column_of[i], f)
            x, y, z = p
            row = row_of[j]
            if z > 4 and rows[0] - 0.4 < row < rows[1] + 0.4 and abs(abs(x) - EYE_X) < LID_HALF_WIDTH:
                height[j, i], roughness[j, i, 0] = 0.0, 0.22
                continue
            if z > 4 and rows[2] + 0.5 < row < rows[3] - 0.5 and abs(x) < MOUTH_HALF_WIDTH:
                height[j, i], roughness[j, i, 0] = 0.0, 0.22
                continue
            strength, spacing = propensity(x, y, z)
            depth, groove, ridge = depth_of(strength, f[0]), 0.0, 0.0
            if depth > 0.01:
                groove, ridge = folds(p, f, spacing, texel, seed)
            pressed, stretched = max(-f[1], 0.0), max(f[1], 0.0)
            grain = (1 + 0.8 * pressed) / (1 + 1.5 * stretched)
            height[j, i] = grain * _grain(x, y, z, texel, seed) + depth * spacing * (0.05 * ridge - 0.16 * groove)
            value = _oil(x, y, z, texel, seed) + 0.10 * depth * groove + 0.06 * pressed - 0.14 * min(stretched, 1.0)
            roughness[j, i, 0] = min(max(value, 0.1), 0.9)


@njit(cache=True, nogil=True)
def _grain(x: float, y: float, z: float, texel: float, seed: int) -> float:
    """Pores, grain and creases of the lips, in cm."""
    total = 0.010 * fractal(x, y, z, 0.34, 3, texel, seed + 51)
    size = 0.105 + 0.03 * bump(x, y, 1.8, -2.6, 2.2, 1.6)
    visible = smooth(0.9 * texel, 2.2 * texel, size)
    if visible > 0:
        near, number = cells(x, y, z, size, seed + 71)
        total -= 0.006 * visible * (0.4 + 0.6 * number) * smooth(0.42, 0.08, near)
    lip = lips(x, y, z)
    if lip > 0:
        total += 0.02 * lip * fractal(7.5 * x, 1.1 * y, 0.8 * z, 1.0, 3, 7.5 * texel, seed + 181)
    return total


@njit(cache=True, nogil=True)
def _oil(x: float, y: float, z: float, texel: float, seed: int) -> float:
    """Roughness of the neutral: oily forehead, nose and chin, wet lips, matte cheeks, stubble."""
    front = smooth(1.0, 5.0, z)
    oily = (
        bump(x, y, 0.0, -2.2, 1.3, 2.2) + 0.7 * bump(x, y, 0.0, 4.6, 3.2, 2.2) + 0.5 * bump(x, y, 0.0, -9.0, 1.4, 1.2)
    )
    value = 0.52 - 0.13 * front * oily + 0.03 * fractal(x, y, z, 2.6, 4, texel, seed + 411)
    value += 0.06 * scalp(x, y, z) - 0.20 * lips(x, y, z)
    return value


@njit(cache=True, nogil=True)
def _incline(
    top: int,
    bottom: int,
    grid: NDArray[np.float32],
    row_of: NDArray[np.float64],
    column_of: NDArray[np.float64],
    height: NDArray[np.float32],
    out: NDArray[np.float32],
) -> None:
    """Slopes of heights in cm, by central differences over the distances between texels on the head."""
    last = len(column_of) - 1
    a, b = np.empty(3), np.empty(3)
    for j in range(top, bottom):
        above, below = max(j - 1, 0), min(j + 1, last)
        for i in range(last + 1):
            left, right = max(i - 1, 0), min(i + 1, last)
            at_texel(grid, row_of[j], column_of[left], a)
            at_texel(grid, row_of[j], column_of[right], b)
            out[j, i, 0] = _slope(height[j, right] - height[j, left], a, b)
            at_texel(grid, row_of[below], column_of[i], a)
            at_texel(grid, row_of[above], column_of[i], b)
            out[j, i, 1] = _slope(height[above, i] - height[below, i], a, b)


@njit(cache=True, nogil=True)
def _slope(rise: float, a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    way = np.sqrt((b[0] - a[0]) ** 2 + (b[1] - a[1]) ** 2 + (b[2] - a[2]) ** 2)
    return min(max(-rise / max(way, 1e-3), -STEEPEST), STEEPEST)
