"""Sums over the texels of strips, of which the weight maps' equations are made (:mod:`facezip.fit.equations`).

Up to eight rows of texels at once are added: what they have in common stays in registers, and in the first-level cache.
"""

from typing import NamedTuple

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
    plus,
    plus_product,
    room,
    store,
    times,
)


class Sums(NamedTuple):
    """Sums of a strip over the rows of texels between two rows of weight texels; v is the share of the lower one.

    Attributes
    ----------
    squares : ``(3, Q, LANES)``, of m ⟨D_i, D_j⟩ times 1, v and v²; Q is the R(R+1)/2 pairs i ≥ j, or the next
        multiple of :data:`ABREAST`.
    products : ``(2, N, P, LANES)``, of m ⟨D_i, d_n⟩, times 1 and v; P is R or the next multiple.
    weighted : ``(rows, C, P, LANES)``, room for m D_i; C is a multiple of three, of which the last may be zero.
    """

    squares: NDArray[np.float32]
    products: NDArray[np.float32]
    weighted: NDArray[np.float32]


@inner()
def no_sums(rows: int, slots: int, count: int, channels: int) -> Sums:
    """Sums of nothing, for R ``slots`` and N = ``count`` expressions."""
    padded = (slots + ABREAST - 1) // ABREAST * ABREAST
    pairs = (slots * (slots + 1) // 2 + ABREAST - 1) // ABREAST * ABREAST
    triples = (channels + 2) // 3 * 3
    return Sums(
        room(3 * pairs).reshape(3, pairs, LANES),
        room(2 * count * padded).reshape(2, count, padded, LANES),
        room(rows * triples * padded).reshape(rows, triples, padded, LANES),
    )


@inner()
def accumulate_rows(
    rows: int,
    slots: int,
    normal: NDArray[np.float32],
    tile: Texels,
    starts: NDArray[np.int64],
    importances: NDArray[np.float32],
    shares: NDArray[np.float32],
    squares: NDArray[np.float32],
    products: NDArray[np.float32],
    weighted: NDArray[np.float32],
) -> None:
    """Add rows of texels to :class:`Sums`, one array apart from the other: taking them apart here takes its time.

    Parameters
    ----------
    rows, slots : how many, and R.
    normal : their textures are ``normal[:, :, P:]`` (:mod:`facezip.fit.cholesky`).
    tile, starts : their texels (:func:`facezip.pack.strips.read_tile`), and which number of them is each row's first.
    importances : ``(rows, LANES)``.
    shares : v, ``(rows,)``.
    """
    (_, padded, columns, _), triples = normal.shape, weighted.shape[1]
    for row in range(rows):
        counts = load(importances, row * LANES)
        for c in range(tile.shape[3]):
            for i in range(slots):
                texture = load(normal, ((row * padded + i) * columns + padded + c) * LANES)
                store(weighted, ((row * triples + c) * padded + i) * LANES, times(counts, texture))
    _add_squares(rows, slots, tile.shape[3], normal, shares, weighted, squares)
    _add_products(rows, tile, starts, shares, weighted, products)


@inner()
def _add_squares(
    rows: int,
    slots: int,
    channels: int,
    normal: NDArray[np.float32],
    shares: NDArray[np.float32],
    weighted: NDArray[np.float32],
    squares: NDArray[np.float32],
) -> None:
    _, padded, columns, _ = normal.shape
    pair, apart, triples = 0, squares.shape[1] * LANES, weighted.shape[1]
    for i in range(slots):
        for j in range(i + 1):
            once, lower, twice = load(squares, pair), load(squares, pair + apart), load(squares, pair + 2 * apart)
            for row in range(rows):
                total, v = all_of(np.float32(0)), all_at(shares, row)
                for c in range(channels):
                    one = load(weighted, ((row * triples + c) * padded + i) * LANES)
                    other = load(normal, ((row * padded + j) * columns + padded + c) * LANES)
                    total = plus_product(total, one, other)
                below = times(v, total)
                once, lower, twice = plus(once, total), plus(lower, below), plus_product(twice, v, below)
            store(squares, pair, once)
            store(squares, pair + apart, lower)
            store(squares, pair + 2 * apart, twice)
            pair += LANES


@inner()
def _add_products(
    rows: int,
    tile: Texels,
    starts: NDArray[np.int64],
    shares: NDArray[np.float32],
    weighted: NDArray[np.float32],
    products: NDArray[np.float32],
) -> None:
    """Four slots at a time: their sums stay in registers over all rows."""
    (_, count, padded, _), triples = products.shape, weighted.shape[1]
    below, apart, size = count * padded * LANES, padded * LANES, tile.shape[3] * LANES
    for n in range(count):
        for i in range(0, padded, ABREAST):
            at = (n * padded + i) * LANES
            once, lower = load_abreast(products, at), load_abreast(products, at + below)
            # Three channels at a time: where there are fewer, the others' textures are zero.
            for c in range(0, triples, 3):
                for row in range(rows):
                    neutral = starts[row] + c * LANES
                    difference = minus(_texel(tile, neutral + (1 + n) * size), _texel(tile, neutral))
                    texture = ((row * triples + c) * padded + i) * LANES
                    total = times(difference[0], load_abreast(weighted, texture))
                    total = plus_product(total, difference[1], load_abreast(weighted, texture + apart))
                    total = plus_product(total, difference[2], load_abreast(weighted, texture + 2 * apart))
                    once, lower = plus(once, total), plus_product(lower, all_at(shares, row), total)
            store(products, at, once)
            store(products, at + below, lower)


@inner()
def _texel(tile: Texels, at: int) -> tuple[float, float, float]:
    return load(tile, at), load(tile, at + LANES), load(tile, at + 2 * LANES)
