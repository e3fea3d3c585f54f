"""The relief of the neutral skin: pores, grain and creases of the lips, as deep as they are, and how skin shines there.

It lies where the albedo of :mod:`scenes.face.skin.albedo` has its pores.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facezip.machine.kernels import inner, kernel
from facezip.machine.rows import map_rows
from scenes.face.features import LID_HALF_WIDTH, MOUTH_HALF_WIDTH, Rows
from scenes.face.head import Head
from scenes.face.skin.albedo import EYE_X, EYE_Y
from scenes.face.skin.gloss import WET, hollow, roughness, specular
from scenes.face.skin.noise import cells, fractal, smooth
from scenes.face.skin.sampling import TexelGrid, at_texel
from scenes.face.skin.zones import bump, lips


@dataclass(frozen=True, eq=False)
class Ground:
    """What expressions fold, the same under all of them.

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
        map_rows(lambda top, bottom: _lay(top, bottom, texels, head.rows, seed, height, gloss, skin), resolution)
        return Ground(texels, height, gloss, skin, seed)


@kernel()
def _lay(
    top: int,
    bottom: int,
    texels: TexelGrid,
    rows: Rows,
    seed: int,
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
                height[j, i] = _eye(abs(x) - EYE_X, y - EYE_Y) if eye else 0.0
                skin[j, i], gloss[j, i, 0], gloss[j, i, 1] = False, WET[0], WET[1]
                gloss[j, i, 2] = 0.4 if mouth else 1.0
                continue
            height[j, i] = _grain(x, y, z, texels.texel, seed)
            gloss[j, i, 0] = roughness(x, y, z, texels.texel, seed)
            gloss[j, i, 1] = specular(x, y, z, texels.texel, seed)
            gloss[j, i, 2] = 1 - hollow(x, y, z)


@inner()
def _eye(dx: float, dy: float) -> float:
    """A ball is rounder than the mesh of the eye, which bulges from lid to lid alone; the cornea stands out of it."""
    return 0.10 * np.exp(-(dx * dx + dy * dy) / 0.5**2) - 0.16 * dx * dx


@inner()
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
