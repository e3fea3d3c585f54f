"""Weight maps within bounds, such as not negative: their equations solved by relaxation, texel by texel.

Each unknown in turn takes the best value that it may: projected Gauss and Seidel (Saad, Iterative Methods for Sparse
Linear Systems, 2nd edition, section 4.1). Texels are taken in four colours, of which no two of one colour are
neighbours, so that those of a colour may be solved in any order, on any number of cores.
"""

from functools import partial

import numpy as np
from numpy.typing import NDArray

from facezip.fit.weights import WeightSystem, multiply
from facezip.machine import memory
from facezip.machine.kernels import kernel
from facezip.machine.rows import by_rows, map_rows, sum_rows

# Warm started: more would solve exactly what the next alternation changes again.
SWEEPS = 4
COLOURS = 4


def solve_nonnegative(
    system: WeightSystem, start: NDArray[np.float32], sweeps: int = SWEEPS
) -> tuple[NDArray[np.float32], float]:
    """A few sweeps from ``start`` ≥ 0, ``(h, R, N, w)``; returns as :func:`facezip.fit.weights.solve_weights`."""
    low = np.zeros(start.shape[1:3], np.float32)
    return solve_bounded(system, start, low, np.full_like(low, np.inf), sweeps)


def solve_bounded(
    system: WeightSystem,
    start: NDArray[np.float32],
    low: NDArray[np.float32],
    high: NDArray[np.float32],
    sweeps: int = SWEEPS,
    held: NDArray[np.bool_] | None = None,
) -> tuple[NDArray[np.float32], float]:
    """Sweeps from ``start`` ``(h, R, N, w)``; weights stay between ``low`` and ``high``, ``(R, N)``, of slot and
    expression, and as they are where they are ``held`` ``(h, R, N, w)``. Returns as
    :func:`facezip.fit.weights.solve_weights`.
    """
    product: NDArray[np.float32] = memory.empty(start.shape, np.float32)
    height, right = len(start), system.right
    sum_rows(lambda top, bottom: multiply(top, bottom, system.matrix, start, product), height)

    def share(top: int, bottom: int) -> float:
        return float(np.vdot(start[top:bottom], 2 * right[top:bottom] - product[top:bottom]))

    explained = sum(map_rows(share, height))
    weights = by_rows(lambda rows: start[rows], start.shape, np.float32)
    bounds = np.ascontiguousarray(low), np.ascontiguousarray(high)
    # Of one type whether there are any: the kernel is compiled once.
    held = np.zeros((0, 0, 0, 0), np.bool_) if held is None else held
    for step in range(sweeps * COLOURS):
        relax = partial(_relax, colour=step % COLOURS, matrix=system.matrix, right=right, bounds=bounds, held=held)
        map_rows(partial(relax, weights=weights), height)
    return weights, explained


@kernel(fastmath={"contract"}, error_model="numpy")
def _relax(
    top: int,
    bottom: int,
    colour: int,
    matrix: NDArray[np.float32],
    right: NDArray[np.float32],
    bounds: tuple[NDArray[np.float32], NDArray[np.float32]],
    held: NDArray[np.bool_],
    weights: NDArray[np.float32],
) -> None:
    h, slots, count, w = right.shape
    low, high = bounds
    rest = np.empty(count, np.float32)
    for y in range(top + (colour // 2 - top) % 2, bottom, 2):
        for x in range(colour % 2, w, 2):
            for i in range(slots):
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
                        best = weights[y, i, n, x] + rest[n] / matrix[y, i, i, 4, x]
                        weights[y, i, n, x] = min(max(best, low[i, n]), high[i, n])
