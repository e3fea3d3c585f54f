"""Where things are on the head: landmarks and curves in centimetres, shared by geometry and skin.

Frame: y up, the face looks to +z, +x is the character's left; the origin is at the head's centre between the ears.
Everything here is the left half (x >= 0) and the midline of the symmetric head; :mod:`scenes.head.head` adds the
natural asymmetry. Proportions are those of an average adult (Farkas, *Anthropometry of the Head and Face*).
"""

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]

EYE_CENTRE = np.array([3.15, 0.40, 7.72])
EYE_RADIUS = 1.22
# The iris faces straight ahead; its radius on the eyeball.
IRIS_RADIUS = 0.59
PUPIL_RADIUS = 0.19
LID_THICKNESS = 0.13
# Axis through the two mandibular condyles, about which the jaw turns: y, z.
JAW_AXIS = np.array([-0.9, 0.6])
MOUTH_HALF_WIDTH = 2.5
BASE_HEIGHT = -17.4

LANDMARKS: dict[str, tuple[float, float, float]] = {
    "crown": (0.0, 11.8, -0.8),
    "trichion": (0.0, 7.4, 8.6),
    "glabella": (0.0, 2.3, 9.9),
    "nasion": (0.0, 0.95, 9.45),
    "nose_tip": (0.0, -3.45, 12.1),
    "subnasale": (0.0, -4.45, 10.3),
    "ala": (1.62, -3.75, 10.0),
    "nostril": (0.62, -4.2, 10.9),
    "labiale_superius": (0.0, -5.85, 10.6),
    "stomion": (0.0, -6.6, 10.2),
    "labiale_inferius": (0.0, -7.5, 10.3),
    "mentolabial": (0.0, -8.45, 9.5),
    "pogonion": (0.0, -9.8, 9.85),
    "menton": (0.0, -11.1, 8.8),
    "cheilion": (2.5, -6.7, 8.9),
    "inner_canthus": (1.68, 0.28, 8.2),
    "outer_canthus": (4.62, 0.48, 7.75),
    "pupil": (3.15, 0.40, 9.0),
    "brow_inner": (1.25, 2.05, 9.6),
    "brow_peak": (4.1, 2.9, 8.7),
    "brow_outer": (5.5, 2.3, 7.4),
    "cheekbone": (5.3, -1.9, 7.0),
    "zygion": (6.7, -1.0, 3.6),
    "gonion": (5.3, -7.4, 1.6),
    "tragion": (7.2, -0.9, 0.0),
    "ear_top": (8.1, 2.3, -1.4),
    "ear_lobe": (7.2, -3.9, -0.2),
}


def landmark(name: str) -> Points:
    """``(3,)`` of a landmark on the left side or the midline."""
    return np.array(LANDMARKS[name])


def _interpolated(knots: list[tuple[float, float]], x: NDArray[np.float64]) -> NDArray[np.float64]:
    from scipy.interpolate import PchipInterpolator

    abscissae, values = np.array(knots).T
    result: NDArray[np.float64] = PchipInterpolator(abscissae, values)(np.clip(x, abscissae[0], abscissae[-1]))
    return result


UPPER_LID = [(1.68, 0.26), (1.9, 0.47), (2.4, 0.77), (2.95, 0.90), (3.5, 0.88), (4.0, 0.77), (4.4, 0.60), (4.62, 0.46)]
LOWER_LID = [(1.68, 0.22), (1.95, 0.08), (2.4, -0.07), (3.0, -0.17), (3.5, -0.17), (4.0, -0.05), (4.4, 0.20), (4.62, 0.42)]
MOUTH_LINE = [(0.0, -6.64), (0.5, -6.60), (1.2, -6.58), (1.9, -6.63), (2.5, -6.70), (3.2, -6.75)]
UPPER_LIP = [(0.0, -5.92), (0.48, -5.74), (1.0, -5.87), (1.6, -6.13), (2.1, -6.42), (2.5, -6.68)]
LOWER_LIP = [(0.0, -7.58), (0.6, -7.57), (1.2, -7.44), (1.8, -7.14), (2.2, -6.90), (2.5, -6.72)]
LID_CREASE = [(1.75, 0.62), (2.2, 1.12), (2.9, 1.36), (3.6, 1.34), (4.3, 1.06), (4.9, 0.62)]
BROW = [(1.2, 1.95), (2.0, 2.35), (3.0, 2.68), (4.0, 2.88), (4.8, 2.72), (5.6, 2.15)]
NASOLABIAL = [(1.75, -3.3), (2.3, -4.3), (2.85, -5.3), (3.2, -6.3), (3.3, -7.1)]
HAIRLINE = [(0.0, 7.4), (2.0, 7.5), (4.0, 6.9), (5.6, 5.4), (6.3, 3.4), (6.6, 1.2), (6.9, -0.4)]


def upper_lid(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Height of the upper lid's margin over x of the left eye (1.68 to 4.62, clamped)."""
    return _interpolated(UPPER_LID, x)


def lower_lid(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Height of the lower lid's margin over x of the left eye."""
    return _interpolated(LOWER_LID, x)


def lid_crease(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Height of the fold above the upper lid."""
    return _interpolated(LID_CREASE, x)


def mouth_line(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Height of the line where the lips meet, over \\|x\\|."""
    return _interpolated(MOUTH_LINE, np.abs(x))


def upper_lip(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Height of the upper vermilion border, with the bow of Cupid, over \\|x\\|."""
    return _interpolated(UPPER_LIP, np.abs(x))


def lower_lip(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Height of the lower vermilion border over \\|x\\|."""
    return _interpolated(LOWER_LIP, np.abs(x))


def brow(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Height of the middle of the brow over \\|x\\|, 1.2 to 5.6."""
    return _interpolated(BROW, np.abs(x))


def hairline(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Height of the hairline over \\|x\\|, from the forehead to the sideburns."""
    return _interpolated(HAIRLINE, np.abs(x))
