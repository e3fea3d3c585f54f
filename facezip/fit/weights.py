"""The weight maps' side of an alternation: a sparse system on the low-resolution grid, solved for all expressions.

Layout: a row of the grid holds ``(R, N, w)`` weights and ``(R, R, 9, w)`` couplings, columns innermost, so that the
kernels run along rows in vector registers.
"""

from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from facezip.fit.windows import solve_bands
from facezip.machine import memory
from facezip.machine.kernels import kernel
from facezip.machine.rows import by_rows, map_rows

# What ties a weight to its neighbours, and to zero, as a part of the system's mean diagonal. The first fills what no
# texel sees; both keep noise out of the weights.
SMOOTHNESS = 1e-3
RIDGE = 3e-3


class WeightSystem(NamedTuple):
    """Normal equations of all weight maps: ``matrix · W_n = right_n`` on the grid of low-resolution texels.

    Attributes
    ----------
    matrix : ``(h, R, R, 9, w)`` float32, coupling of a texel with its 3 x 3 neighbours, row by row.
    right : ``(h, R, N, w)`` float32.
    """

    matrix: NDArray[np.float32]
    right: NDArray[np.float32]

    @classmethod
    def zeros(cls, shape: tuple[int, ...]) -> "WeightSystem":
        """No equation yet for weights of ``shape`` ``(h, R, N, w)``."""
        h, slots, _, w = shape
        return cls(memory.zeros((h, slots, slots, 9, w), np.float32), memory.zeros(shape, np.float32))

    @property
    def mean_diagonal(self) -> float:
        """The unit of the regularisation."""
        return float(np.einsum("hiiw->", self.matrix[:, :, :, 4], dtype=np.float64) / self.right[:, :, 0].size)

    def regularise(self, unit: float, smoothness: float = SMOOTHNESS) -> None:
        """Add the equations of ``smoothness · unit · ‖∇W‖² + RIDGE · unit · ‖W‖²``."""
        # A grid where no texel counts at all would be singular.
        tie, ridge = np.float32(smoothness * unit), np.float32(max(RIDGE * unit, 1e-30))
        map_rows(lambda top, bottom: _regularise(top, bottom, self.matrix, tie, ridge), len(self.matrix))


class Moves(NamedTuple):
    """Which weight texels ``(h, w)`` a solver may change, and what it says of those.

    Attributes
    ----------
    moving : ``(h, w)``.
    before : ``(h, R, N, w)`` float32, what the weights were before they came to where they are.
    gains : ``(h, w)`` float32, about how much lower the squared error is by the change of each.
    along : ``(h, w)`` float32, below 0 where the weights came too far: how much further on the error would fall.
    """

    moving: NDArray[np.bool_]
    before: NDArray[np.float32]
    gains: NDArray[np.float32]
    along: NDArray[np.float32]

    @classmethod
    def of(cls, moving: NDArray[np.bool_], before: NDArray[np.float32]) -> "Moves":
        """With nothing said yet."""
        return cls(moving, before, np.zeros(moving.shape, np.float32), np.zeros(moving.shape, np.float32))

    @classmethod
    def everywhere(cls, weights: NDArray[np.float32]) -> "Moves":
        """All texels of weights ``(h, R, N, w)``."""
        return cls.of(np.ones((len(weights), weights.shape[3]), np.bool_), weights)


def improve_weights(system: WeightSystem, weights: NDArray[np.float32], moves: Moves) -> None:
    """Bring weights ``(h, R, N, w)`` nearer to the solution, in place (:mod:`facezip.fit.windows`)."""
    arrays = system.matrix, system.right, moves.moving, weights, moves.before, moves.gains, moves.along
    for parity in (0, 1):
        map_rows(partial(_solve, parity, arrays), len(weights))


def _solve(parity: int, arrays: tuple[NDArray[Any], ...], top: int, bottom: int) -> None:
    solve_bands(top, bottom, parity, *arrays)


def solve_weights(system: WeightSystem, start: NDArray[np.float32]) -> NDArray[np.float32]:
    """Weights nearer to the solution than ``start`` ``(h, R, N, w)``."""
    weights = by_rows(lambda rows: start[rows], start.shape, np.float32)
    improve_weights(system, weights, Moves.everywhere(weights))
    return weights


@kernel()
def _regularise(top: int, bottom: int, matrix: NDArray[np.float32], tie: np.float32, ridge: np.float32) -> None:
    h, slots, _, _, w = matrix.shape
    for y in range(top, bottom):
        for i in range(slots):
            for x in range(w):
                neighbours = 0
                for there, cell in ((y > 0, 1), (x > 0, 3), (x < w - 1, 5), (y < h - 1, 7)):
                    if there:
                        matrix[y, i, i, cell, x] -= tie
                        neighbours += 1
                matrix[y, i, i, 4, x] += neighbours * tie + ridge
