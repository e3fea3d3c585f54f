"""Rows of the grid where rays from the head's axis graze the sculpt: under the nose and under the chin.

Such a ray meets the surface here, and the next one a centimetre on. So along a column the profile of the sculpt is
followed, into nostrils and around the chin, and rows are spread over its length as they are over its height.
"""

import numpy as np
from numpy.typing import NDArray

from facezip.machine.kernels import inner, kernel
from scenes.face.chart import axis
from scenes.face.sculpt import distance

Array = NDArray[np.float64]

# Between which heights (cm) profiles are followed, and up to which azimuths (radians): altogether, and at all.
BANDS = ((-0.6, -5.3, 0.24, 0.40), (-7.6, -13.5, 4.0, 5.0))
# Steps along a profile, and of a gradient's differences, cm.
STEP, DIFFERENCE = 0.025, 1e-3
LONGEST = 1000


def follow(positions: Array, heights: Array, azimuths: Array) -> None:
    """Spread rows over the profiles of the sculpt within :data:`BANDS`, in place.

    Parameters
    ----------
    positions : ``(rows, columns, 3)`` cm, on the sculpt.
    heights : ``(rows, columns)``, of the rays that found them.
    azimuths : ``(columns,)`` radians.
    """
    for top, bottom, inside, outside in BANDS:
        for column, azimuth in enumerate(azimuths):
            amount = np.clip((outside - abs(azimuth)) / (outside - inside), 0, 1)
            if amount > 0:
                rows = slice(*np.searchsorted(heights[:, column], (bottom, top)))
                even = heights[rows, column]
                _spread(positions[rows, column], (even[-1] - even) / np.ptp(even), float(azimuth), float(amount))


def _spread(points: Array, share: Array, azimuth: float, amount: float) -> None:
    """Move points ``(rows, 3)``, the lowest first, by ``amount`` to these shares of the profile from the highest."""
    path = _profile(azimuth, points[-1], points[0, 1])
    length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    target = share * length[-1]
    if amount < 1:
        here = length[np.linalg.norm(points[:, None] - path, axis=2).argmin(axis=1)]
        target = here + amount * (target - here)
    for c in range(3):
        points[:, c] = np.interp(target, length, path[:, c])


def _profile(azimuth: float, start: Array, end: float) -> Array:
    """Points ``(N, 3)`` down the sculpt from one of it to the height ``end``, at an azimuth about its axis."""
    depths, along = axis()
    out = np.hypot(start[0], start[2] - np.interp(start[1], depths, along))
    path: Array = _walk(azimuth, float(out), float(start[1]), float(end), depths, along)
    return path


@kernel()
def _walk(azimuth: float, out: float, y: float, end: float, depths: Array, along: Array) -> Array:
    path = np.empty((LONGEST, 3))
    sine, cosine = np.sin(azimuth), np.cos(azimuth)
    for n in range(LONGEST):
        for _ in range(2):
            here, across, up = _slope(out, y, sine, cosine, depths, along)
            back = here / max(across * across + up * up, 0.1)
            out, y = out - back * across, y - back * up
        path[n] = out * sine, y, np.interp(y, depths, along) + out * cosine
        if y <= end:
            return path[: n + 1]
        size = max(np.sqrt(across * across + up * up), 1e-9)
        out, y = out + STEP * up / size, y - STEP * across / size
    return path


@inner()
def _slope(out: float, y: float, sine: float, cosine: float, depths: Array, along: Array) -> tuple[float, float, float]:
    """The distance at a place of the profile's plane, and its derivatives outwards and upwards."""
    z, higher = np.interp(y, depths, along), np.interp(y + DIFFERENCE, depths, along)
    here = distance(out * sine, y, z + out * cosine)
    further = out + DIFFERENCE
    across = (distance(further * sine, y, z + further * cosine) - here) / DIFFERENCE
    return here, across, (distance(out * sine, y + DIFFERENCE, higher + out * cosine) - here) / DIFFERENCE
