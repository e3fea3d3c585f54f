"""Vertices spread evenly over the base of the nose, where one column of the grid drops into a nostril and the next not.

Every vertex moves between its neighbours and back onto the sculpt: rims become round, and cells span what lies deep in
a nostril, where it is dark.
"""

import numpy as np
from numpy.typing import NDArray

from facezip.machine.kernels import inner, kernel
from scenes.face.sculpt import distance

# Of the base of the nose, cm, and how often vertices move there.
CENTRE, RADII = np.array([0.0, -3.6, 9.2]), np.array([2.4, 1.5, 2.4])
ROUNDS = 24
# Of the gradient's differences, cm.
STEP = 1e-3


def relax(positions: NDArray[np.float64]) -> None:
    """Even out vertices ``(rows, columns, 3)`` around the nostrils, in place."""
    away = np.linalg.norm((positions - CENTRE) / RADII, axis=2)
    mobility = np.clip(3 * (1 - away), 0, 1)
    for _ in range(ROUNDS):
        positions[:] = _round(positions, mobility)


@kernel()
def _round(positions: NDArray[np.float64], mobility: NDArray[np.float64]) -> NDArray[np.float64]:
    moved = positions.copy()
    for j in range(1, positions.shape[0] - 1):
        for i in range(1, positions.shape[1] - 1):
            if mobility[j, i] > 0:
                around = positions[j - 1, i] + positions[j + 1, i] + positions[j, i - 1] + positions[j, i + 1]
                p = positions[j, i] + mobility[j, i] * (around / 4 - positions[j, i])
                _settle(p)
                moved[j, i] = p
    return moved


@inner()
def _settle(p: NDArray[np.float64]) -> None:
    """Onto the surface, along the gradient, in place."""
    for _ in range(2):
        here = distance(p[0], p[1], p[2])
        x = (distance(p[0] + STEP, p[1], p[2]) - here) / STEP
        y = (distance(p[0], p[1] + STEP, p[2]) - here) / STEP
        z = (distance(p[0], p[1], p[2] + STEP) - here) / STEP
        back = here / max(x * x + y * y + z * z, 0.1)
        p[0] -= back * x
        p[1] -= back * y
        p[2] -= back * z
