"""A small symmetric filter that makes one image of another: how much sharper, or blurred, the other one is."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import convolve

from facezip.machine.rows import sum_rows

RADIUS = 2
# Of the mean power: what a tap costs, so that an image without detail is left alone.
RIDGE = 1e-10

Values = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Filter:
    """A filter of 5 x 5 taps, the same under mirrors and quarter turns.

    Attributes
    ----------
    taps : ``(5, 5)`` float32.
    """

    taps: NDArray[np.float32]

    @property
    def radius(self) -> int:
        """Texels that a place sees on either side."""
        return RADIUS

    def __call__(self, values: Values) -> Values:
        """``(H, W, C)`` filtered; beyond the border lies what lies on it."""
        found: Values = convolve(values, self.taps[..., None], mode="nearest")
        return found

    @classmethod
    def towards(cls, source: Values, target: Values, weight: NDArray[np.float32]) -> "Filter":
        """The filter f that minimises Σ_p w(p) (target - f ∗ source)², for images ``(H, W, C)``."""
        basis = _basis()

        def sums(top: int, bottom: int) -> NDArray[np.float64]:
            first, last = max(top - RADIUS, 0), min(bottom + RADIUS, len(source))
            some, inner = source[first:last], slice(top - first, bottom - first)
            columns = [convolve(some, taps[..., None], mode="nearest")[inner] for taps in basis]
            flat = np.stack([*columns, target[top:bottom]]).reshape(len(basis) + 1, -1).astype(np.float64)
            counts = np.repeat(weight[top:bottom].ravel(), source.shape[2])
            return (flat * counts) @ flat.T

        system = sum_rows(sums, len(source))
        power = system[:-1, :-1]
        start = np.zeros(len(basis))
        start[0] = 1
        ridge = RIDGE * max(np.trace(power) / len(basis), np.finfo(float).tiny) * np.eye(len(basis))
        shares = np.linalg.solve(power + ridge, system[:-1, -1] + ridge @ start)
        return cls(np.tensordot(shares, np.array(basis), 1).astype(np.float32))


def _basis() -> list[NDArray[np.float32]]:
    """Rings of taps that are equally far, the middle first."""
    line = np.abs(np.arange(-RADIUS, RADIUS + 1))
    far = line[:, None] ** 2 + line**2
    return [(far == distance).astype(np.float32) for distance in np.unique(far)]
