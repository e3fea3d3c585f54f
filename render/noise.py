"""What of a measured difference is render noise.

A pose is rendered as two halves with independent random numbers. Their mean is the image; from their difference
follow the noise floor and an estimate of the error that noise does not bias.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from render.metrics import display
from render.paired import Images


@dataclass(frozen=True, eq=False)
class Halves:
    """Two independent renders of one pose, each with half of the samples, and the same K textures."""

    first: Images
    second: Images

    @property
    def mean(self) -> Images:
        """The image with all samples."""
        linear: NDArray[np.float32] = (self.first.linear + self.second.linear) * np.float32(0.5)
        coverage: NDArray[np.float32] = (self.first.coverage + self.second.coverage) * np.float32(0.5)
        return Images(linear, coverage)

    def merged(self, others: "Halves") -> "Halves":
        """These and as many samples more."""
        return Halves(Halves(self.first, others.first).mean, Halves(self.second, others.second).mean)


def noise_floor(halves: Halves, head: NDArray[np.bool_]) -> float:
    """RMSE (0..255) to expect between two independent renders of the original with all samples.

    The halves differ by twice the variance of one half, two full renders by half as much.
    """
    gap = display(halves.first.linear[0][head]) - display(halves.second.linear[0][head])
    return float(255 * np.sqrt(np.mean(np.square(gap, dtype=np.float64)) / 2))


def debiased_rmse(halves: Halves, k: int, head: NDArray[np.bool_]) -> float:
    """RMSE (0..255) of texture k against the original, without the part that noise adds.

    Twice the squared error of all samples minus the mean of the halves' (Quenouille's jackknife). For values that are
    linear in radiance that is mean((A0 - B0)(A1 - B1)), the product of independent differences, which has no bias; for
    encoded ones it is free of the bias that the display's curve adds to noisy pixels as well, to first order.
    """
    whole, *parts = (_squared_error(image, k, head) for image in (halves.mean, halves.first, halves.second))
    return float(255 * np.sqrt(max(0.0, 2 * whole - sum(parts) / 2)))


def _squared_error(image: Images, k: int, head: NDArray[np.bool_]) -> float:
    gap = display(image.linear[0][head]) - display(image.linear[k][head])
    return float(np.mean(np.square(gap, dtype=np.float64)))
