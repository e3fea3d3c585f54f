"""Weight maps within bounds, such as not negative: their equations solved by relaxation, texel by texel.

Each unknown in turn takes the best value that it may: projected Gauss and Seidel (Saad, Iterative Methods for Sparse
Linear Systems, 2nd edition, section 4.1). Texels are taken in four colours, of which no two of one colour are
neighbours, so that those of a colour may be solved in any order, on any number of cores.
"""

from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from facezip.fit.weights import Moves, WeightSystem
from facezip.machine.kernels import kernel
from facezip.machine.rows import by_rows, map_rows

# Warm started: more would solve exactly what the next alternation changes again.
SWEEPS = 4
COLOURS = 4


class Limits(NamedTuple):
    """Between what weights stay, and which of them stay as they are.

    Attributes
    ----------
    low, high : ``(R, N)`` float32, of slot and expression.
    held : ``(h, R, N, w)``, or None.
    """

    low: NDArray[np.float32]
    high: NDArray[np.float32]
    held: NDArray[np.bool_] | None = None

    @classmethod
    def nonnegative(cls, weights: NDArray[np.float32]) -> "Limits":
        """Of weights ``(h, R, N, w)``."""
        low = np.zeros(weights.shape[1:3], np.float32)
        return cls(low, np.full_like(low, np.inf))


def improve_bounded(
    system: WeightSystem, weights: NDArray[np.float32], moves: Moves, limits: Limits, sweeps: int = SWEEPS
) -> None:
    """Sweeps over weights ``(h, R, N, w)``, in place, within ``limits``."""
    height = len(weights)
    bounds = np.ascontiguousarray(limits.low), np.ascontiguousarray(limits.high)
    # Of one type whether there are any: the kernel is compiled once.
    held = np.zeros((0, 0, 0, 0), np.bool_) if limits.held is None else limits.held
    relax = partial(_relax, matrix=system.matrix, right=system.right, bounds=bounds, held=held)
    for step in range(sweeps * COLOURS):
        map_rows(partial(relax, step=step, weights=weights, **moves._asdict()), height)


def solve_bounded(
    system: WeightSystem, start: NDArray[np.float32], limits: Limits, sweeps: int = SWEEPS
) -> NDArray[np.float32]:
    """Weights after sweeps from ``start`` ``(h, R, N, w)``, which lies within ``limits``."""
    weights = by_rows(lambda rows: start[rows], start.shape, np.float32)
    improve_bounded(system, weights, Moves.everywhere(weights), limits, sweeps)
    return weights


@kernel(fastmath={"contract"}, error_model="numpy")
def _relax(
    top: int,
    bottom: int,
    step: int,
    matrix: NDArray[np.float32],
    right: NDArray[np.float32],
    bounds: tuple[NDArray[np.float32], NDArray[np.float32]],
    held: NDArray[np.bool_],
    weights: NDArray[np.float32],
    moving: NDArray[np.bool_],
    before: NDArray[np.float32],
    gains: NDArray[np.float32],
    along: NDArray[np.float32],
) -> None:
    h, slots, count, w = right.shape
    colour, (low, high) = step % COLOURS, bounds
    rest = np.empty(count, np.float32)
    for y in range(top + (colour // 2 - top) % 2, bottom, 2):
        for x in range(colour % 2, w, 2):
            for i in range(slots if moving[y, x] else 0):
                for n in range(count):
                    rest[n] = right[y, i, n, x]
                for near in range(max(y - 1, 0), min(y + 2, h)):
                    for beside in range(max(x - 1, 0), min(x + 2, w)):
                        cell = 3 * (near - y + 1) + beside - x + 1
                        for j in range(slots):
                            for n in range(count):
                                rest[n] -= matrix[y, i, j, cell, x] * weights[near, j, n, beside]
                for n in range(count):
                    if held.size == 0 or not held[y, i, n, x]:
                        here = weights[y, i, n, x]
                        best = min(max(here + rest[n] / matrix[y, i, i, 4, x], low[i, n]), high[i, n])
                        weights[y, i, n, x] = best
                        gains[y, x] += matrix[y, i, i, 4, x] * (best - here) ** 2
                        # Once: later there is no telling where momentum had led.
                        if step < COLOURS:
                            along[y, x] += matrix[y, i, i, 4, x] * (best - here) * (here - before[y, i, n, x])
