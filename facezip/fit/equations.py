"""The weight maps' equations from the sums of strips of texels (:mod:`facezip.fit.sweep` says what they are).

The four shares of a texel in the weight texels about it are products of one along the row and one along the column. So
what lies between two rows of weight texels is summed first, column by column (:mod:`facezip.fit.accumulation`), and
shared out to their equations once. Two such rows follow each other with one row of weight texels in common, whose sums
go on.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from facezip.machine.kernels import inner, kernel
from facezip.machine.shuffles import add_fours, folded, transposed
from facezip.machine.vectors import (
    ABREAST,
    LANES,
    all_of,
    load_abreast,
    minus,
    plus_product,
    room,
    store,
    times,
)

# Those of a texel's nine couplings that a sweep sums: with itself, with the next one, and below both. The others are
# the same from the other side.
CELLS = 4, 5, 7, 8


class Shared(NamedTuple):
    """What a strip's texels have in the columns of weight texels, four of them at a time.

    Attributes
    ----------
    single, own, both : ``(columns, ABREAST, LANES)``: shares s, squares s², and products of s with the next column's;
        each for the values of :func:`facezip.machine.shuffles.transposed`.
    """

    single: NDArray[np.float32]
    own: NDArray[np.float32]
    both: NDArray[np.float32]


class Equations(NamedTuple):
    """A part of a weight system: rows of weight texels, with some columns to spare.

    Attributes
    ----------
    matrix : ``(rows, Q, CELLS, width)``, pairs as in :class:`facezip.fit.accumulation.Sums`.
    right : ``(rows, P, N, width)``.
    """

    matrix: NDArray[np.float32]
    right: NDArray[np.float32]


def no_equations(shape: tuple[int, ...], spare: int) -> Equations:
    """Of rows of weights of ``shape`` ``(rows, R, N, w)``, and so many columns to spare."""
    rows, slots, count, w = shape
    pairs = slots * (slots + 1) // 2
    padded, all_pairs = (-(-number // ABREAST) * ABREAST for number in (slots, pairs))
    return Equations(
        np.zeros((rows, all_pairs, len(CELLS), w + spare), np.float32),
        np.zeros((rows, padded, count, w + spare), np.float32),
    )


@inner()
def no_shared(columns: int) -> Shared:
    """Room for the shares in so many columns, a multiple of :data:`ABREAST`."""
    size = columns * ABREAST
    return Shared(
        room(size).reshape(columns, ABREAST, LANES),
        room(size).reshape(columns, ABREAST, LANES),
        room(size).reshape(columns, ABREAST, LANES),
    )


@inner()
def spread_shares(shares: NDArray[np.float32], shared: Shared) -> None:
    """Of ``shares`` ``(columns, LANES)`` (:func:`facezip.pack.strips.find_shares`)."""
    for q in range(len(shares)):
        for k in range(ABREAST):
            for x in range(LANES):
                at = x - x % ABREAST + k
                share = shares[q, at]
                # A texel lies between two columns: those that are further apart have none in common.
                beside = shares[q + 1, at] if q + 1 < len(shares) else np.float32(0)
                shared.single[q, k, x] = share
                shared.own[q, k, x] = share * share
                shared.both[q, k, x] = share * beside


@inner()
def collect_row(
    row: int,
    first: int,
    shared: Shared,
    squares: NDArray[np.float32],
    products: NDArray[np.float32],
    equations: Equations,
) -> None:
    """Share the upper row's sums out to the weight texels of a ``row``, columns from ``first`` on, and to what couples
    them to the next one; then that is the upper one.
    """
    (single, own, both), (matrix, right), nothing = shared, equations, _nothing()
    _, pairs, _, wide = matrix.shape
    _collect_products(products, row, first, single, right)
    apart, rows = pairs * LANES, len(CELLS) * wide
    for pair in range(0, pairs, ABREAST):
        at, there = pair * LANES, (row * pairs + pair) * rows + first
        lower, twice = load_abreast(squares, at + apart), load_abreast(squares, at + 2 * apart)
        between = minus(lower, twice)
        upper = minus(minus(load_abreast(squares, at), lower), between)
        _share_out(upper, own, matrix, there, rows)
        _share_out(upper, both, matrix, there + wide, rows)
        _share_out(between, own, matrix, there + 2 * wide, rows)
        _share_out(between, both, matrix, there + 3 * wide, rows)
        store(squares, at, twice)
        store(squares, at + apart, nothing)
        store(squares, at + 2 * apart, nothing)


@inner()
def _nothing() -> tuple[float, ...]:
    zero = all_of(np.float32(0))
    return zero, zero, zero, zero


@inner()
def _collect_products(
    products: NDArray[np.float32], row: int, first: int, shares: NDArray[np.float32], right: NDArray[np.float32]
) -> None:
    (_, padded, count, wide), nothing = right.shape, _nothing()
    below = products.shape[1] * padded * LANES
    for n in range(count):
        for i in range(0, padded, ABREAST):
            at = (n * padded + i) * LANES
            lower = load_abreast(products, at + below)
            upper = minus(load_abreast(products, at), lower)
            _share_out(upper, shares, right, ((row * padded + i) * count + n) * wide + first, count * wide)
            store(products, at, lower)
            store(products, at + below, nothing)


@inner()
def _share_out(
    values: tuple[float, ...], shares: NDArray[np.float32], out: NDArray[np.float32], at: int, apart: int
) -> None:
    """Sums of four vectors, times the shares in each column, to four rows of ``out`` that are ``apart``."""
    turned = transposed(values)
    for q in range(0, len(shares), ABREAST):
        near = _shared(turned, shares, q), _shared(turned, shares, q + 1)
        far = _shared(turned, shares, q + 2), _shared(turned, shares, q + 3)
        add_fours(out, at + q, apart, folded(near + far))


@inner()
def _shared(turned: tuple[float, ...], shares: NDArray[np.float32], q: int) -> float:
    share = load_abreast(shares, q * ABREAST * LANES)
    total = times(turned[0], share[0])
    total = plus_product(total, turned[1], share[1])
    total = plus_product(total, turned[2], share[2])
    return plus_product(total, turned[3], share[3])


@kernel()
def add_equations(
    equations: Equations, scale: np.float32, matrix: NDArray[np.float32], right: NDArray[np.float32]
) -> None:
    """Add a part to its rows of a system, whose :func:`complete` is to follow.

    Parameters
    ----------
    scale : what differences of texels are to be multiplied with.
    matrix, right : of the system, as in :class:`facezip.fit.weights.WeightSystem`.
    """
    _, slots, count, w = right.shape
    for y in range(len(right)):
        pair = 0
        for i in range(slots):
            for n in range(count):
                for x in range(w):
                    right[y, i, n, x] += scale * equations.right[y, i, n, x]
            for j in range(i + 1):
                for k in range(len(CELLS)):
                    for x in range(w):
                        matrix[y, i, j, CELLS[k], x] += equations.matrix[y, pair, k, x]
                pair += 1


def complete(matrix: NDArray[np.float32], top: int, bottom: int) -> None:
    """The other couplings of rows ``(h, R, R, 9, w)``: they are the same from both sides."""
    rows, above = matrix[top:bottom], matrix[max(top - 1, 0) : bottom - 1]
    below = rows[len(rows) - len(above) :]
    rows[:, :, :, 3, 1:] = rows[:, :, :, 5, :-1]
    rows[:, :, :, 6, 1:] = rows[:, :, :, 8, :-1]
    below[:, :, :, 1] = above[:, :, :, 7]
    below[:, :, :, 0, 1:] = above[:, :, :, 8, :-1]
    below[:, :, :, 2, :-1] = above[:, :, :, 8, :-1]
    for i in range(matrix.shape[1]):
        for j in range(i):
            rows[:, j, i] = rows[:, i, j]
