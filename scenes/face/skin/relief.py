"""The relief of the skin in millimetres and below: pores and grain of the neutral, folds of expressions.

Its slopes are the normal map, its hollows the cavity map; with the oil of the skin it makes roughness and specular.
Folds lie where :mod:`scenes.face.skin.wrinkles` darkens the albedo: valleys between ridges that catch the light.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from facezip.machine.kernels import inner, kernel
from facezip.machine.rows import map_rows
from scenes.face.skin.creases import LAYERS, Creases, depths, profile
from scenes.face.skin.ground import Ground
from scenes.face.skin.sampling import TexelGrid, at_texel
from scenes.face.skin.strain import Strain

# Steeper folds shade themselves; no scan sees into them.
STEEPEST = 1.2
# How much of a highlight a fold of full depth keeps in its valley, besides what the relief around it does.
SHADE = 0.35
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


def relief(ground: Ground, texels: TexelGrid, creases: Creases, skin_strain: Strain) -> Relief:
    """The relief of a person's skin under a strain."""
    fields, height, gloss = skin_strain.fields, ground.height.copy(), ground.gloss.copy()
    slopes = np.empty((*height.shape, 2), np.float32)

    def fold(top: int, bottom: int) -> None:
        _fold(top, bottom, texels, creases, fields, ground.skin, height, gloss)

    map_rows(fold, len(height))
    map_rows(lambda top, bottom: _incline(top, bottom, texels, ground.skin, height, slopes), len(height))
    height *= ground.skin
    below = np.maximum(gaussian_filter(height, REACH / texels.texel, mode="nearest") - height, 0)
    gloss[..., 2] *= np.exp(-below / np.float32(DEEP))
    return Relief(slopes, *(np.ascontiguousarray(gloss[..., n : n + 1]) for n in range(3)))


@kernel()
def _fold(
    top: int,
    bottom: int,
    texels: TexelGrid,
    creases: Creases,
    fields: NDArray[np.float32],
    skin: NDArray[np.bool_],
    height: NDArray[np.float32],
    gloss: NDArray[np.float32],
) -> None:
    p, f = np.empty(3), np.empty(4)
    for j in range(top, bottom):
        for i in range(len(texels.column_of)):
            if not skin[j, i]:
                continue
            at_texel(fields, texels.row_of[j], texels.column_of[i], f)
            pressed, stretched = max(-f[3], 0.0), max(f[3], 0.0)
            # Pressed skin crinkles, stretched skin is smooth and shines.
            height[j, i] *= (1 + 1.6 * pressed) / (1 + 1.5 * stretched)
            rough = gloss[j, i, 0] + 0.06 * pressed - 0.14 * min(stretched, 1.0)
            placed = False
            for layer in range(LAYERS):
                number = creases.nearest[layer, j, i]
                if number < 0:
                    continue
                point = creases.points[number]
                _, depth = depths(point, f)
                if depth < 0.01:
                    continue
                if not placed:
                    at_texel(texels.grid, texels.row_of[j], texels.column_of[i], p)
                    placed = True
                valley, ridge, width = profile(point, p, depth, texels.texel)
                height[j, i] += point[11] * width * depth * (0.55 * ridge - 1.0 * valley)
                rough += 0.08 * depth * valley
                gloss[j, i, 2] *= 1 - SHADE * depth * valley
            gloss[j, i, 0] = min(max(rough, 0.1), 0.9)


@kernel()
def _incline(
    top: int,
    bottom: int,
    texels: TexelGrid,
    skin: NDArray[np.bool_],
    height: NDArray[np.float32],
    out: NDArray[np.float32],
) -> None:
    """Slopes of heights in cm, by differences over the distances between texels on the head; none across a lid."""
    last = len(texels.column_of) - 1
    a, b = np.empty(3), np.empty(3)
    for j in range(top, bottom):
        for i in range(last + 1):
            here = skin[j, i]
            left = i - 1 if i > 0 and skin[j, i - 1] == here else i
            right = i + 1 if i < last and skin[j, i + 1] == here else i
            at_texel(texels.grid, texels.row_of[j], texels.column_of[left], a)
            at_texel(texels.grid, texels.row_of[j], texels.column_of[right], b)
            out[j, i, 0] = _slope(height[j, right] - height[j, left], a, b)
            above = j - 1 if j > 0 and skin[j - 1, i] == here else j
            below = j + 1 if j < last and skin[j + 1, i] == here else j
            at_texel(texels.grid, texels.row_of[below], texels.column_of[i], a)
            at_texel(texels.grid, texels.row_of[above], texels.column_of[i], b)
            out[j, i, 1] = _slope(height[above, i] - height[below, i], a, b)


@inner()
def _slope(rise: float, a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    way = np.sqrt((b[0] - a[0]) ** 2 + (b[1] - a[1]) ** 2 + (b[2] - a[2]) ** 2)
    return min(max(-rise / max(way, 1e-3), -STEEPEST), STEEPEST)
