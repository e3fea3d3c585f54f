"""Weight maps of generated shapes from those of the scans (paper §3.2, equations 10-11, and beyond it).

Maps W* give the scans back where W_n = Σ_m β̄_nm W*_m (equation 10). There are more shapes than scans, so it takes a
choice. The paper takes the smallest maps, W* = B⁺ W, which spread a wrinkle over all shapes of a scan, wherever they
act. The geometry-aware choice weighs shape m at each place by how much it moves the surface there: of all maps that
satisfy (10) it takes those of least Σ_m ‖W*_m(p)‖² / a_m(p)², and so puts a wrinkle on the shapes that make it.

Scans are noisy, their shapes alike, and skin is not linear: maps that give every scan back exactly exaggerate all of
it. Damping lets go of what scans do not agree on, as much as predicts every scan best from the others.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facezip.machine import memory
from facezip.machine.progress import track
from facezip.machine.rows import by_rows, map_rows, sum_rows

# Combinations of scans that B shows weaker than this part of the strongest are noise: they are left out.
TRUNCATION = 0.01
# Of the mean square of all activity: what a shape counts for where it moves nothing.
FLOOR = 1e-4
# Choices of damping, in units of the mean of diag(B A Bᵀ) over scans and places.
DAMPINGS = (0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0)


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


@dataclass(frozen=True, eq=False)
class GeometryAware:
    """W*(p) = A Bᵀ (B A Bᵀ + λ)⁻¹ W(p), A = diag(a_m(p)² + ε); without damping λ it satisfies (10) to rounding.

    Attributes
    ----------
    examples : of the example weights.
    activity : ``(h, w, M)`` ≥ 0, how far each shape moves the surface around a texel.
    squares : ``(M,)``, the means of a_m(p)², on all tiles alike: λ and ε are measured in them, and maps that had their
        own on every tile would break at the tiles' borders.
    """

    examples: Examples
    activity: NDArray[np.float32]
    squares: NDArray[np.float64]

    @classmethod
    def on(cls, examples: Examples, activities: Mapping[int, NDArray[np.float32]]) -> "dict[int, GeometryAware]":
        """Of the activity ``(h, w, M)`` on every tile."""
        total = np.sum([sum_rows(_squared(activity), len(activity)) for activity in activities.values()], axis=0)
        squares = total / sum(activity.shape[0] * activity.shape[1] for activity in activities.values())
        return {tile: cls(examples, activity, squares) for tile, activity in activities.items()}

    def maps(self, weights: NDArray[np.float32], damping: float) -> NDArray[np.float32]:
        """``(M, h, w, R)`` of the scans' maps ``(N, h, w, R)``; ``damping`` in units of the mean of diag(B A Bᵀ)."""
        generated: NDArray[np.float32] = memory.empty((self.activity.shape[2], *weights.shape[1:]), np.float32)
        held = damping * self._unit

        def rows(top: int, bottom: int) -> None:
            spread = self._spread(top, bottom)
            system = self.examples.weights @ spread + held * np.eye(len(self.examples.weights))
            solved = spread @ np.linalg.solve(system, self._mixed(weights, top, bottom))
            generated[:, top:bottom] = np.moveaxis(solved, 2, 0)

        map_rows(rows, len(self.activity))
        return generated

    def left_out(self, weights: NDArray[np.float32], importance: NDArray[np.float64], damping: float) -> float:
        """The squared error of each scan's maps as the others predict them, summed over scans and texels.

        The error of leaving one out needs no new fit: it is [K⁻¹W]_n / [K⁻¹]_nn, K the damped system.

        Parameters
        ----------
        weights : ``(N, h, w, R)``.
        importance : ``(R,)``, what a slot's squared error counts.
        damping : as of :meth:`maps`.
        """
        held = damping * self._unit

        def rows(top: int, bottom: int) -> NDArray[np.float64]:
            system = self.examples.weights @ self._spread(top, bottom)
            inverse = np.linalg.inv(system + held * np.eye(len(self.examples.weights)))
            gaps = inverse @ self._mixed(weights, top, bottom)
            gaps /= np.diagonal(inverse, axis1=2, axis2=3)[..., None]
            return np.sum(gaps**2 @ importance, axis=(0, 1))

        return float(sum_rows(rows, len(self.activity)).sum())

    @property
    def _unit(self) -> float:
        return float(np.mean(self.examples.weights**2 @ (self.squares + self._floor)))

    @property
    def _floor(self) -> float:
        return max(FLOOR * float(self.squares.mean()), float(np.finfo(np.float32).tiny))

    def _spread(self, top: int, bottom: int) -> NDArray[np.float64]:
        """A Bᵀ, ``(rows, w, M, r)``."""
        loose = np.square(self.activity[top:bottom], dtype=np.float64) + self._floor
        return loose[..., None] * self.examples.weights.T

    def _mixed(self, weights: NDArray[np.float32], top: int, bottom: int) -> NDArray[np.float64]:
        """The maps of the combinations of scans, ``(rows, w, r, R)``."""
        mixed = np.tensordot(self.examples.mixtures, weights[:, top:bottom], 1)
        return np.ascontiguousarray(np.moveaxis(mixed, 0, 2))


def _squared(activity: NDArray[np.float32]) -> Callable[[int, int], NDArray[np.float64]]:
    """``(M,)`` sums over blocks of rows."""
    return lambda top, bottom: np.square(activity[top:bottom], dtype=np.float64).sum(axis=(0, 1))


def best_damping(
    aware: Mapping[int, GeometryAware],
    weights: Mapping[int, NDArray[np.float32]],
    importance: Mapping[int, NDArray[np.float64]],
) -> float:
    """The one of :data:`DAMPINGS` with which each scan's maps are predicted best from those of all others.

    Parameters
    ----------
    aware : makes the maps of a tile.
    weights : the scans' weight maps ``(N, h, w, R)`` by tile.
    importance : ``(R,)`` by tile, what a slot's squared error counts there.
    """
    choices = track(DAMPINGS, "Choosing the damping", len(DAMPINGS))
    errors = [
        sum(aware[tile].left_out(weights[tile], importance[tile], damping) for tile in aware) for damping in choices
    ]
    return DAMPINGS[int(np.argmin(errors))]
