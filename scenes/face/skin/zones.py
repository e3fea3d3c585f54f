"""Where on the face is what: soft zones over positions on the neutral head (cm, left side folded over)."""

import numpy as np

from facezip.machine.kernels import inner, kernel
from scenes.face.skin.noise import smooth


@kernel()
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


@kernel()
def from_nostril(x: float, y: float, z: float) -> float:
    """How far into a nostril a point lies: 0 in its middle, 1 about where its wall begins."""
    return np.sqrt(((abs(x) - 0.64) / 0.34) ** 2 + ((y + 3.66) / 0.30) ** 2 + ((z - 9.35) / 0.48) ** 2)


@inner()
def from_mouth_line(x: float, y: float) -> float:
    """How far a point of the front is from the line where the lips meet, about cm."""
    return abs(y + 6.09) + 0.25 * max(abs(x) - 2.3, 0.0)


@inner()
def from_lid_crease(x: float, y: float) -> float:
    """How far above the crease of the upper lid a point of the front is, cm."""
    return y - (1.42 - 0.10 * (abs(x) - 3.1) ** 2)


@kernel()
def ear(x: float, y: float, z: float) -> float:
    """The ears, 0..1."""
    away = np.sqrt(((y - 0.05) / 3.5) ** 2 + ((z + 2.9) / 2.3) ** 2)
    return smooth(1.08, 0.92, away) * smooth(6.7, 7.2, abs(x))


@kernel()
def scalp(x: float, y: float, z: float, female: float) -> float:
    """The shaved scalp: above the hairline, before and behind the ears down to the nape.

    A man's hairline recedes above the temples.
    """
    front = 7.5 - 0.035 * x * x + (1 - female) * 0.75 * np.exp(-(((abs(x) - 3.9) / 1.3) ** 2))
    if z > 5.0:
        line = front
    elif z > 1.2:
        # Round the corner of the forehead, and bowed down to the sideburn.
        t = (5.0 - z) / 3.8
        line = front + (t + 0.12 * np.sin(2 * np.pi * t)) * (0.8 - front)
    elif z > -4.0:
        line = 0.8 - (1.2 - z) / 5.2 * 4.6
    else:
        line = -3.8 - 0.25 * (-4.0 - z)
    return smooth(-0.75, 1.15, y - line) * (1 - ear(x, y, z))


@kernel()
def beard(x: float, y: float, z: float) -> float:
    """Where a man's beard grows: moustache, chin, jaw up to the ears, and the throat."""
    a = abs(x)
    moustache = bump(x, y, 1.0, -4.95, 1.35, 0.48) * smooth(0.05, 0.55, a + 0.25)
    chin = bump(x, y, 0.0, -8.9, 2.3, 1.3) + 0.8 * bump(x, y, 0.0, -7.5, 0.45, 0.4)
    corner = 0.55 * bump(x, y, 3.1, -6.6, 0.7, 1.3)
    line = -5.6 + 0.95 * max(a - 3.2, 0.0)
    jaw = 0.85 * smooth(1.0, -1.6, y - line) * smooth(2.6, 4.6, a) * smooth(-0.8, 2.6, z + 0.25 * max(y + 4, 0.0))
    throat = 0.5 * smooth(-8.6, -10.2, y) * smooth(0.0, 3.0, z + 0.4 * (y + 14))
    whole = min(moustache + chin + corner + jaw + throat, 1.0) * smooth(-13.8, -9.6, y)
    return whole * (1 - lips(x, y, z)) * smooth(-1.0, 1.0, z)


@kernel()
def brow(x: float, y: float, thick: float, female: float) -> tuple[float, float, float]:
    """How dense the hair of the brow is, the angle (radians) of its hairs to the horizontal, and their length (cm)."""
    a = abs(x)
    t = (a - 1.15) / 4.2
    if t < -0.10 or t > 1.06:
        return 0.0, 0.0, 0.0
    inside = min(max(t, 0.0), 1.0)
    middle = 2.10 + (1.25 + 0.25 * female) * inside - 1.25 * inside**3 - (0.20 + 0.15 * female) * inside * inside
    half = 0.43 * thick * (1 - 0.72 * inside**1.5)
    over = (y - middle) / half
    ends = smooth(-0.10, 0.14, t) * smooth(1.05, 0.72, t)
    # Sparse below and at its head, dense along its spine; hairs rise at the head, and meet from both sides further on.
    density = smooth(1.25, 0.25, abs(over)) * ends * (0.55 + 0.45 * smooth(0.0, 0.3, t))
    angle = 1.25 - 1.15 * inside**0.55 - 0.40 * over * smooth(0.15, 0.5, t)
    return density, angle, 0.30 + 0.34 * smooth(0.0, 0.35, t) * smooth(1.1, 0.6, t)


@inner()
def redness(x: float, y: float, z: float) -> float:
    """Blood near the surface: cheeks, nose, lids, ears, chin; the forehead and the neck have less."""
    front = smooth(1.0, 5.0, z)
    cheeks = 0.55 * bump(x, y, 4.0, -2.7, 1.9, 1.7) + 0.20 * bump(x, y, 3.0, -4.2, 1.8, 1.6)
    nose = 0.75 * bump(x, y, 0.0, -2.9, 1.3, 1.1) + 0.45 * bump(x, y, 1.4, -3.4, 0.7, 0.7)
    around = 0.42 * bump(x, y, 3.1, 0.4, 1.8, 1.1) + 0.30 * bump(x, y, 0.0, -9.3, 1.6, 1.1)
    return front * (cheeks + nose + around) + 0.7 * ear(x, y, z)


@inner()
def pore_size(x: float, y: float, z: float) -> tuple[float, float]:
    """How far apart pores lie (cm), and how deep and open they are, 0..1: most so on the nose and beside it."""
    if z < 2:
        return 0.095, 0.15
    nose = bump(x, y, 0.0, -2.4, 1.5, 1.5)
    cheek = bump(x, y, 2.3, -2.4, 1.7, 1.5)
    forehead, chin = bump(x, y, 0.0, 4.8, 3.2, 1.8), bump(x, y, 0.0, -8.8, 1.8, 1.2)
    deep = 0.15 + 0.85 * nose + 0.65 * cheek + 0.30 * forehead + 0.35 * chin
    return 0.082 + 0.024 * min(nose + cheek + 0.4 * chin, 1.0), min(deep, 1.0)
