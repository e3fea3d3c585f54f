"""What an expression does to the albedo: folds where skin is pressed together, and blood that is pressed in or out."""

import numpy as np
from numpy.typing import NDArray

from facezip.machine.kernels import kernel
from facezip.machine.rows import map_rows
from scenes.face.skin.creases import LAYERS, Creases, depths, profile
from scenes.face.skin.sampling import TexelGrid, at_texel
from scenes.face.skin.strain import Strain

# Below this change of the metric nothing shows.
STILL = 0.006
# How much light a fold of full depth keeps from its valley, for a fold as wide as the reference (cm).
SHADE, REFERENCE = 0.30, 0.09


def wrinkled(
    albedo: NDArray[np.float32], texels: TexelGrid, creases: Creases, skin_strain: Strain
) -> NDArray[np.float32]:
    """The albedo ``(R, R, 3)`` of a face at rest under a strain; equal to ``albedo`` where there is none."""
    fields, out = skin_strain.fields, albedo.copy()
    map_rows(lambda top, bottom: _fold(top, bottom, texels, creases, fields, False, out), len(albedo))
    return out


def rested(albedo: NDArray[np.float32], texels: TexelGrid, creases: Creases) -> None:
    """Draw the lines that a face has at rest into an albedo ``(R, R, 3)``, in place."""
    still = np.zeros((*texels.grid.shape[:2], 4), np.float32)
    map_rows(lambda top, bottom: _fold(top, bottom, texels, creases, still, True, albedo), len(albedo))


@kernel()
def _fold(
    top: int,
    bottom: int,
    texels: TexelGrid,
    creases: Creases,
    fields: NDArray[np.float32],
    at_rest: bool,
    out: NDArray[np.float32],
) -> None:
    p, f = np.empty(3), np.empty(4)
    for j in range(top, bottom):
        for i in range(len(texels.column_of)):
            at_texel(fields, texels.row_of[j], texels.column_of[i], f)
            if not at_rest and abs(f[0]) + abs(f[1]) + abs(f[2]) < STILL:
                continue
            # Pressed skin flushes, stretched skin pales.
            flush, pale = 0.55 * (1 - np.exp(-3.0 * max(-f[3], 0.0))), 0.35 * (1 - np.exp(-2.0 * max(f[3], 0.0)))
            dark, light = 0.0, 0.05 * pale
            placed = False
            for layer in range(LAYERS):
                number = creases.nearest[layer, j, i]
                if number < 0:
                    continue
                point = creases.points[number]
                rest, deep = depths(point, f)
                if deep == rest and not at_rest:
                    continue
                if not placed:
                    at_texel(texels.grid, texels.row_of[j], texels.column_of[i], p)
                    placed = True
                for depth, sign in ((deep, 1.0), (0.0 if at_rest else rest, -1.0)):
                    if depth > 0:
                        valley, ridge, width = profile(point, p, depth, texels.texel)
                        soft = SHADE * min(1.0, REFERENCE / width) ** 0.5
                        dark += sign * soft * depth * valley
                        light += sign * 0.045 * depth * ridge
            # Valleys keep the blue and the green of the light, and scatter red.
            out[j, i, 0] = min(out[j, i, 0] * (1 - 0.80 * dark) * (1 - 0.05 * flush) * (1 + light), 1.0)
            out[j, i, 1] = min(out[j, i, 1] * (1 - 1.05 * dark) * (1 - 0.22 * flush) * (1 + light + 0.06 * pale), 1.0)
            out[j, i, 2] = min(out[j, i, 2] * (1 - 1.05 * dark) * (1 - 0.20 * flush) * (1 + light + 0.06 * pale), 1.0)
