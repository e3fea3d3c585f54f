"""Weights that a fit leaves as they are: painted maps, and those of a region that is kept."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facezip.machine.rows import by_rows


@dataclass(frozen=True, eq=False)
class Held:
    """What of the weight maps ``(h, R, N, w)`` of a tile stays as it is, and between what the others lie.

    A pack stores the weights of a slot over one range. Where bytes of some maps are given it is known before the fit,
    and bounds all other weights of the slot.

    Attributes
    ----------
    where : ``(h, R, N, w)``, which weights stay.
    values : ``(h, R, N, w)`` float32, what they are there; elsewhere without meaning.
    low, high : ``(R, N)`` float32, bounds of the others.
    """

    where: NDArray[np.bool_]
    values: NDArray[np.float32]
    low: NDArray[np.float32]
    high: NDArray[np.float32]

    def put(self, weights: NDArray[np.float32]) -> NDArray[np.float32]:
        """Weights with those that stay in their place, and the others within their bounds."""

        def within(rows: slice) -> NDArray[np.float32]:
            free = np.clip(weights[rows], self.low[..., None], self.high[..., None])
            return np.where(self.where[rows], self.values[rows], free)

        return by_rows(within, weights.shape, np.float32)
