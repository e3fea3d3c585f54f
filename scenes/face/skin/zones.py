"""Where on the face is what: soft zones over positions on the neutral head (cm, left side folded over)."""

import numpy as np

from facezip.machine.kernels import inner, kernel
from scenes.face.skin.noise import smooth


@inner()
def bump(x: float, y: float, cx: float, cy: float, rx: float, ry: float) -> float:
    """One at a centre, falling off as a Gaussian; x is folded to the left side."""
    return np.exp(-(((abs(x) - cx) / rx) ** 2) - ((y - cy) / ry) ** 2)


@kernel()
def lips(x: float, y: float, z: float) -> float:
    """Vermilion of both lips, with the bow of Cupid."""
    if z < 5:
        return 0.0
    s = min(abs(x) / 2.5, 1.2)
    arch = max(1 - s * s, 0.0)
    top = -6.08 + 0.62 * arch**0.75 - 0.13 * np.exp(-((x / 0.28) ** 2)) + 0.05 * np.exp(-(((abs(x) - 0.5) / 0.3) ** 2))
    bottom = -6.12 - 0.86 * arch**0.62
    return smooth(0.10, -0.10, y - top) * smooth(-0.12, 0.12, y - bottom) * smooth(1.03, 0.93, s)


@inner()
def scalp(x: float, y: float, z: float) -> float:
    """The shaved scalp: above the hairline, before and behind the ears down to the nape."""
    front = 7.5 - 0.035 * x * x
    if z > 5.0:
        line = front
    elif z > 1.5:
        line = front + (5.0 - z) / 3.5 * (1.2 - front)
    elif z > -4.0:
        line = 1.2 - (1.5 - z) / 5.5 * 5.0
    else:
        line = -3.8 - 0.25 * (-4.0 - z)
    ear = smooth(7.0, 7.4, abs(x)) * smooth(-5.0, -4.0, y) * smooth(3.8, 3.2, y)
    return smooth(-0.7, 0.9, y - line) * (1 - ear)


@inner()
def brow(x: float, y: float) -> tuple[float, float]:
    """How dense the hair of the brow is, and its direction: the angle (radians) of hairs to the horizontal."""
    a = abs(x)
    t = (a - 1.25) / 4.1
    if t < -0.08 or t > 1.05:
        return 0.0, 0.0
    t = min(max(t, 0.0), 1.0)
    middle = 2.12 + 1.35 * t - 1.25 * t * t * t - 0.25 * t * t
    half = 0.46 * (1 - 0.70 * t**1.6)
    edge = abs(y - middle) / half
    ends = smooth(-0.06, 0.10, (a - 1.25) / 4.1) * smooth(1.04, 0.80, (a - 1.25) / 4.1)
    return smooth(1.25, 0.45, edge) * ends, 1.25 - 1.15 * t**0.6


@inner()
def redness(x: float, y: float, z: float) -> float:
    """Blood near the surface: cheeks, nose, lids, ears, chin; the forehead and the neck have less."""
    front = smooth(1.0, 5.0, z)
    cheeks = 0.55 * bump(x, y, 4.0, -2.7, 1.9, 1.7) + 0.20 * bump(x, y, 3.0, -4.2, 1.8, 1.6)
    nose = 0.75 * bump(x, y, 0.0, -2.9, 1.3, 1.1) + 0.45 * bump(x, y, 1.4, -3.4, 0.7, 0.7)
    around = 0.42 * bump(x, y, 3.1, 0.4, 1.8, 1.1) + 0.30 * bump(x, y, 0.0, -9.3, 1.6, 1.1)
    ear = 0.6 * smooth(6.6, 7.6, abs(x)) * smooth(-4.0, -3.0, y) * smooth(4.0, 3.0, y) * smooth(2.0, 0.5, z)
    return front * (cheeks + nose + around) + ear


@inner()
def propensity(x: float, y: float, z: float) -> tuple[float, float]:
    """How deep skin wrinkles here, 0..1, and how far apart (cm) its wrinkles lie: thick skin folds in long waves."""
    if z < 0.5:
        return 0.0, 0.6
    forehead = smooth(2.6, 3.8, y) * smooth(8.0, 6.6, y) * smooth(6.5, 4.5, abs(x))
    glabella = bump(x, y, 0.0, 2.4, 1.3, 1.3)
    eyes = bump(x, y, 5.1, 0.4, 1.1, 1.3) + 0.7 * bump(x, y, 3.2, -0.9, 1.7, 0.7)
    nose = 0.9 * bump(x, y, 0.6, 0.2, 1.0, 1.5)
    fold = 0.75 * bump(x, y, 2.7, -4.2, 0.7, 1.5) + 0.25 * bump(x, y, 4.2, -4.2, 1.0, 2.0)
    mouth = 0.8 * bump(x, y, 0.9, -6.1, 1.9, 1.1)
    chin = 0.9 * bump(x, y, 0.0, -8.9, 1.6, 1.1)
    strength = 0.15 + forehead + glabella + eyes + nose + fold + mouth + chin
    spacing = 0.40 + 0.55 * forehead + 0.30 * glabella + 0.75 * fold - 0.12 * eyes - 0.08 * mouth
    return min(strength, 1.0), min(max(spacing, 0.26), 1.0)
