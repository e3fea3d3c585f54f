"""The inside of the mouth, on the sheet that folds into it."""

import numpy as np
from numpy.typing import NDArray

from facezip.machine.kernels import inner
from scenes.face.skin.noise import smooth, value_noise


@inner()
def paint_mouth(x: float, y: float, z: float, row: float, seed: int, colour: NDArray[np.float64]) -> None:
    """The pocket behind the lips, by its rows: inner lip, gum, teeth, dark, and the same upwards."""
    step = min(row, 12 - row)
    wet = np.array([0.50, 0.22, 0.21])
    gum = np.array([0.62, 0.33, 0.33])
    tooth = np.array([0.87, 0.83, 0.74]) * (0.93 + 0.05 * value_noise(3 * x, y, z, seed + 251))
    dark = np.array([0.09, 0.03, 0.03])
    # Upper teeth are wider than lower ones.
    across = abs(x) / (0.78 if row > 6 else 0.52)
    gap = abs(across - np.floor(across + 0.5))
    teeth = smooth(3.2, 3.5, step) * smooth(5.15, 4.95, step)
    deep = smooth(5.0, 5.25, step)
    lip = smooth(1.8, 0.2, step)
    for c in range(3):
        value = wet[c] + smooth(2.3, 3.0, step) * (gum[c] - wet[c])
        value += teeth * ((tooth[c] * (1 - 0.45 * smooth(0.07, 0.0, gap))) - value)
        value += deep * (dark[c] - value)
        colour[c] += (1 - lip * 0.9) * (value - colour[c])
