"""The paper's weight maps of generated shapes from those of the scans (§3.2, equations 10-11).

Maps W* give the scans back where W_n = Σ_m β̄_nm W*_m (equation 10). There are more shapes than scans, so it takes a
choice. The paper takes the smallest maps, W* = B⁺ W, which spread a wrinkle over all shapes of a scan, wherever they
act, and exaggerate all noise; :mod:`facezip.rigging.evidence` makes better ones.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facezip.machine.rows import by_rows

# Combinations of scans that B shows weaker than this part of the strongest are noise: they are left out.
TRUNCATION = 0.01


@dataclass(frozen=True, eq=False)
class Examples:
    """The part of the example weights B that can be inverted.

    Attributes
    ----------
    mixtures : ``(r, N)``, orthonormal combinations of scans that B tells apart.
    weights : ``(r, M)``, what shapes are in each combination.
    condition : cond(B), the largest over the smallest singular value before truncation.
    """

    mixtures: NDArray[np.float64]
    weights: NDArray[np.float64]
    condition: float

    @classmethod
    def of(cls, example_weights: NDArray[np.float64]) -> "Examples":
        """From B, ``(N, M)``; singular values below :data:`TRUNCATION` of the largest are cut."""
        left, values, _ = np.linalg.svd(example_weights, full_matrices=False)
        kept = values > TRUNCATION * values[0]
        condition = float(values[0] / values[-1]) if values[-1] > 0 else float("inf")
        mixtures = left[:, kept].T
        return cls(mixtures, mixtures @ example_weights, condition)

    @property
    def inverse(self) -> NDArray[np.float64]:
        """B⁺, ``(M, N)``."""
        inverse: NDArray[np.float64] = np.linalg.pinv(self.weights) @ self.mixtures
        return inverse


def pseudo_inverse(weights: NDArray[np.float32], examples: Examples) -> NDArray[np.float32]:
    """The paper's W* = B⁺ W, ``(M, h, w, R)``, of the scans' maps ``(N, h, w, R)`` (equation 11)."""
    inverse, shape = examples.inverse, (examples.weights.shape[1], *weights.shape[1:])

    def generated(rows: slice) -> NDArray[np.float64]:
        some: NDArray[np.float64] = np.tensordot(inverse, weights[:, rows], 1)
        return some

    return by_rows(generated, shape, np.float32, axis=1)
