"""The eye on its sheet: white with veins, limbal ring, fibres of the iris, pupil, and the wet margins of the lids."""

import numpy as np
from numpy.typing import NDArray

from facezip.machine.kernels import inner
from scenes.face.features import Rows
from scenes.face.sculpt import EYE
from scenes.face.skin.noise import fractal, smooth, value_noise
from scenes.face.traits import Traits

EYE_X, EYE_Y = float(EYE[0]), float(EYE[1])
# Radii in cm.
IRIS, COLLARETTE, PUPIL = 0.60, 0.30, 0.19


@inner()
def from_pupil(x: float, y: float) -> tuple[float, float]:
    """Where a point of the eye is from the middle of its pupil, cm: towards the temple, and up."""
    return abs(x) - EYE_X + 0.03, y - EYE_Y - 0.05


@inner()
def paint_eye(
    x: float,
    y: float,
    z: float,
    row: float,
    rows: Rows,
    texel: float,
    person: Traits,
    colour: NDArray[np.float64],
) -> None:
    """Paint over a colour what lies between the lids."""
    dx, dy = from_pupil(x, y)
    r = np.sqrt(dx * dx + dy * dy)
    up = (row - rows.lower_lid) / (rows.upper_lid - rows.lower_lid)
    inside = smooth(rows.lower_lid - 0.05, rows.lower_lid + 0.35, row)
    inside *= smooth(rows.upper_lid + 0.1, rows.upper_lid - 0.3, row)
    # The margin of the lids is wet and pink, and flesh fills the corner at the nose.
    margin = smooth(0.9, 0.2, abs(row - rows.lower_lid + 0.1))
    flesh = max(0.55 * margin, smooth(1.02, 1.28, -dx - 0.12 * dy))
    # The lids shade the ball: most below the upper one, and in the corners.
    shade = 1 - 0.50 * smooth(0.52, 1.02, up) - 0.20 * smooth(0.16, -0.02, up)
    shade *= 1 - 0.16 * smooth(0.75, 1.5, abs(dx))
    iris = smooth(IRIS + 0.035, IRIS - 0.035, r)
    white, ball = _white(x, y, z, dx, dy, texel, person), _iris(dx, dy, r, texel, person)
    for c in range(3):
        value = (white[c] + iris * (ball[c] - white[c])) * shade
        pink = 0.62 * person.lip[c] + (0.30 if c == 0 else 0.22)
        value += flesh * (0.88 * pink * shade - value)
        colour[c] += inside * (value - colour[c])


@inner()
def _white(
    x: float, y: float, z: float, dx: float, dy: float, texel: float, person: Traits
) -> tuple[float, float, float]:
    """Ivory rather than white, pink to the corners, with veins that wind towards the iris."""
    corner = smooth(0.55, 1.45, abs(dx))
    bent = dy + 0.10 * value_noise(2.6 * x, 2.6 * y, z, person.seed + 221)
    zero = value_noise(1.3 * dx + 3.0, 6.0 * bent, 0.5, person.seed + 223)
    zero_fine = value_noise(2.9 * dx + 3.0, 12.0 * bent, 0.5, person.seed + 225)
    veins = np.exp(-((zero / 0.10) ** 2)) + 0.6 * np.exp(-((zero_fine / 0.12) ** 2))
    veins *= (
        smooth(0.5, 2.0, 0.06 / texel)
        * (0.22 + 0.78 * corner)
        * (0.6 + 0.4 * fractal(x, y, z, 0.5, 2, texel, person.seed))
    )
    dull = 1 - 0.05 * person.melanin
    return (
        (0.790 - 0.05 * veins - 0.02 * corner) * dull,
        (0.745 - 0.17 * veins - 0.12 * corner) * dull,
        (0.715 - 0.17 * veins - 0.13 * corner) * dull * (1 - 0.06 * person.melanin),
    )


@inner()
def _iris(dx: float, dy: float, r: float, texel: float, person: Traits) -> tuple[float, float, float]:
    """Fibres that run from the pupil, lighter around it; the cornea gathers the light from above on the lower half."""
    seed, angle = person.seed, np.arctan2(dy, dx)
    c, s = np.cos(angle), np.sin(angle)
    # The radius of the collarette wavers, fibres bend around gaps.
    ruff = COLLARETTE + 0.025 * value_noise(3 * c + 7, 3 * s, 0.0, seed + 229)
    bent = 0.5 * value_noise(2 * c + 7, 2 * s, 4 * r, seed + 230)
    fibre = 0.0
    for octave in range(3):
        turns = 5.0 * (1 + octave) ** 1.3
        visible = smooth(0.8, 2.2, 0.35 / turns / texel)
        fibre += (
            visible
            * (0.5 - 0.1 * octave)
            * value_noise(turns * c + 9 + bent, turns * s + bent, 2.4 * r, seed + 231 + octave)
        )
    soft = max(0.6 * texel, 0.02)
    inner = smooth(ruff + 0.05, ruff - 0.03, r)
    ring = smooth(IRIS - 0.17, IRIS - 0.01, r)
    gathered = 1 + 0.34 * smooth(0.25, -0.55, dy) - 0.16 * smooth(-0.1, 0.5, dy)
    light = (0.82 + 0.55 * fibre + 0.18 * inner) * (1 - 0.68 * ring) * gathered
    pupil = smooth(PUPIL + soft, PUPIL - soft, r)
    light *= 1 - 0.35 * smooth(PUPIL + 0.08, PUPIL, r)
    warm = 0.45 * inner * min(1.0, person.iris[0] / 0.30)
    values = (
        light * (person.iris[0] + warm * (0.42 - person.iris[0])),
        light * (person.iris[1] + warm * (0.31 - person.iris[1])),
        light * (person.iris[2] + warm * (0.18 - person.iris[2])),
    )
    return (
        values[0] + pupil * (0.025 - values[0]),
        values[1] + pupil * (0.022 - values[1]),
        values[2] + pupil * (0.022 - values[2]),
    )


@inner()
def eye_height(x: float, y: float) -> float:
    """In cm: a ball is rounder than the mesh of the eye, which bulges from lid to lid; the cornea stands out of it."""
    dx, dy = from_pupil(x, y)
    r_2 = dx * dx + dy * dy
    return 0.10 * np.exp(-r_2 / 0.5**2) - 0.16 * dx * dx
