"""The relief of the neutral skin, as deep as it is: pores, lattice, furrows of the lips, hair; and how skin shines.

It lies where the albedo of :mod:`scenes.face.skin.albedo` has its pores and its hair.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facezip.machine.kernels import inner, kernel
from facezip.machine.rows import map_rows
from scenes.face.features import LID_HALF_WIDTH, MOUTH_HALF_WIDTH, Rows
from scenes.face.skin.albedo import lip_furrow
from scenes.face.skin.eye import EYE_X, eye_height
from scenes.face.skin.gloss import EYE, MOUTH, hollow, roughness, specular
from scenes.face.skin.noise import fractal, smooth, two_cells
from scenes.face.skin.sampling import TexelGrid, at_texel
from scenes.face.skin.zones import bump, lips, pore_size

# How far a hair stands off the skin, cm.
HAIR_HEIGHT = 0.006


@dataclass(frozen=True, eq=False)
class Ground:
    """What expressions fold, the same under all of them.

    Attributes
    ----------
    height : ``(R, R)`` float32, cm, of pores, grain and hair.
    gloss : ``(R, R, 3)`` float32: roughness, specular, and what hollows larger than the relief let out.
    skin : ``(R, R)``, false on eyes and in the mouth, where nothing folds.
    """

    height: NDArray[np.float32]
    gloss: NDArray[np.float32]
    skin: NDArray[np.bool_]

    @staticmethod
    def of(rows: Rows, texels: TexelGrid, seed: int, hair: NDArray[np.float32]) -> "Ground":
        """That of a person; ``hair`` ``(R, R)`` is how much of a texel it covers."""
        height, gloss = np.empty(hair.shape, np.float32), np.empty((*hair.shape, 3), np.float32)
        skin = np.ones(hair.shape, np.bool_)
        map_rows(lambda top, bottom: _lay(top, bottom, texels, rows, seed, hair, height, gloss, skin), len(hair))
        return Ground(height, gloss, skin)


@kernel()
def _lay(
    top: int,
    bottom: int,
    texels: TexelGrid,
    rows: Rows,
    seed: int,
    hair: NDArray[np.float32],
    height: NDArray[np.float32],
    gloss: NDArray[np.float32],
    skin: NDArray[np.bool_],
) -> None:
    p = np.empty(3)
    for j in range(top, bottom):
        for i in range(len(texels.column_of)):
            at_texel(texels.grid, texels.row_of[j], texels.column_of[i], p)
            x, y, z = p
            row = texels.row_of[j]
            eye = z > 4 and rows.lower_lid - 0.4 < row < rows.upper_lid + 0.4 and abs(abs(x) - EYE_X) < LID_HALF_WIDTH
            mouth = z > 4 and rows.lower_lip + 0.5 < row < rows.upper_lip - 0.5 and abs(x) < MOUTH_HALF_WIDTH
            if eye or mouth:
                height[j, i] = eye_height(x, y) if eye else 0.0
                wet = EYE if eye else MOUTH
                skin[j, i], gloss[j, i, 0], gloss[j, i, 1] = False, wet[0], wet[1]
                gloss[j, i, 2] = 0.4 if mouth else 1.0
                continue
            height[j, i] = _grain(x, y, z, texels.texel, seed) + HAIR_HEIGHT * hair[j, i]
            # Hair scatters what the skin beneath it would mirror.
            gloss[j, i, 0] = roughness(x, y, z, texels.texel, seed) + 0.06 * hair[j, i]
            gloss[j, i, 1] = specular(x, y, z, texels.texel, seed) - 0.20 * hair[j, i]
            gloss[j, i, 2] = 1 - hollow(x, y, z)


@inner()
def _grain(x: float, y: float, z: float, texel: float, seed: int) -> float:
    """Pores, the lattice of fine lines between them, and furrows of the lips, in cm."""
    size, deep = pore_size(x, y, z)
    # Lines of the forehead and the throat lie across, so cells of the lattice are wider than high there.
    wide = 1 - 0.35 * min(bump(x, y, 0.0, 5.2, 4.5, 2.2) + smooth(-10.5, -12.0, y), 1.0)
    total = 0.0035 * fractal(x, y, z, 0.42, 2, texel, seed + 51)
    total += 0.0040 * fractal(x * wide, y, z, 0.15, 3, texel, seed + 53)
    visible = smooth(1.2 * texel, 3.0 * texel, size)
    if visible > 0:
        near, second, number = two_cells(x * wide, y, z, size, seed + 71)
        total -= visible * (0.0022 + 0.0048 * deep) * (0.3 + 0.7 * number) * smooth(0.40, 0.10, near)
        total -= visible * 0.0028 * (1 - 0.55 * deep) * smooth(0.16, 0.0, second - near)
    chin = bump(x, y, 0.0, -8.9, 1.6, 1.0)
    if chin > 0.02:
        total += 0.010 * chin * fractal(x, y, z, 0.34, 2, texel, seed + 57)
    lip = lips(x, y, z)
    if lip > 0:
        total *= 1 - 0.6 * lip
        total -= 0.014 * lip * lip_furrow(x, y, z, texel, seed)
    return total
