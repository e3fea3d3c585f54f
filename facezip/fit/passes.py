"""What :mod:`facezip.fit.sweep` compiles: passes over a block of rows of texels, strip by strip, from the top down.

Of a strip up to :data:`AT_ONCE` rows of texels are taken together that lie between the same two rows of weight texels.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from facezip.character.samples import Stored
from facezip.files.images import Texels
from facezip.fit.accumulation import accumulate_rows, no_sums
from facezip.fit.cholesky import add_up, factor, no_normal, round_strip, substitute
from facezip.fit.equations import Equations, Shared, collect_row, no_shared, spread_shares
from facezip.machine.kernels import inner, kernel
from facezip.machine.vectors import LANES, load, minus, room, store
from facezip.pack.sampling import Grid, rows_between
from facezip.pack.strips import (
    WIDE,
    expand_strip,
    find_shares,
    most_columns,
    no_tile,
    read_importance,
    read_textures,
    read_tile,
    says_anything,
    start_of,
    write_textures,
)

# Rows of texels that are taken together: their sums stay in registers.
AT_ONCE = 8


class _Strip(NamedTuple):
    """What a pass holds of a strip (:mod:`facezip.pack.strips`).

    Attributes
    ----------
    upper, lower, change : ``(N, P, LANES)``, weights of both rows, and how much larger the lower one's are.
    starts : ``(AT_ONCE,)``, where each row's texels start in the tile.
    fractions : ``(AT_ONCE,)``, the share v of the lower row of weight texels.
    importances : ``(AT_ONCE, LANES)``.
    normal : ``(AT_ONCE, P, K, LANES)`` (:mod:`facezip.fit.cholesky`).
    """

    upper: NDArray[np.float32]
    lower: NDArray[np.float32]
    change: NDArray[np.float32]
    starts: NDArray[np.int64]
    fractions: NDArray[np.float32]
    importances: NDArray[np.float32]
    normal: NDArray[np.float32]


@inner()
def _strip(slots: int, channels: int, count: int) -> _Strip:
    normal = no_normal(AT_ONCE, slots, channels)
    padded = normal.shape[1]
    return _Strip(
        room(count * padded).reshape(count, padded, LANES),
        room(count * padded).reshape(count, padded, LANES),
        room(count * padded).reshape(count, padded, LANES),
        np.zeros(AT_ONCE, np.int64),
        np.zeros(AT_ONCE, np.float32),
        room(AT_ONCE).reshape(AT_ONCE, LANES),
        normal,
    )


@kernel()
def accumulate(
    top: int,
    bottom: int,
    stored: Stored,
    importance: NDArray[np.float32],
    little: np.float32,
    weights: NDArray[np.float32],
    grid: Grid,
    ridge: np.float32,
    textures: NDArray[np.float32],
    looked: NDArray[np.bool_],
    equations: Equations,
) -> None:
    """Add rows of texels to their part of the system: under ``textures``, or those that fit best where there are none.

    Parameters
    ----------
    looked : at which strips (:func:`facezip.pack.strips.looked_at`), from the block's first row of weight texels on.
    equations : from the same row on.
    """
    (_, slots, count, _), (_, _, width, channels) = weights.shape, stored.textures.shape
    columns, tile = most_columns(grid.columns), no_tile(stored, top, bottom)
    above, below, fraction = grid.rows
    shares, shared, begin = room(columns).reshape(columns, LANES), no_shared(columns), above[top]
    # Taken apart once: that counts references, which takes longer than a row of texels.
    upper, lower, change, starts, fractions, importances, normal = _strip(slots, channels, count)
    squares, products, weighted = no_sums(AT_ONCE, slots, count, channels)
    for left in range(0, width, LANES):
        if left % WIDE == 0 and looked[:, left // LANES : (left + WIDE) // LANES].any():
            read_tile(stored, top, bottom, left, tile)
        if not looked[:, left // LANES].any():
            continue
        find_shares(grid.columns, left, shares)
        spread_shares(shares, shared)
        # Of weight texels, the row whose sums go on below it; there is none yet.
        y, first, going_on = top, grid.columns.first[left], -1
        while y < bottom:
            end, row, visited = rows_between(above, below, y, bottom), above[y], False
            for start in range(y, end if looked[row - begin, left // LANES] else y, AT_ONCE):
                many = top, start, min(start + AT_ONCE, end), bottom
                rows = _read_rows(
                    many,
                    tile,
                    importance,
                    little,
                    fraction,
                    left,
                    textures,
                    starts,
                    fractions,
                    importances,
                    normal,
                )
                if rows == 0:
                    continue
                if not visited:
                    visited = True
                    if row != going_on:
                        _end(going_on, begin, first, shared, squares, products, equations)
                    if len(textures) == 0:
                        _expand(weights, row, below[y], row == going_on, first, shares, upper, lower, change)
                if len(textures) == 0:
                    add_up(rows, upper, change, fractions, tile, starts, stored.scale, normal)
                    factor(rows, slots, ridge, normal)
                    for i in range(slots - 1, -1, -1):
                        substitute(rows, i, slots, channels, normal)
                accumulate_rows(rows, slots, normal, tile, starts, importances, fractions, squares, products, weighted)
            if visited:
                collect_row(row - begin, first, shared, squares, products, equations)
                going_on = below[y]
            y = end
        _end(going_on, begin, first, shared, squares, products, equations)


@inner()
def _read_rows(
    many: tuple[int, int, int, int],
    tile: Texels,
    importance: NDArray[np.float32],
    little: np.float32,
    fraction: NDArray[np.float32],
    left: int,
    textures: NDArray[np.float32],
    starts: NDArray[np.int64],
    fractions: NDArray[np.float32],
    importances: NDArray[np.float32],
    normal: NDArray[np.float32],
) -> int:
    """Find those of some rows that say anything, and how many they are.

    Parameters
    ----------
    many : the first row of the tile, the first and the end of those to look at, and the end of the tile.
    """
    (top, first, end, bottom), rows = many, 0
    for y in range(first, end):
        if read_importance(importance, y, bottom, left, little, rows, importances) > 0:
            if len(textures) != 0:
                read_textures(textures, y, left, 0, rows, normal)
            starts[rows], fractions[rows] = start_of(tile, y - top, left), fraction[y]
            # The best textures are zero where nothing is to be said.
            if len(textures) != 0 or says_anything(tile, starts[rows]):
                rows += 1
    return rows


@inner()
def _end(
    row: int,
    begin: int,
    first: int,
    shared: Shared,
    squares: NDArray[np.float32],
    products: NDArray[np.float32],
    equations: Equations,
) -> None:
    """Share out what is left for a row of weight texels, below which nothing goes on; of none, below 0, nothing is."""
    if row >= 0:
        collect_row(row - begin, first, shared, squares, products, equations)


@inner()
def _expand(
    weights: NDArray[np.float32],
    above: int,
    below: int,
    goes_on: bool,
    first: int,
    shares: NDArray[np.float32],
    upper: NDArray[np.float32],
    lower: NDArray[np.float32],
    change: NDArray[np.float32],
) -> None:
    """The weights of two rows of weight texels, between which texels lie; whether the upper one is the lower one
    before.
    """
    if goes_on:
        for at in range(0, upper.size, LANES):
            store(upper, at, load(lower, at))
    else:
        expand_strip(weights, above, first, shares, upper)
    expand_strip(weights, below, first, shares, lower)
    for at in range(0, upper.size, LANES):
        store(change, at, minus(load(lower, at), load(upper, at)))


@kernel()
def solve(
    top: int,
    bottom: int,
    stored: Stored,
    weights: NDArray[np.float32],
    grid: Grid,
    ridge: np.float32,
    given: NDArray[np.float32],
    slot: int,
    steps: NDArray[np.float32],
    out: NDArray[np.float32],
) -> None:
    """Solve ``len(out)`` textures from ``slot`` on, under those of later slots as ``given``; where a step ``(R, C)`` is
    above 0, values are rounded to multiples of it.
    """
    (_, slots, count, _), (_, _, width, channels) = weights.shape, stored.textures.shape
    columns, tile = most_columns(grid.columns), no_tile(stored, top, bottom)
    above, below, fraction = grid.rows
    shares, end = room(columns).reshape(columns, LANES), slot + len(out)
    upper, lower, change, starts, fractions, _, normal = _strip(slots, channels, count)
    for left in range(0, width, LANES):
        if left % WIDE == 0:
            read_tile(stored, top, bottom, left, tile)
        find_shares(grid.columns, left, shares)
        y, first, before = top, grid.columns.first[left], -1
        while y < bottom:
            after = rows_between(above, below, y, bottom)
            _expand(weights, above[y], below[y], above[y] == before, first, shares, upper, lower, change)
            for start in range(y, after, AT_ONCE):
                rows = min(after - start, AT_ONCE)
                for row in range(rows):
                    starts[row] = start_of(tile, start + row - top, left)
                    fractions[row] = fraction[start + row]
                add_up(rows, upper, change, fractions, tile, starts, stored.scale, normal)
                factor(rows, slots, ridge, normal)
                for row in range(rows):
                    read_textures(given, start + row, left, end, row, normal)
                _substitute_rounded(rows, slot, end, slots, steps, normal)
                for row in range(rows):
                    write_textures(normal, row, slot, start + row, left, out)
            y, before = after, below[y]


@inner()
def _substitute_rounded(
    rows: int, slot: int, end: int, slots: int, steps: NDArray[np.float32], normal: NDArray[np.float32]
) -> None:
    channels = steps.shape[1]
    for i in range(end - 1, slot - 1, -1):
        substitute(rows, i, slots, channels, normal)
        # Rounded before those that follow are solved, so that they make up for it (Babai's nearest plane).
        for c in range(channels):
            for row in range(rows if steps[i, c] > 0 else 0):
                round_strip(steps[i, c], normal[row, i, normal.shape[1] + c])
