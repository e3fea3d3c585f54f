"""The weight maps' equations from the textures of strips of texels (:mod:`facezip.fit.sweep` says what they are).

The four shares of a texel in the weight texels about it are products of one along the row and one along the column. So
what lies between two rows of weight texels is summed first, column by column, and shared out to their equations once.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from facezip.fit.weights import WeightSystem
from facezip.machine.kernels import inner
from facezip.machine.vectors import ABREAST, LANES, all_of, load, minus, plus, plus_product, store, times, totals


class Sums(NamedTuple):
    """Sums of a strip over the rows of texels between two rows of weight texels; v is the share of the lower one.

    Attributes
    ----------
    squares : ``(3, R(R+1)/2, LANES)``, of m ⟨D_i, D_j⟩ for i ≥ j, times 1, v and v².
    products : ``(2, R, N, LANES)``, of m ⟨D_i, d_n⟩, times 1 and v.
    weighted : ``(C, LANES)``, room for m D_i.
    """

    squares: NDArray[np.float32]
    products: NDArray[np.float32]
    weighted: NDArray[np.float32]


@inner()
def no_sums(slots: int, count: int, channels: int) -> Sums:
    """Sums of nothing, for R ``slots`` and N = ``count`` expressions, a multiple of :data:`ABREAST`."""
    return Sums(
        np.zeros((3, slots * (slots + 1) // 2, LANES), np.float32),
        np.zeros((2, slots, count, LANES), np.float32),
        np.empty((channels, LANES), np.float32),
    )


@inner()
def accumulate_strip(
    normal: NDArray[np.float32], rows: NDArray[np.float32], importance: NDArray[np.float32], v: np.float32, sums: Sums
) -> None:
    """Add a row of texels: textures ``normal[:, R:]`` and differences ``rows[R:]`` (:mod:`facezip.fit.cholesky`),
    ``importance`` ``(LANES,)``.
    """
    squares, _, weighted = sums
    slots, all_rows, _ = normal.shape
    channels, share, counts = len(weighted), all_of(v), load(importance, 0)
    pair, once, twice = 0, squares.shape[1] * LANES, 2 * squares.shape[1] * LANES
    for i in range(slots):
        own = (i * all_rows + slots) * LANES
        for c in range(0, channels * LANES, LANES):
            store(weighted, c, times(counts, load(normal, own + c)))
        for j in range(i + 1):
            total, other = all_of(np.float32(0)), (j * all_rows + slots) * LANES
            for c in range(0, channels * LANES, LANES):
                total = plus_product(total, load(weighted, c), load(normal, other + c))
            lower = times(share, total)
            store(squares, pair, plus(load(squares, pair), total))
            store(squares, pair + once, plus(load(squares, pair + once), lower))
            store(squares, pair + twice, plus_product(load(squares, pair + twice), share, lower))
            pair += LANES
        _add_products(i, slots, rows, share, sums)


@inner()
def _add_products(i: int, slots: int, rows: NDArray[np.float32], share: float, sums: Sums) -> None:
    """Of one slot with all expressions, four at a time."""
    _, products, weighted = sums
    apart = rows.shape[1] * LANES
    below = slots * apart
    for n in range(0, apart, ABREAST * LANES):
        first = second = third = fourth = all_of(np.float32(0))
        for c in range(len(weighted)):
            value, at = load(weighted, c * LANES), (slots + c) * apart + n
            first = plus_product(first, value, load(rows, at))
            second = plus_product(second, value, load(rows, at + LANES))
            third = plus_product(third, value, load(rows, at + 2 * LANES))
            fourth = plus_product(fourth, value, load(rows, at + 3 * LANES))
        there = i * apart + n
        _add(products, there, below, first, share)
        _add(products, there + LANES, below, second, share)
        _add(products, there + 2 * LANES, below, third, share)
        _add(products, there + 3 * LANES, below, fourth, share)


@inner()
def _add(products: NDArray[np.float32], at: int, below: int, total: float, share: float) -> None:
    store(products, at, plus(load(products, at), total))
    store(products, at + below, plus_product(load(products, at + below), share, total))


@inner()
def collect_strip(
    sums: Sums, rows: tuple[int, int], first: int, shares: NDArray[np.float32], system: WeightSystem
) -> None:
    """Share the sums out to the equations of the weight texels in two ``rows``, columns from ``first`` on; begin again.

    ``shares`` are those of :func:`facezip.pack.strips.find_shares`.
    """
    _collect_products(sums.products, rows, first, shares, system.right)
    _collect_squares(sums.squares, rows, first, shares, system.matrix)
    sums.squares[:] = 0
    sums.products[:] = 0


@inner()
def _collect_products(
    products: NDArray[np.float32],
    rows: tuple[int, int],
    first: int,
    shares: NDArray[np.float32],
    right: NDArray[np.float32],
) -> None:
    _, slots, count, w = right.shape
    flat = right.reshape(-1)
    for i in range(slots):
        for n in range(count):
            at = (i * products.shape[2] + n) * LANES
            lower = load(products, at + slots * products.shape[2] * LANES)
            upper = minus(load(products, at), lower)
            above = ((rows[0] * slots + i) * count + n) * w + first
            below = ((rows[1] * slots + i) * count + n) * w + first
            for q in range(0, min(len(shares), w - first), ABREAST):
                _add_shared(upper, shares, q, w - first - q, flat, above + q)
                _add_shared(lower, shares, q, w - first - q, flat, below + q)


@inner()
def _add_shared(
    value: float, shares: NDArray[np.float32], q: int, columns: int, out: NDArray[np.float32], at: int
) -> None:
    """To four columns, or as many as there are."""
    found = totals(
        times(value, load(shares, q * LANES)),
        times(value, load(shares, (q + 1) * LANES)),
        times(value, load(shares, (q + 2) * LANES)),
        times(value, load(shares, (q + 3) * LANES)),
    )
    out[at] += found[0]
    if columns > 1:
        out[at + 1] += found[1]
    if columns > 2:
        out[at + 2] += found[2]
    if columns > 3:
        out[at + 3] += found[3]


@inner()
def _collect_squares(
    squares: NDArray[np.float32],
    rows: tuple[int, int],
    first: int,
    shares: NDArray[np.float32],
    matrix: NDArray[np.float32],
) -> None:
    """The couplings with later texels and of j ≤ i; :func:`complete` knows the others."""
    _, slots, _, _, w = matrix.shape
    flat, pairs = matrix.reshape(-1), squares.shape[1] * LANES
    for q in range(min(len(shares), w - first)):
        near = load(shares, q * LANES)
        # A texel lies between two columns: those that are further apart have none in common.
        beside = load(shares, (q + 1) * LANES) if q + 1 < len(shares) else all_of(np.float32(0))
        own, both, pair = times(near, near), times(near, beside), 0
        last = first + q + 1 == w
        for i in range(slots):
            for j in range(i + 1):
                lower, once = load(squares, 2 * pairs + pair), load(squares, pairs + pair)
                between = minus(once, lower)
                upper = minus(minus(load(squares, pair), once), between)
                pair += LANES
                here = ((rows[0] * slots + i) * slots + j) * 9 * w + first + q
                below = ((rows[1] * slots + i) * slots + j) * 9 * w + first + q
                found = totals(times(upper, own), times(upper, both), times(between, own), times(between, both))
                under = totals(times(lower, own), times(lower, both), lower, lower)
                flat[here + 4 * w] += found[0]
                flat[here + 7 * w] += found[2]
                flat[below + 4 * w] += under[0]
                if not last:
                    flat[here + 5 * w] += found[1]
                    flat[here + 8 * w] += found[3]
                    flat[here + 6 * w + 1] += found[3]
                    flat[below + 5 * w] += under[1]


def complete(matrix: NDArray[np.float32]) -> None:
    """The other couplings ``(h, R, R, 9, w)``: they are the same from both sides."""
    matrix[:, :, :, 3, 1:] = matrix[:, :, :, 5, :-1]
    matrix[1:, :, :, 1] = matrix[:-1, :, :, 7]
    matrix[1:, :, :, 0, 1:] = matrix[:-1, :, :, 8, :-1]
    matrix[1:, :, :, 2, :-1] = matrix[:-1, :, :, 6, 1:]
    for i in range(matrix.shape[1]):
        for j in range(i):
            matrix[:, j, i] = matrix[:, i, j]
