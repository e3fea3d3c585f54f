"""How noisy a scan is at a brightness, from what scans disagree on where nothing moved."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

from facezip.cleaning.cells import Cells

# Of the cells of a brightness over all scans, those that agree best with the neutral: nothing but noise is in them.
QUIET = 0.1
# Brightnesses that are told apart.
BINS = 8


@dataclass(frozen=True)
class Noise:
    """The variance of one scan's texel of value I: a + b I, for values in [0, 1] (Foi et al. 2008)."""

    constant: float
    slope: float

    @classmethod
    def of(cls, cells: Cells) -> "Noise":
        """From half the mean squares of differences: the neutral is as noisy as a scan."""
        brightness = cells.neutral.mean(axis=2)[cells.face]
        if not len(brightness):
            return cls(0.0, 0.0)
        gaps = cells.gaps[:, cells.face]
        order = np.argsort(brightness, kind="stable")
        parts = [part for part in np.array_split(order, BINS) if len(part)]
        values = np.array([brightness[part].mean() for part in parts])
        levels = np.array([np.quantile(gaps[:, part], QUIET) / 2 for part in parts])
        constant, slope = nnls(np.stack([np.ones_like(values), values], axis=1), levels)[0]
        return cls(float(constant), float(slope))

    def at(self, values: NDArray[np.float32]) -> NDArray[np.float32]:
        """The variance at every value."""
        found: NDArray[np.float32] = np.float32(self.constant) + np.float32(self.slope) * np.clip(values, 0, 1)
        return found
