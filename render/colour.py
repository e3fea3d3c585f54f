"""CIEDE2000 of displayed colours: one pass over pixels, with CIELAB taken once an image."""

import math

import numpy as np
from numpy.typing import NDArray

from facezip.machine.kernels import inner, kernel

Colours = NDArray[np.float64]

# Linear sRGB to XYZ as IEC 61966-2-1 prints it, and the white of D65 (0.3127, 0.3290).
_XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
_WHITE = np.array([0.3127 / 0.3290, 1.0, (1 - 0.3127 - 0.3290) / 0.3290])


def to_lab(encoded: NDArray[np.float32]) -> Colours:
    """CIELAB ``(n, 3)`` under D65 of encoded sRGB colours ``(n, 3)`` in [0, 1]."""
    return _to_lab(np.ascontiguousarray(encoded, np.float32), (_XYZ / _WHITE[:, None]).astype(np.float32))


@kernel()
def _to_lab(encoded: NDArray[np.float32], matrix: NDArray[np.float32]) -> Colours:
    out = np.empty(encoded.shape)
    for i in range(len(encoded)):
        red, green, blue = linear(encoded[i, 0]), linear(encoded[i, 1]), linear(encoded[i, 2])
        f_x = lab_curve(matrix[0, 0] * red + matrix[0, 1] * green + matrix[0, 2] * blue)
        f_y = lab_curve(matrix[1, 0] * red + matrix[1, 1] * green + matrix[1, 2] * blue)
        f_z = lab_curve(matrix[2, 0] * red + matrix[2, 1] * green + matrix[2, 2] * blue)
        out[i, 0] = np.float32(116) * f_y - np.float32(16)
        out[i, 1] = np.float32(500) * (f_x - f_y)
        out[i, 2] = np.float32(200) * (f_y - f_z)
    return out


@inner()
def linear(encoded: np.float32) -> np.float32:
    """The inverse of the sRGB transfer function on one value."""
    if encoded <= np.float32(0.04045):
        return encoded / np.float32(12.92)
    return ((encoded + np.float32(0.055)) / np.float32(1.055)) ** np.float32(2.4)


@inner()
def lab_curve(t: np.float32) -> np.float32:
    """What CIELAB makes of a tristimulus value relative to white."""
    if t > np.float32((6 / 29) ** 3):
        return np.cbrt(t)
    return t * np.float32(841 / 108) + np.float32(4 / 29)


@kernel()
def delta_e_2000(a: Colours, b: Colours) -> Colours:
    """CIEDE2000 ``(n,)`` of CIELAB colours ``(n, 3)``, numbered as in Sharma, Wu and Dalal (2005)."""
    out = np.empty(len(a))
    for i in range(len(a)):
        chroma = (math.hypot(a[i, 1], a[i, 2]) + math.hypot(b[i, 1], b[i, 2])) / 2
        stretch = 1.5 - 0.5 * math.sqrt(_seventh(chroma))  # 1 + G, (4)
        red_a, red_b = stretch * a[i, 1], stretch * b[i, 1]  # (5)
        chroma_a, chroma_b = math.hypot(red_a, a[i, 2]), math.hypot(red_b, b[i, 2])  # (6)
        hue_a, hue_b = _hue(a[i, 2], red_a), _hue(b[i, 2], red_b)  # (7)
        turn, hue = _hues(hue_a, hue_b, chroma_a * chroma_b == 0)  # (10), (14)
        lightness = (a[i, 0] + b[i, 0]) / 2 - 50
        chroma = (chroma_a + chroma_b) / 2
        tint = 1 - 0.17 * math.cos(hue - math.radians(30)) + 0.24 * math.cos(2 * hue)  # (15)
        tint += 0.32 * math.cos(3 * hue + math.radians(6)) - 0.20 * math.cos(4 * hue - math.radians(63))
        around = math.radians(30) * math.exp(-(((math.degrees(hue) - 275) / 25) ** 2))  # (16)
        dl = (b[i, 0] - a[i, 0]) / (1 + 0.015 * lightness**2 / math.sqrt(20 + lightness**2))  # (8), (18)
        dc = (chroma_b - chroma_a) / (1 + 0.045 * chroma)  # (9), (19)
        dh = 2 * math.sqrt(chroma_a * chroma_b) * math.sin(turn / 2) / (1 + 0.015 * chroma * tint)  # (11), (20)
        rotation = -2 * math.sqrt(_seventh(chroma)) * math.sin(2 * around)  # (17), (21)
        out[i] = math.sqrt(max(dl * dl + dc * dc + dh * dh + rotation * dc * dh, 0.0))  # (22)
    return out


@inner()
def _seventh(chroma: float) -> float:
    power = chroma * chroma * chroma
    power = power * power * chroma
    return power / (power + 6103515625.0)  # 25⁷


@inner()
def _hue(b: float, a: float) -> float:
    if a == 0 and b == 0:
        return 0.0
    angle = math.atan2(b, a)
    return angle + 2 * math.pi if angle < 0 else angle


@inner()
def _hues(a: float, b: float, grey: bool) -> tuple[float, float]:
    """The turn from one hue to the other and the hue between them; a grey has no hue."""
    if grey:
        return 0.0, a + b
    turn = b - a
    # Opposite hues, a half turn but for rounding, are in the first case on every machine.
    if abs(turn) <= math.pi + 1e-9:
        return turn, (a + b) / 2
    turn += -2 * math.pi if turn > 0 else 2 * math.pi
    return turn, (a + b) / 2 + (math.pi if a + b < 2 * math.pi else -math.pi)
