"""The relief of the skin in millimetres and below: pores and grain of the neutral, folds of expressions.

Its slopes are the normal map, its hollows the cavity map; with the oil of the skin it makes roughness and specular. It
lies where the albedo of :mod:`scenes.face.skin.albedo` has its pores, and that of :mod:`scenes.face.skin.wrinkles` its
folds.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from facezip.machine.rows import map_rows
from scenes.face.features import LID_HALF_WIDTH, MOUTH_HALF_WIDTH
from scenes.face.head import Head
from scenes.face.skin.albedo import EYE_X, EYE_Y
from scenes.face.skin.gloss import WET, hollow, roughness, specular
from scenes.face.skin.noise import cells, fractal, smooth
from scenes.face.skin.sampling import TexelGrid, at_texel
from scenes.face.skin.strain import Strain
from scenes.face.skin.wrinkles import depth_of, fields_of, folds
from scenes.face.skin.zones import bump, lips, propensity

# Steeper folds shade themselves; no scan sees into them.
STEEPEST = 1.2
# Texels that a fold is seen with at least: slopes need more of them than colours do.
SOFT = 1.5
# How far around a point its surroundings reach (cm), and how deep below them (cm) two thirds of a highlight are gone.
REACH, DEEP = 0.11, 0.022


@dataclass(frozen=True, eq=False)
class Relief:
    """What light meets besides colour.

    Attributes
    ----------
    slopes : ``(R, R, 2)`` float32, x/z and y/z of the tangent-space normal, x along u and y along v.
    roughness : ``(R, R, 1)`` float32 in [0, 1], as of a principled BSDF.
    specular : ``(R, R, 1)`` float32 in [0, 1], a reflectance of 0.08 · specular at normal incidence.
    cavity : ``(R, R, 1)`` float32 in [0, 1], the share of a highlight that comes out of the relief.
    """

    slopes: NDArray[np.float32]
    roughness: NDArray[np.float32]
    specular: NDArray[np.float32]
    cavity: NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Ground:
    """What expressions fold: the relief of the neutral, the same under all of them.

    Attributes
    ----------
    texels : where it lies on the head.
    height : ``(R, R)`` float32, cm, of pores and grain.
    gloss : ``(R, R, 3)`` float32: roughness, specular, and what hollows larger than the relief let out.
    skin : ``(R, R)``, false on eyes and in the mouth, where nothing folds.
    seed : which person.
    """

    texels: TexelGrid
    height: NDArray[np.float32]
    gloss: NDArray[np.float32]
    skin: NDArray[np.bool_]
    seed: int

    @staticmethod
    def of(head: Head, resolution: int, seed: int) -> "Ground":
        """The person with this seed, on ``resolution`` x ``resolution`` texels."""
        texels, square = TexelGrid.of(head, resolution), (resolution, resolution)
        height, gloss = np.empty(square, np.float32), np.empty((*square, 3), np.float32)
        skin = np.ones(square, np.bool_)
        rows = (head.rows.lower_lid, head.rows.upper_lid, head.rows.lower_lip, head.rows.upper_lip)
        map_rows(lambda top, bottom: _lay(top, bottom, *texels.arrays, rows, seed, height, gloss, skin), resolution)
        return Ground(texels, height, gloss, skin, seed)

    def under(self, skin_strain: Strain) -> Relief:
        """The relief under a strain."""
        fields, height, gloss = fields_of(skin_strain), self.height.copy(), self.gloss.copy()
        slopes = np.empty((*height.shape, 2), np.float32)
        arrays = self.texels.arrays

        def fold(top: int, bottom: int) -> None:
            _fold(top, bottom, *arrays, fields, self.seed, self.skin, height, gloss)

        map_rows(fold, len(height))
        map_rows(lambda top, bottom: _incline(top, bottom, *arrays[:3], self.skin, height, slopes), len(height))
        height *= self.skin
        below = np.maximum(gaussian_filter(height, REACH / self.texels.texel, mode="nearest") - height, 0)
        gloss[..., 2] *= np.exp(-below / np.float32(DEEP))
        return Relief(slopes, *(np.ascontiguousarray(gloss[..., n : n + 1]) for n in range(3)))


@njit(cache=True, nogil=True)
def _lay(
    top: int,
    bottom: int,
    grid: NDArray[np.float32],
    row_of: NDArray[np.float64],
    column_of: NDArray[np.float64],
    texel: float,
    rows: tuple[int, int, int, int],
    seed: int,
    height: NDArray[np.float32],
    gloss: NDArray[np.float32],
    skin: NDArray[np.bool_],
) -> None:
    p = np.empty(3)
    for j in range(top, bottom):
        for i in range(len(column_of)):
            at_texel(grid, row_of[j], column_of[i], p)
            x, y, z = p
            row = row_of[j]
            eye = z > 4 and rows[0] - 0.4 < row < rows[1] + 0.4 and abs(abs(x) - EYE_X) < LID_HALF_WIDTH
            mouth = z > 4 and rows[2] + 0.5 < row < rows[3] - 0.5 and abs(x) < MOUTH_HALF_WIDTH
            if eye or mouth:
                height[j, i] = _eye(abs(x) - EYE_X, y - EYE_Y) if eye else 0.0
                skin[j, i], gloss[j, i, 0], gloss[j, i, 1] = False, WET[0], WET[1]
                gloss[j, i, 2] = 0.4 if mouth else 1.0
                continue
            height[j, i] = _grain(x, y, z, texel, seed)
            gloss[j, i, 0] = roughness(x, y, z, texel, seed)
            gloss[j, i, 1] = specular(x, y, z, texel, seed)
            gloss[j, i, 2] = 1 - hollow(x, y, z)


@njit(cache=True, nogil=True)
def _eye(dx: float, dy: float) -> float:
    """A ball is rounder than the mesh of the eye, which bulges from lid to lid alone; the cornea stands out of it."""
    return 0.10 * np.exp(-(dx * dx + dy * dy) / 0.5**2) - 0.16 * dx * dx


@njit(cache=True, nogil=True)
def _fold(
    top: int,
    bottom: int,
    grid: NDArray[np.float32],
    row_of: NDArray[np.float64],
    column_of: NDArray[np.float64],
    texel: float,
    fields: NDArray[np.float32],
    seed: int,
    skin: NDArray[np.bool_],
    height: NDArray[np.float32],
    gloss: NDArray[np.float32],
) -> None:
    p, f = np.empty(3), np.empty(8)
    for j in range(top, bottom):
        for i in range(len(column_of)):
            if not skin[j, i]:
                continue
            at_texel(fields, row_of[j], column_of[i], f)
            pressed, stretched = max(-f[1], 0.0), max(f[1], 0.0)
            height[j, i] *= (1 + 0.8 * pressed) / (1 + 1.5 * stretched)
            rough = gloss[j, i, 0] + 0.06 * pressed - 0.14 * min(stretched, 1.0)
            at_texel(grid, row_of[j], column_of[i], p)
            strength, spacing = propensity(p[0], p[1], p[2])
            depth = depth_of(strength, f[0])
            if depth > 0.01:
                groove, ridge = folds(p, f, spacing, SOFT * texel, seed)
                height[j, i] += depth * spacing * (0.03 * ridge - 0.075 * groove)
                rough += 0.08 * depth * groove
            gloss[j, i, 0] = min(max(rough, 0.1), 0.9)


@njit(cache=True, nogil=True)
def _grain(x: float, y: float, z: float, texel: float, seed: int) -> float:
    """Pores, grain and creases of the lips, in cm."""
    cheek = bump(x, y, 2.2, -2.6, 2.0, 1.6)
    total = 0.0045 * fractal(x, y, z, 0.34, 2, texel, seed + 51)
    total += (0.0040 + 0.0015 * cheek) * fractal(x, y, z, 0.16, 3, texel, seed + 53)
    size = 0.105 + 0.03 * bump(x, y, 1.8, -2.6, 2.2, 1.6)
    visible = smooth(1.2 * texel, 3.0 * texel, size)
    if visible > 0:
        near, number = cells(x, y, z, size, seed + 71)
        deep = 0.004 + 0.004 * bump(x, y, 1.2, -2.6, 2.2, 1.8)
        total -= deep * visible * (0.4 + 0.6 * number) * smooth(0.42, 0.08, near)
    lip = lips(x, y, z)
    if lip > 0:
        total *= 1 - 0.7 * lip
        total += 0.014 * lip * fractal(7.5 * x, 1.1 * y, 0.8 * z, 1.0, 3, 7.5 * texel, seed + 181)
    return total


@njit(cache=True, nogil=True)
def _incline(
    top: int,
    bottom: int,
    grid: NDArray[np.float32],
    row_of: NDArray[np.float64],
    column_of: NDArray[np.float64],
    skin: NDArray[np.bool_],
    height: NDArray[np.float32],
    out: NDArray[np.float32],
) -> None:
    """Slopes of heights in cm, by differences over the distances between texels on the head; none across a lid."""
    last = len(column_of) - 1
    a, b = np.empty(3), np.empty(3)
    for j in range(top, bottom):
        for i in range(last + 1):
            here = skin[j, i]
            left = i - 1 if i > 0 and skin[j, i - 1] == here else i
            right = i + 1 if i < last and skin[j, i + 1] == here else i
            at_texel(grid, row_of[j], column_of[left], a)
            at_texel(grid, row_of[j], column_of[right], b)
            out[j, i, 0] = _slope(height[j, right] - height[j, left], a, b)
            above = j - 1 if j > 0 and skin[j - 1, i] == here else j
            below = j + 1 if j < last and skin[j + 1, i] == here else j
            at_texel(grid, row_of[below], column_of[i], a)
            at_texel(grid, row_of[above], column_of[i], b)
            out[j, i, 1] = _slope(height[above, i] - height[below, i], a, b)


@njit(cache=True, nogil=True)
def _slope(rise: float, a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    way = np.sqrt((b[0] - a[0]) ** 2 + (b[1] - a[1]) ** 2 + (b[2] - a[2]) ** 2)
    return min(max(-rise / max(way, 1e-3), -STEEPEST), STEEPEST)
