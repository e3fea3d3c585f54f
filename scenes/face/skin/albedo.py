"""The albedo of the neutral skin, evaluated at every texel: tone, blood, pores, spots, lips, hair."""

import numpy as np
from numpy.typing import NDArray

from facezip.machine.kernels import inner, kernel
from facezip.machine.rows import map_rows
from scenes.face.features import LID_HALF_WIDTH, MOUTH_HALF_WIDTH, Rows
from scenes.face.skin.eye import EYE_X, paint_eye
from scenes.face.skin.mouth import paint_mouth
from scenes.face.skin.noise import cells, fractal, smooth, value_noise
from scenes.face.skin.sampling import TexelGrid, at_texel
from scenes.face.skin.zones import (
    beard,
    bump,
    from_lid_crease,
    from_mouth_line,
    from_nostril,
    lips,
    pore_size,
    redness,
    scalp,
)
from scenes.face.traits import Traits


def neutral_albedo(rows: Rows, texels: TexelGrid, person: Traits, hair: NDArray[np.float32]) -> NDArray[np.float32]:
    """``(R, R, 3)`` float32 in [0, 1], encoded sRGB; nothing is upscaled. ``hair`` is how much of a texel it covers."""
    out = np.empty((*hair.shape, 3), np.float32)
    worn = person.worn
    map_rows(lambda top, bottom: _paint(top, bottom, texels, rows, person, worn, hair, out), len(out))
    return out


@kernel()
def _paint(
    top: int,
    bottom: int,
    texels: TexelGrid,
    rows: Rows,
    person: Traits,
    worn: float,
    hair: NDArray[np.float32],
    out: NDArray[np.float32],
) -> None:
    p, colour = np.empty(3), np.empty(3)
    for j in range(top, bottom):
        row = texels.row_of[j]
        for i in range(len(texels.column_of)):
            at_texel(texels.grid, row, texels.column_of[i], p)
            x, y, z = p
            _skin(x, y, z, texels.texel, person, worn, colour)
            lash = 1.0
            if z > 4:
                if rows.lower_lid - 1.2 < row < rows.upper_lid + 1.2 and abs(abs(x) - EYE_X) < LID_HALF_WIDTH:
                    paint_eye(x, y, z, row, rows, texels.texel, person, colour)
                    lash = 0.3
                if rows.lower_lip < row < rows.upper_lip and abs(x) < MOUTH_HALF_WIDTH * 0.995:
                    paint_mouth(x, y, z, row - rows.lower_lip, person.seed, colour)
            for c in range(3):
                colour[c] += hair[j, i] * (lash * person.hair[c] - colour[c])
                out[j, i, c] = min(max(colour[c], 0.0), 1.0)


@kernel()
def _skin(x: float, y: float, z: float, texel: float, person: Traits, worn: float, colour: NDArray[np.float64]) -> None:
    seed = person.seed
    blotch = fractal(x, y, z, 2.6, 4, texel, seed + 11)
    capillary = fractal(x, y, z, 0.55, 4, texel, seed + 21)
    tone = fractal(x, y, z, 5.0, 3, texel, seed + 31)
    fine = fractal(x, y, z, 0.17, 3, texel, seed + 51)
    red = redness(x, y, z)
    blood = person.blood * (red * (1 + 0.35 * blotch + 0.30 * capillary) + 0.10 * blotch + 0.11 * capillary)
    # Melanin lies unevenly, the more so the older the skin.
    pigment = 0.5 * tone + 0.35 * blotch + (0.35 + 0.3 * worn) * fractal(x, y, z, 0.9, 3, texel, seed + 41)
    light = 1 - 0.030 * pigment + 0.026 * fine
    colour[0] = person.skin[0] * light * (1 - 0.055 * blood)
    colour[1] = person.skin[1] * light * (1 - 0.012 * pigment) * (1 - 0.215 * blood)
    colour[2] = person.skin[2] * light * (1 - 0.024 * pigment) * (1 - 0.190 * blood)
    _tints(x, y, z, person, worn, colour)
    _pores(x, y, z, texel, seed, colour)
    _spots(x, y, z, texel, person, worn, colour)
    _lips(x, y, z, texel, person, colour)
    _hollows(x, y, z, colour)


@inner()
def _tints(x: float, y: float, z: float, person: Traits, worn: float, colour: NDArray[np.float64]) -> None:
    """Thin skin over blood and muscle around the eyes, bone under the forehead, roots of hair under the skin."""
    if z > 3:
        under = bump(x, y, 2.7, -0.42, 1.15, 0.42) + 0.8 * bump(x, y, 1.75, 0.3, 0.35, 0.7)
        darken(colour, (0.07 + 0.08 * worn) * under, 1.0, 1.25, 0.85)
        darken(colour, 0.075 * bump(x, y, 3.1, 1.35, 1.6, 0.5), 0.7, 1.2, 1.1)
        darken(colour, 0.03 * bump(x, y, 0.0, 5.2, 3.6, 1.6), -0.4, 0.1, 1.5)
        darken(colour, 0.05 * bump(x, y, 3.0, -6.3, 0.7, 0.6), 0.8, 1.2, 1.1)
    darken(colour, 0.13 * person.beard * beard(x, y, z), 1.25, 0.95, 0.75)
    darken(colour, 0.20 * scalp(x, y, z, person.female), 1.2, 1.0, 0.85)


@inner()
def _pores(x: float, y: float, z: float, texel: float, seed: int, colour: NDArray[np.float64]) -> None:
    """Dark where they are deep: widest on the nose and beside it."""
    size, deep = pore_size(x, y, z)
    visible = smooth(0.9 * texel, 2.2 * texel, size)
    if visible > 0:
        near, number = cells(x, y, z, size, seed + 71)
        open_ = 0.16 + 0.20 * number
        darken(
            colour,
            visible * (0.04 + 0.15 * deep) * (0.3 + 0.7 * number) * smooth(open_, 0.3 * open_, near),
            0.8,
            1.1,
            1.15,
        )


@inner()
def _spots(
    x: float, y: float, z: float, texel: float, person: Traits, worn: float, colour: NDArray[np.float64]
) -> None:
    """Freckles and spots of age, of ragged shapes; moles, and now and then a blemish."""
    seed = person.seed
    ragged = 0.05 * value_noise(9 * x, 9 * y, 9 * z, seed + 161)
    front = smooth(2.0, 5.0, z)
    where = front * (0.25 + bump(x, y, 2.6, -2.0, 3.0, 1.9) + 0.35 * bump(x, y, 2.0, 5.0, 4.0, 2.2))
    if person.freckles * where > 0.02:
        near, number = cells(x, y, z, 0.30, seed + 131)
        if number < person.freckles * where * 0.8:
            radius = 0.12 + 0.22 * number / max(person.freckles, 0.05)
            visible = smooth(0.4 * texel, 1.2 * texel, 0.30 * radius)
            darken(colour, 0.20 * visible * smooth(radius, 0.3 * radius, near + 2 * ragged), 0.65, 1.1, 1.45)
    if worn > 0.3:
        near, number = cells(x, y, z, 1.3, seed + 141)
        if number < 0.30 * (worn - 0.3) * (0.5 + 0.5 * front):
            radius = 0.08 + 0.5 * number
            darken(colour, 0.16 * smooth(radius, 0.6 * radius, near + ragged), 0.7, 1.1, 1.4)
    near, number = cells(x, y, z, 3.0, seed + 151)
    if number < 0.20:
        radius = 0.014 + 0.10 * number
        darken(colour, 0.58 * smooth(radius, 0.55 * radius, near + 0.1 * ragged), 0.85, 1.1, 1.2)
    elif number < 0.34:
        darken(colour, 0.13 * person.blood * smooth(0.042, 0.0, near + 0.2 * ragged), 0.25, 1.3, 1.1)


@inner()
def _lips(x: float, y: float, z: float, texel: float, person: Traits, colour: NDArray[np.float64]) -> None:
    if z < 5:
        return
    seed = person.seed
    # The edge is drawn by furrows that run out into the skin, and the skin around it is pale.
    ragged = 0.05 * value_noise(x * 6, y * 6, z, seed + 171) + 0.02 * value_noise(x * 19, y * 9, z, seed + 172)
    around = smooth(0.55, 0.0, abs(y + 6.1) - 0.75) * smooth(2.9, 2.0, abs(x))
    darken(colour, -0.018 * around, 1.0, 1.2, 1.2)
    amount = lips(x, y + ragged, z)
    if amount <= 0:
        return
    furrow = lip_furrow(x, y, z, texel, seed)
    middle = smooth(0.42, 0.0, abs(y + 6.1))
    mottle = fractal(x, y, z, 0.45, 4, texel, seed + 191)
    shade = (1 - 0.13 * furrow) * (1 + 0.055 * mottle) * (1 - 0.16 * middle)
    pale = 0.72 + 0.16 * middle + 0.08 * mottle
    for c in range(3):
        redder = 1.0 if c == 0 else 1 - 0.05 * mottle - 0.05 * middle
        colour[c] += pale * amount * (person.lip[c] * shade * redder - colour[c])


@inner()
def lip_furrow(x: float, y: float, z: float, texel: float, seed: int) -> float:
    """Furrows of the lips, 0..1: they run up and down, fan out to the corners, and fork."""
    bent = x * (1 + 0.10 * (abs(y + 6.1) - 0.4)) + 0.06 * value_noise(2.2 * x, 2.2 * y, z, seed + 180)
    total = 0.0
    for octave in range(2):
        fine = 4.6 * (1 + 0.9 * octave)
        visible = smooth(1.0 * texel, 2.4 * texel, 0.5 / fine)
        if visible > 0:
            zero = value_noise(fine * bent, 0.75 * y, 0.5 * z, seed + 181 + octave)
            total += visible * (1.0 - 0.35 * octave) * np.exp(-((zero / 0.16) ** 2))
    return min(total, 1.0)


@inner()
def _hollows(x: float, y: float, z: float, colour: NDArray[np.float64]) -> None:
    """Cavities keep their shade in every capture: nostrils, the crease of the lid, the line of the lips."""
    if z < 5:
        return
    darken(colour, 0.72 * smooth(1.25, 0.7, from_nostril(x, y, z)), 0.88, 1.08, 1.08)
    crease = from_lid_crease(x, y)
    darken(colour, 0.15 * np.exp(-((crease / 0.075) ** 2)) * smooth(1.65, 1.0, abs(abs(x) - 3.2)), 0.75, 1.1, 1.1)
    darken(colour, 0.38 * smooth(0.15, 0.0, from_mouth_line(x, y)) * smooth(2.75, 2.2, abs(x)), 0.75, 1.15, 1.1)


@inner()
def darken(colour: NDArray[np.float64], amount: float, r: float, g: float, b: float) -> None:
    """Absorb light: by ``amount``, weighted per channel."""
    colour[0] *= 1 - min(amount * r, 1.0)
    colour[1] *= 1 - min(amount * g, 1.0)
    colour[2] *= 1 - min(amount * b, 1.0)
