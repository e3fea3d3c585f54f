"""The step that everything smooth about the head is made of."""

import numpy as np
from numpy.typing import NDArray


def smooth_step(t: NDArray[np.float64]) -> NDArray[np.float64]:
    """From 0 at 0 and below to 1 at 1 and above, flat at both: Hermite's."""
    t = np.clip(t, 0, 1)
    return t * t * (3 - 2 * t)
