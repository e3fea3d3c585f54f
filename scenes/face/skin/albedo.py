"""The albedo of the neutral skin, evaluated at every texel: tone, blood, pores, freckles, lips, brows, eyes, teeth."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facezip.machine.kernels import inner, kernel
from facezip.machine.rows import map_rows
from scenes.face.features import LID_HALF_WIDTH, MOUTH_HALF_WIDTH, Rows
from scenes.face.head import Head
from scenes.face.sculpt import EYE
from scenes.face.skin.noise import cells, fractal, smooth, value_noise
from scenes.face.skin.sampling import TexelGrid, at_texel
from scenes.face.skin.zones import brow, bump, lips, redness, scalp

EYE_X, EYE_Y = float(EYE[0]), float(EYE[1])


@dataclass(frozen=True)
class Complexion:
    """A person's colours, encoded sRGB in [0, 1], and densities in [0, 1]."""

    skin: tuple[float, float, float]
    lip: tuple[float, float, float]
    iris: tuple[float, float, float]
    hair: tuple[float, float, float]
    freckles: float
    beard: float
    seed: int


def complexion(seed: int) -> Complexion:
    """The colours of the person with this seed; seed 0 is the one in the pictures."""
    rng = np.random.default_rng([seed, 7])
    tone = 0.28 if seed == 0 else float(rng.uniform(0.0, 0.9))
    light, dark = np.array([0.885, 0.715, 0.625]), np.array([0.46, 0.31, 0.235])
    skin = light + tone * (dark - light)
    lip = skin * [0.88, 0.66, 0.68]
    irises = np.array([[0.30, 0.42, 0.50], [0.40, 0.30, 0.17], [0.33, 0.40, 0.27], [0.22, 0.14, 0.09]])
    iris = irises[0 if seed == 0 else int(rng.integers(0, 4))]
    hair = np.array([0.20, 0.135, 0.10]) * (1.15 - 0.6 * tone)
    freckles = 0.55 if seed == 0 else float(rng.uniform(0, 1) * (1 - tone))
    beard = 0.35 if seed == 0 else float(rng.uniform(0, 0.8))
    colours = [tuple(float(c) for c in colour) for colour in (skin, lip, iris, hair)]
    return Complexion(colours[0], colours[1], colours[2], colours[3], freckles, beard, seed)  # type: ignore[arg-type]


def neutral_albedo(head: Head, resolution: int, person: Complexion) -> NDArray[np.float32]:
    """``(R, R, 3)`` float32 in [0, 1], encoded sRGB; nothing is upscaled."""
    texels = TexelGrid.of(head, resolution)
    colours = np.array([person.skin, person.lip, person.iris, person.hair])
    out = np.empty((resolution, resolution, 3), np.float32)

    def paint(top: int, bottom: int) -> None:
        _paint(top, bottom, texels, head.rows, colours, person.freckles, person.beard, person.seed, out)

    map_rows(paint, resolution)
    return out


@kernel()
def _paint(
    top: int,
    bottom: int,
    texels: TexelGrid,
    rows: Rows,
    colours: NDArray[np.float64],
    freckles: float,
    beard: float,
    seed: int,
    out: NDArray[np.float32],
) -> None:
    p = np.empty(3)
    colour = np.empty(3)
    for j in range(top, bottom):
        for i in range(len(texels.column_of)):
            at_texel(texels.grid, texels.row_of[j], texels.column_of[i], p)
            x, y, z = p
            _skin(x, y, z, texels.texel, colours, freckles, beard, seed, colour)
            if z > 4:
                row = texels.row_of[j]
                if rows.lower_lid - 1.2 < row < rows.upper_lid + 1.2 and abs(abs(x) - EYE_X) < LID_HALF_WIDTH:
                    _eye(x, y, z, row, rows.lower_lid, rows.upper_lid, texels.texel, colours, seed, colour)
                if rows.lower_lip < row < rows.upper_lip and abs(x) < MOUTH_HALF_WIDTH * 0.995:
                    _mouth(x, y, z, row - rows.lower_lip, colours, seed, colour)
            for c in range(3):
                out[j, i, c] = min(max(colour[c], 0.0), 1.0)


@inner()
def _skin(
    x: float,
    y: float,
    z: float,
    texel: float,
    colours: NDArray[np.float64],
    freckles: float,
    beard: float,
    seed: int,
    colour: NDArray[np.float64],
) -> None:
    red = redness(x, y, z)
    blotch = fractal(x, y, z, 2.6, 4, texel, seed + 11)
    tone = fractal(x, y, z, 5.0, 3, texel, seed + 31)
    fine = fractal(x, y, z, 0.34, 3, texel, seed + 51)
    blood = red * (1 + 0.35 * blotch) + 0.10 * blotch
    light = 1 + 0.022 * tone + 0.022 * fine
    colour[0] = colours[0, 0] * light * (1 - 0.055 * blood)
    colour[1] = colours[0, 1] * light * (1 - 0.215 * blood)
    colour[2] = colours[0, 2] * light * (1 - 0.200 * blood) * (1 - 0.02 * tone)
    # Pores: denser and larger on nose and cheeks.
    size = 0.105 + 0.03 * bump(x, y, 1.8, -2.6, 2.2, 1.6)
    visible = smooth(0.9 * texel, 2.2 * texel, size)
    if visible > 0:
        near, number = cells(x, y, z, size, seed + 71)
        depth = (0.06 + 0.09 * bump(x, y, 1.2, -2.6, 2.2, 1.8)) * (0.4 + 0.6 * number)
        _darken(colour, visible * depth * smooth(0.42, 0.08, near), 0.9, 1.05, 1.1)
    _spots(x, y, z, texel, freckles, seed, colour)
    # Shadow of a beard, and the shaved scalp with its stubble.
    jaw = beard * smooth(0.5, 3.0, z) * max(bump(x, y, 0.0, -9.0, 4.6, 2.6), bump(x, y, 1.2, -5.0, 1.5, 0.55))
    hairy = scalp(x, y + 0.25 * fractal(x, y, z, 1.1, 3, texel, seed + 91), z)
    _darken(colour, 0.16 * jaw, 1.1, 1.0, 0.85)
    _darken(colour, 0.25 * hairy, 1.15, 1.0, 0.85)
    stubble = smooth(0.8 * texel, 2.0 * texel, 0.055)
    if stubble > 0 and max(jaw, hairy) > 0.02:
        near, number = cells(x, y, z, 0.055, seed + 101)
        _darken(
            colour,
            stubble * (0.45 * hairy + 0.38 * jaw) * smooth(0.5, 0.2, near) * smooth(0.1, 0.6, number),
            1.0,
            1.0,
            1.0,
        )
    _lips(x, y, z, texel, colours, seed, colour)
    _brow(x, y, z, texel, colours, seed, colour)
    # Cavities keep their shade in every capture: nostrils, the crease of the lid, the line of the lips.
    if z > 5:
        nostril = np.sqrt(((abs(x) - 0.70) / 0.46) ** 2 + ((y + 3.86) / 0.36) ** 2)
        _darken(colour, 0.78 * smooth(1.15, 0.55, nostril) * smooth(10.2, 9.7, z), 0.92, 1.05, 1.05)
        crease = abs(y - (1.42 - 0.10 * (abs(x) - 3.1) ** 2))
        _darken(colour, 0.16 * smooth(0.22, 0.0, crease) * smooth(1.6, 1.1, abs(abs(x) - 3.2)), 0.7, 1.1, 1.1)
        line = abs(y + 6.09) + 0.25 * max(abs(x) - 2.3, 0.0)
        _darken(colour, 0.42 * smooth(0.13, 0.0, line) * smooth(2.75, 2.3, abs(x)), 0.8, 1.15, 1.1)


@inner()
def _spots(x: float, y: float, z: float, texel: float, freckles: float, seed: int, colour: NDArray[np.float64]) -> None:
    where = smooth(2.0, 5.0, z) * (0.25 + bump(x, y, 2.6, -2.0, 3.0, 1.9) + 0.35 * bump(x, y, 2.0, 5.0, 4.0, 2.2))
    near, number = cells(x, y, z, 0.42, seed + 131)
    if number < freckles * where * 0.75:
        radius = 0.10 + 0.16 * number / max(freckles, 0.05)
        visible = smooth(0.4 * texel, 1.2 * texel, 0.42 * radius)
        _darken(colour, 0.26 * visible * smooth(radius, 0.45 * radius, near), 0.75, 1.1, 1.45)
    near, number = cells(x, y, z, 3.4, seed + 151)
    if number < 0.16:
        _darken(colour, 0.60 * smooth(0.034, 0.022, near), 0.85, 1.1, 1.2)


@inner()
def _lips(
    x: float, y: float, z: float, texel: float, colours: NDArray[np.float64], seed: int, colour: NDArray[np.float64]
) -> None:
    amount = lips(x, y + 0.035 * value_noise(x * 5, y * 5, z, seed + 171), z)
    if amount <= 0:
        return
    crease = fractal(7.5 * x, 1.1 * y, 0.8 * z, 1.0, 3, 7.5 * texel, seed + 181)
    shade = 1 + 0.055 * crease + 0.03 * fractal(x, y, z, 0.5, 2, texel, seed + 191)
    for c in range(3):
        colour[c] += 0.86 * amount * (colours[1, c] * shade - colour[c])


@inner()
def _brow(
    x: float, y: float, z: float, texel: float, colours: NDArray[np.float64], seed: int, colour: NDArray[np.float64]
) -> None:
    if z < 3:
        return
    density, angle = brow(x, y)
    if density <= 0:
        return
    along = abs(x) * np.cos(angle) + y * np.sin(angle)
    across = -abs(x) * np.sin(angle) + y * np.cos(angle)
    side = 1 if x > 0 else 0
    hair = value_noise(
        across * 17.0 + 0.6 * value_noise(along * 2, across * 3, 0.5, seed), along * 1.7, 3.0 * side, seed + 201
    )
    hair += 0.6 * value_noise(across * 29.0, along * 2.4, 5.0 + 3.0 * side, seed + 211)
    visible = smooth(1.0 * texel, 2.4 * texel, 0.06)
    strand = visible * smooth(-0.15, 0.55, hair) + (1 - visible) * 0.5
    amount = density * (0.42 + 0.52 * strand)
    for c in range(3):
        colour[c] += amount * (colours[3, c] - colour[c])


@inner()
def _eye(
    x: float,
    y: float,
    z: float,
    row: float,
    lower: int,
    upper: int,
    texel: float,
    colours: NDArray[np.float64],
    seed: int,
    colour: NDArray[np.float64],
) -> None:
    dx, dy = abs(x) - EYE_X + 0.03, y - EYE_Y - 0.02
    r = np.sqrt(dx * dx + dy * dy)
    # The edge of the lids: lashes above, wet pink below.
    inside = smooth(lower + 0.15, lower + 0.55, row) * smooth(upper - 0.15, upper - 0.55, row)
    veins = max(0.0, fractal(x, y, z, 0.5, 3, texel, seed + 221))
    corner = smooth(0.75, 1.5, abs(dx))
    white = np.array([0.86 - 0.02 * veins, 0.815 - 0.16 * corner - 0.10 * veins, 0.785 - 0.18 * corner - 0.10 * veins])
    angle = np.arctan2(dy, dx)
    fibre = 0.30 * value_noise(7 * np.cos(angle) + 7, 7 * np.sin(angle), 3.5 * r, seed + 231)
    fibre += 0.20 * value_noise(15 * np.cos(angle) + 7, 15 * np.sin(angle), 5 * r, seed + 241)
    ring = (0.80 + fibre + 0.35 * smooth(0.36, 0.22, r)) * smooth(0.66, 0.50, r) + 0.18
    soft = max(texel, 0.03)
    iris, pupil = smooth(0.60 + soft, 0.60 - soft, r), smooth(0.22 + soft, 0.22 - soft, r)
    shade = 1 - 0.30 * smooth(0.22, 0.62, dy)
    for c in range(3):
        value = white[c] + iris * (colours[2, c] * ring - white[c])
        value = shade * (value + pupil * (0.03 - value))
        colour[c] += inside * (value - colour[c])
    lash = 0.85 * smooth(0.75, 0.15, abs(row - upper)) * smooth(1.55, 1.2, abs(dx))
    lash = max(lash, 0.42 * smooth(0.6, 0.1, abs(row - lower)) * smooth(1.5, 0.9, abs(dx - 0.2)))
    for c in range(3):
        colour[c] += lash * (0.6 * colours[3, c] - colour[c])


@inner()
def _mouth(
    x: float, y: float, z: float, row: float, colours: NDArray[np.float64], seed: int, colour: NDArray[np.float64]
) -> None:
    """The pocket behind the lips, by its rows: inner lip, gum, teeth, dark, and the same upwards."""
    step = min(row, 12 - row)
    wet = np.array([0.50, 0.22, 0.21])
    gum = np.array([0.62, 0.33, 0.33])
    tooth = np.array([0.87, 0.83, 0.74]) * (0.93 + 0.05 * value_noise(3 * x, y, z, seed + 251))
    dark = np.array([0.09, 0.03, 0.03])
    gap = (
        abs(abs(x) / 0.78 - np.floor(abs(x) / 0.78 + 0.5))
        if row > 6
        else abs(abs(x) / 0.52 - np.floor(abs(x) / 0.52 + 0.5))
    )
    teeth = smooth(3.2, 3.5, step) * smooth(5.15, 4.95, step)
    deep = smooth(5.0, 5.25, step)
    lip = smooth(1.8, 0.2, step)
    for c in range(3):
        value = wet[c] + smooth(2.3, 3.0, step) * (gum[c] - wet[c])
        value += teeth * ((tooth[c] * (1 - 0.45 * smooth(0.07, 0.0, gap))) - value)
        value += deep * (dark[c] - value)
        colour[c] += (1 - lip * 0.9) * (value - colour[c])


@inner()
def _darken(colour: NDArray[np.float64], amount: float, r: float, g: float, b: float) -> None:
    """Absorb light: by ``amount``, weighted per channel."""
    colour[0] *= 1 - min(amount * r, 1.0)
    colour[1] *= 1 - min(amount * g, 1.0)
    colour[2] *= 1 - min(amount * b, 1.0)
