"""The weight maps' equations solved in windows of the grid that fit into a processor's cache.

A window's texels are solved with those about it as they are (:mod:`facezip.fit.conjugate_gradients`). Windows are taken
one after the other, each from what those before have left (multiplicative Schwarz, Saad, Iterative Methods for Sparse
Linear Systems, 2nd edition, section 14.3): first every second band of them, in any order, on any number of cores, then
the others.
"""

import numpy as np
from numpy.typing import NDArray

from facezip.fit.conjugate_gradients import iterate, residual
from facezip.fit.window import ROWS, no_window, read, write
from facezip.machine.kernels import kernel
from facezip.machine.vectors import LANES


@kernel()
def solve_bands(
    top: int,
    bottom: int,
    parity: int,
    matrix: NDArray[np.float32],
    right: NDArray[np.float32],
    moving: NDArray[np.bool_],
    weights: NDArray[np.float32],
    before: NDArray[np.float32],
    gains: NDArray[np.float32],
    along: NDArray[np.float32],
) -> None:
    """Solve, in place, the windows of every second band whose last row lies within ``top`` and ``bottom``.

    Parameters
    ----------
    parity : which bands, 0 or 1.
    matrix, right : the system (:class:`facezip.fit.weights.WeightSystem`).
    moving : ``(h, w)``, the texels whose weights may change.
    weights, before : ``(h, R, N, w)``, as they are, and as they were.
    gains : ``(h, w)``, for rᵀ M⁻¹ r of each that moves before it does: what its own equations alone would gain.
    along : ``(h, w)``, for rᵀ (weights - before).
    """
    h, slots, count, w = weights.shape
    window = no_window(slots, count)
    flat = matrix.reshape(-1), right.reshape(-1), weights.reshape(-1), before.reshape(-1)
    for band in range((h + ROWS - 1) // ROWS):
        first = band * ROWS
        if band % 2 == parity and top <= min(first + ROWS, h) - 1 < bottom:
            for left in range(0, w, LANES):
                if moving[first : first + ROWS, left : left + LANES].any():
                    read(first, left, flat, weights.shape, moving, window)
                    residual(first, left, gains, along, window)
                    iterate(window)
                    write(first, left, weights.shape, window.x, flat[2])
