"""The textures of a strip of texels: a system of R equations a texel, by Cholesky's factorisation.

For every texel ``(Σ_n w_n w_nᵀ + ρ 1) D = Σ_n w_n d_n`` with w_n the R weights and d_n the difference of expression n.
The sums go to ``normal`` ``(rows, P, K, LANES)``: of every row of texels P slots, R or the next multiple of
:data:`ABREAST`, with the matrix's upper half and, from column P on, the right sides of all channels. Both are turned in
place into the upper factor U and the textures. Rows are independent of each other: while one waits for a root, others
go on.
"""

import numpy as np
from numpy.typing import NDArray

from facezip.files.images import Texels
from facezip.machine.kernels import inner
from facezip.machine.vectors import (
    ABREAST,
    LANES,
    all_at,
    all_of,
    load,
    load_abreast,
    minus,
    minus_product,
    plus,
    plus_product,
    reciprocal_root,
    room,
    store,
    times,
)


@inner()
def no_normal(rows: int, slots: int, channels: int) -> NDArray[np.float32]:
    """Room for ``normal``."""
    padded = (slots + ABREAST - 1) // ABREAST * ABREAST
    columns = padded + (channels + ABREAST - 1) // ABREAST * ABREAST
    return room(rows * padded * columns).reshape(rows, padded, columns, LANES)


@inner()
def add_up(
    rows: int,
    upper: NDArray[np.float32],
    change: NDArray[np.float32],
    fractions: NDArray[np.float32],
    tile: Texels,
    starts: NDArray[np.int64],
    scale: np.float32,
    normal: NDArray[np.float32],
) -> None:
    """The equations of so many rows of texels.

    Parameters
    ----------
    rows : how many.
    upper, change : ``(N, P, LANES)``.
    fractions : v of each row, whose weights are ``upper + v change``.
    tile, starts : texels (:func:`facezip.pack.strips.read_tile`), and which number of them is each row's first.
    scale : what differences of texels are to be multiplied with.
    normal : for the result.
    """
    padded = upper.shape[1]
    for a in range(0, padded, ABREAST):
        # Three channels at a time: where there are fewer, the others say nothing and are not read.
        for c in range(max(tile.shape[3] - 2, 1)):
            _group(rows, a, c, upper, change, fractions, tile, starts, scale, normal)
        for b in range(a + ABREAST, padded, ABREAST):
            _two_groups(rows, a, b, upper, change, fractions, normal)


@inner()
def _group(
    rows: int,
    a: int,
    c: int,
    upper: NDArray[np.float32],
    change: NDArray[np.float32],
    fractions: NDArray[np.float32],
    tile: Texels,
    starts: NDArray[np.int64],
    scale: np.float32,
    normal: NDArray[np.float32],
) -> None:
    """Products of four slots with each other and with three channels: 22 sums, in as many registers."""
    (count, padded, _), columns, zero, unit = upper.shape, normal.shape[2], all_of(np.float32(0)), all_of(scale)
    one, apart = (zero,), tile.shape[3] * LANES
    for row in range(rows):
        fourth = zero, zero, zero, zero
        third = one + fourth
        second = one + third
        first = one + second
        at, there, share = a * LANES, starts[row] + c * LANES, all_at(fractions, row)
        neutral = load(tile, there), load(tile, there + LANES), load(tile, there + 2 * LANES)
        for _ in range(count):
            there += apart
            weights = plus_product(load_abreast(upper, at), share, load_abreast(change, at))
            texel = load(tile, there), load(tile, there + LANES), load(tile, there + 2 * LANES)
            every = weights + minus(texel, neutral)
            first = plus_product(first, weights[0], every)
            second = plus_product(second, weights[1], every[1:])
            third = plus_product(third, weights[2], every[2:])
            fourth = plus_product(fourth, weights[3], every[3:])
            at += padded * LANES
        own = ((row * padded + a) * columns + a) * LANES
        right = ((row * padded + a) * columns + padded + c) * LANES
        store(normal, own, first[:4])
        store(normal, right, times(unit, first[4:]))
        store(normal, own + (columns + 1) * LANES, second[:3])
        store(normal, right + columns * LANES, times(unit, second[3:]))
        store(normal, own + (2 * columns + 2) * LANES, third[:2])
        store(normal, right + 2 * columns * LANES, times(unit, third[2:]))
        store(normal, own + (3 * columns + 3) * LANES, fourth[0])
        store(normal, right + 3 * columns * LANES, times(unit, fourth[1:]))


@inner()
def _two_groups(
    rows: int,
    a: int,
    b: int,
    upper: NDArray[np.float32],
    change: NDArray[np.float32],
    fractions: NDArray[np.float32],
    normal: NDArray[np.float32],
) -> None:
    """Products of four slots with four others."""
    (count, padded, _), columns, zero = upper.shape, normal.shape[2], all_of(np.float32(0))
    for row in range(rows):
        first = second = third = fourth = zero, zero, zero, zero
        share = all_at(fractions, row)
        for n in range(0, count * padded, padded):
            own, other = (n + a) * LANES, (n + b) * LANES
            weights = plus_product(load_abreast(upper, own), share, load_abreast(change, own))
            others = plus_product(load_abreast(upper, other), share, load_abreast(change, other))
            first = plus_product(first, weights[0], others)
            second = plus_product(second, weights[1], others)
            third = plus_product(third, weights[2], others)
            fourth = plus_product(fourth, weights[3], others)
        there = ((row * padded + a) * columns + b) * LANES
        store(normal, there, first)
        store(normal, there + columns * LANES, second)
        store(normal, there + 2 * columns * LANES, third)
        store(normal, there + 3 * columns * LANES, fourth)


@inner()
def factor(rows: int, slots: int, ridge: np.float32, normal: NDArray[np.float32]) -> None:
    """Every texel's factor U, the reciprocals of its diagonal in their place, and U⁻ᵀ Σ_n w_n d_n beside it.

    Parameters
    ----------
    rows : how many.
    slots : R.
    ridge : ρ > 0.
    normal : of :func:`add_up`; :func:`substitute` turns the right sides into textures.
    """
    _, padded, columns, _ = normal.shape
    size, apart = padded * columns * LANES, columns * LANES
    for i in range(slots):
        for top in range(0, rows * size, size):
            own, square = top + i * apart, load(normal, top + i * (apart + LANES))
            for above in range(top, own, apart):
                other = load(normal, above + i * LANES)
                square = minus_product(square, other, other)
            root = reciprocal_root(plus(square, all_of(ridge)), all_of(ridge))
            # Four columns at a time, the first of which may lie before the diagonal, where nothing is read.
            for j in range(i // ABREAST * ABREAST * LANES, apart, ABREAST * LANES):
                values = load_abreast(normal, own + j)
                for above in range(top, own, apart):
                    values = minus_product(values, load(normal, above + i * LANES), load_abreast(normal, above + j))
                store(normal, own + j, times(root, values))
            store(normal, own + i * LANES, root)


@inner()
def substitute(rows: int, i: int, slots: int, channels: int, normal: NDArray[np.float32]) -> None:
    """The best texture ``normal[:, i, P:]`` given those of all k > i, the others free: a step of back substitution."""
    _, padded, columns, _ = normal.shape
    for c in range(padded, padded + channels):
        for row in range(rows):
            top = row * padded * columns
            own = top + i * columns
            value = load(normal, (own + c) * LANES)
            for k in range(i + 1, slots):
                later = load(normal, (top + k * columns + c) * LANES)
                value = minus_product(value, load(normal, (own + k) * LANES), later)
            store(normal, (own + c) * LANES, times(value, load(normal, (own + i) * LANES)))


@inner(error_model="numpy")
def round_strip(step: np.float32, values: NDArray[np.float32]) -> None:
    """Round to multiples of ``step`` within ±127 of them."""
    per_step = np.float32(1) / step
    for x in range(len(values)):
        values[x] = step * min(max(np.rint(values[x] * per_step), np.float32(-127)), np.float32(127))
