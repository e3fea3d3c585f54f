"""The textures of a strip of texels: a system of R equations a texel, by Cholesky's factorisation.

For every texel ``(Σ_n w_n w_nᵀ + ρ 1) D = Σ_n w_n d_n`` with w_n the R weights and d_n the difference of expression n.
Weights and differences lie one below the other in ``rows`` ``(K, N, LANES)``, K = R + C or :data:`ABREAST` at least, so
that all these sums are products of two rows. They go to ``normal`` ``(R, K, LANES)``: the matrix, then the right sides,
both of which are turned in place into the upper factor U and the textures.
"""

import numpy as np
from numpy.typing import NDArray

from facezip.machine.kernels import inner
from facezip.machine.vectors import (
    ABREAST,
    LANES,
    all_of,
    load,
    minus_product,
    plus,
    plus_product,
    reciprocal_root,
    store,
    times,
)


@inner()
def factor_strip(rows: NDArray[np.float32], count: int, ridge: np.float32, normal: NDArray[np.float32]) -> None:
    """Every texel's factor U, the reciprocals of its diagonal in their place, and U⁻ᵀ Σ_n w_n d_n beside it.

    Parameters
    ----------
    rows : ``(K, N, LANES)``.
    count : N; there may be more rows.
    ridge : ρ > 0.
    normal : ``(R, K, LANES)``, for the result; :func:`substitute` turns the right sides into textures.
    """
    slots, all_rows, _ = normal.shape
    for i in range(slots):
        for j in range(i, all_rows, ABREAST):
            _dots(rows, i, min(j, all_rows - ABREAST), count, normal)
    for i in range(slots):
        own = i * all_rows * LANES
        store(normal, own + i * LANES, plus(load(normal, own + i * LANES), all_of(ridge)))
        for k in range(i):
            other = k * all_rows * LANES
            factor = load(normal, other + i * LANES)
            for j in range(i * LANES, all_rows * LANES, LANES):
                store(normal, own + j, minus_product(load(normal, own + j), factor, load(normal, other + j)))
        root = reciprocal_root(load(normal, own + i * LANES), all_of(ridge))
        store(normal, own + i * LANES, root)
        for j in range((i + 1) * LANES, all_rows * LANES, LANES):
            store(normal, own + j, times(root, load(normal, own + j)))


@inner()
def _dots(rows: NDArray[np.float32], i: int, j: int, count: int, normal: NDArray[np.float32]) -> None:
    """Products of row i with four rows from j on: ``normal[i, j] = Σ_n rows[i, n] rows[j, n]``."""
    first = second = third = fourth = all_of(np.float32(0))
    apart = rows.shape[1] * LANES
    for n in range(0, count * LANES, LANES):
        value, beside = load(rows, i * apart + n), j * apart + n
        first = plus_product(first, value, load(rows, beside))
        second = plus_product(second, value, load(rows, beside + apart))
        third = plus_product(third, value, load(rows, beside + 2 * apart))
        fourth = plus_product(fourth, value, load(rows, beside + 3 * apart))
    there = (i * normal.shape[1] + j) * LANES
    store(normal, there, first)
    store(normal, there + LANES, second)
    store(normal, there + 2 * LANES, third)
    store(normal, there + 3 * LANES, fourth)


@inner()
def substitute(i: int, channels: int, normal: NDArray[np.float32]) -> None:
    """The best texture ``normal[i, R:]`` given those of all k > i, the others free: a step of back substitution."""
    slots, all_rows, _ = normal.shape
    own = i * all_rows
    for c in range(slots, slots + channels):
        value = load(normal, (own + c) * LANES)
        for k in range(i + 1, slots):
            value = minus_product(value, load(normal, (own + k) * LANES), load(normal, (k * all_rows + c) * LANES))
        store(normal, (own + c) * LANES, times(value, load(normal, (own + i) * LANES)))


@inner(error_model="numpy")
def round_strip(step: np.float32, values: NDArray[np.float32]) -> None:
    """Round to multiples of ``step`` within ±127 of them."""
    per_step = np.float32(1) / step
    for x in range(len(values)):
        values[x] = step * min(max(np.rint(values[x] * per_step), np.float32(-127)), np.float32(127))
