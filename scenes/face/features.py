"""Eyes that open and a mouth that is cut: rows of the grid that follow the lid margins and the line of the lips.

A row of the grid becomes the margin of the upper lid, one below it that of the lower lid; the rows between them lie
on the eyeball. A band of rows folds into the mouth: behind the upper lip to the upper teeth, to the dark back, and
out again over the lower teeth.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from scenes.face.sculpt import EYE
from scenes.face.steps import smooth_step

LID_HALF_WIDTH = 1.52
# How far the eyeball lies behind the lid margins, and how far it bulges between them.
LID_STEP = 0.13
EYE_BULGE = 0.17
MOUTH_Y = -6.10
MOUTH_HALF_WIDTH = 2.45


class Rows(NamedTuple):
    """Which rows of the grid carry which feature: margins of the lids, first and last row of the mouth's pocket."""

    lower_lid: int
    upper_lid: int
    lower_lip: int
    upper_lip: int


def find_rows(heights: NDArray[np.float64]) -> Rows:
    """The rows nearest to where the features lie on an even grid."""

    def nearest(height: float) -> int:
        return int(np.abs(heights - height).argmin())

    middle = nearest(MOUTH_Y)
    return Rows(nearest(EYE[1] - 0.42), nearest(EYE[1] + 0.48), middle - 6, middle + 6)


def lid_margins(x: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Heights of the lower and the upper lid margin at |x|; equal at the corners of the eye."""
    s = np.clip((np.abs(x) - EYE[0]) / LID_HALF_WIDTH, -1, 1)
    arch = np.sqrt(np.maximum(1 - s * s, 0))
    tilt = EYE[1] + 0.10 * s - 0.04
    # The upper margin peaks towards the nose, the lower one towards the temple.
    return tilt - 0.46 * arch**1.25 * (1 + 0.18 * s), tilt + 0.57 * arch * (1 - 0.14 * s)


def warp_heights(h: NDArray[np.float64], x: NDArray[np.float64], rows: Rows) -> NDArray[np.float64]:
    """Heights ``(rows, columns)`` moved so that the feature rows follow lids and lips at the given x."""
    warped = h.copy()
    lower, upper = lid_margins(x[rows.lower_lid])
    inside = _window(np.abs(x[rows.lower_lid]) - EYE[0], LID_HALF_WIDTH, 0.9)
    lips = _window(x[rows.lower_lip], MOUTH_HALF_WIDTH, 0.55)
    even = h[:, 0]
    for column in range(h.shape[1]):
        knots = [even[0], MOUTH_Y - 1.9, even[rows.lower_lip], even[rows.upper_lip], MOUTH_Y + 1.5, EYE[1] - 1.7]
        knots += [even[rows.lower_lid], even[rows.upper_lid], EYE[1] + 1.6, even[-1]]
        moved = list(knots)
        moved[2] += lips[column] * (lip_line(x[rows.lower_lip, column]) - 0.02 - moved[2])
        moved[3] += lips[column] * (lip_line(x[rows.lower_lip, column]) + 0.02 - moved[3])
        moved[6] += inside[column] * (lower[column] - moved[6])
        moved[7] += inside[column] * (upper[column] + 0.01 - moved[7])
        warped[:, column] = np.interp(even, knots, moved)
    return warped


def lip_line(x: float | NDArray[np.float64]) -> float | NDArray[np.float64]:
    """Height at which the lips meet: a shallow bow that drops towards the corners."""
    s = np.abs(x) / MOUTH_HALF_WIDTH
    return MOUTH_Y + 0.06 * np.cos(np.pi * np.minimum(s, 1.2)) - 0.05 * np.exp(-((s / 0.22) ** 2))


def open_eyes(positions: NDArray[np.float64], rows: Rows) -> None:
    """Drop the rows between the lid margins onto the eyeball, in place ``(rows, columns, 3)``."""
    lower, upper = positions[rows.lower_lid], positions[rows.upper_lid]
    s = np.clip((np.abs(lower[:, 0]) - EYE[0]) / LID_HALF_WIDTH, -1, 1)
    eye = (np.abs(s) < 1) & (lower[:, 2] > 4)
    arch = np.sqrt(np.maximum(1 - s * s, 0))
    steps = rows.upper_lid - rows.lower_lid
    for step in range(1, steps):
        t = step / steps
        margin = lower[:, 2] + t * (upper[:, 2] - lower[:, 2])
        bulge = arch * EYE_BULGE * (1 - (2 * t - 1) ** 2)
        row = positions[rows.lower_lid + step]
        row[eye, 2] = (margin - LID_STEP + bulge)[eye]


# Along the pocket from the upper lip's edge to the lower one's: depth behind the lips and height over their line.
_POCKET = np.array(
    [
        [0.00, 0.00], [0.35, 0.05], [0.62, 0.45], [0.72, 0.95], [0.80, 0.40], [0.86, -0.10],
        [3.20, -0.05],
        [0.98, -0.12], [0.92, -0.45], [0.84, -1.00], [0.66, -0.55], [0.36, -0.08], [0.00, 0.00],
    ]
)  # fmt: skip


def cut_mouth(positions: NDArray[np.float64], rows: Rows) -> None:
    """Fold the rows between the lips into the mouth, in place ``(rows, columns, 3)``."""
    band = positions[rows.lower_lip : rows.upper_lip + 1]
    x = band[0, :, 0]
    inside = (np.abs(x) < MOUTH_HALF_WIDTH) & (band[0, :, 2] > 5)
    scale = np.maximum(1 - (x / MOUTH_HALF_WIDTH) ** 2, 0)
    for row, (depth, height) in enumerate(_POCKET[::-1]):
        lips = (band[0] + band[-1]) / 2 if 0 < row < len(_POCKET) - 1 else band[row]
        band[row, inside, 2] = (lips[:, 2] - depth * scale)[inside]
        band[row, inside, 1] = (lips[:, 1] + height * scale)[inside]
        band[row, inside, 0] = (lips[:, 0] * (1 - 0.06 * depth * scale))[inside]


def _window(x: NDArray[np.float64], half_width: float, fade: float) -> NDArray[np.float64]:
    """One within ``half_width``, falling smoothly to zero over ``fade`` beyond it."""
    return smooth_step((half_width + fade - np.abs(x)) / fade)
