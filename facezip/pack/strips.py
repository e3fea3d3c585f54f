"""Sixteen texels side by side, a vector of each of their numbers: where they look in weight maps, and what they hold.

A sweep goes down a texture strip by strip, so that all that it needs of one stays in the first-level cache. Buffers are
``(…, LANES)``, and vectors are read from and written to them whole; texels beside the texture count nothing.

Before that, texels are copied in tiles of a few strips: lines of the cache are read whole, and many at once, while the
rows of many textures, powers of two apart, would push each other out of the cache before the next strip needs them.
"""

import numpy as np
from numpy.typing import NDArray

from facezip.character.samples import Stored
from facezip.files.images import Texels
from facezip.machine.kernels import inner, kernel
from facezip.machine.shuffles import maximum, split_texels, store_texels, totals
from facezip.machine.vectors import (
    ABREAST,
    LANES,
    all_at,
    all_of,
    larger,
    load,
    load_abreast,
    minus,
    plus_product,
    prefetch,
    store,
    times,
)
from facezip.pack.sampling import Grid, Taps

# Of so many rows one stands for all where they count little: a divisor of a block's.
ROWS = 4
# Texels side by side in a tile: of bytes, three whole lines of the cache.
WIDE = 4 * LANES
# How many rows of texels are asked for ahead of copying them: as many as the first-level cache holds of one place.
AHEAD = 6
_LINE = 64


@kernel()
def most_columns(columns: Taps) -> int:
    """In how many columns of weight texels a strip looks at most, as a multiple of :data:`ABREAST`."""
    width, most = len(columns.first), 0
    for left in range(0, width, LANES):
        most = max(most, columns.second[min(left + LANES, width) - 1] - columns.first[left] + 1)
    return (most + ABREAST - 1) // ABREAST * ABREAST


def looked_at(moving: NDArray[np.bool_], grid: Grid) -> NDArray[np.bool_]:
    """Which strips hold texels between weight texels, some of which are ``moving`` ``(h, w)``: ``(h, S)``, of the rows
    of texels below each row of those.
    """
    lefts = np.arange(0, len(grid.columns.first), LANES)
    rights = np.minimum(lefts + LANES, len(grid.columns.first)) - 1
    before = np.pad(moving, ((0, 1), (1, 0))).cumsum(axis=1, dtype=np.int64)
    found = before[:, grid.columns.second[rights] + 1] > before[:, grid.columns.first[lefts]]
    return np.ascontiguousarray(found[:-1] | found[1:])


@inner()
def find_shares(columns: Taps, left: int, shares: NDArray[np.float32]) -> None:
    """The shares ``(Q, LANES)`` that a strip's texels have in columns of weight texels, from the first of them on."""
    first = columns.first[left]
    shares[:] = 0
    for x in range(left, min(left + LANES, len(columns.first))):
        shares[columns.first[x] - first, x - left] += np.float32(1) - columns.fraction[x]
        shares[columns.second[x] - first, x - left] += columns.fraction[x]


@inner()
def expand_strip(
    weights: NDArray[np.float32], y: int, first: int, shares: NDArray[np.float32], out: NDArray[np.float32]
) -> None:
    """Sample row y of weight texels ``(h, R, N, w)`` at the columns of a strip: ``(N, R, LANES)``, or more than R."""
    (_, slots, count, w), padded = weights.shape, out.shape[1]
    for q in range(0, len(shares), ABREAST):
        share, column = load_abreast(shares, q * LANES), first + q
        # Shares in columns beside the weights are zero.
        second, third, fourth = min(column + 1, w - 1), min(column + 2, w - 1), min(column + 3, w - 1)
        for i in range(slots):
            for n in range(count):
                at, there = ((y * slots + i) * count + n) * w, (n * padded + i) * LANES
                total = load(out, there) if q > 0 else all_of(np.float32(0))
                total = plus_product(total, share[0], all_at(weights, at + min(column, w - 1)))
                total = plus_product(total, share[1], all_at(weights, at + second))
                total = plus_product(total, share[2], all_at(weights, at + third))
                total = plus_product(total, share[3], all_at(weights, at + fourth))
                store(out, there, total)


@inner()
def no_tile(stored: Stored, top: int, bottom: int) -> Texels:
    """Room for a tile ``(rows, WIDE / LANES, 1 + N, C, LANES)``: of every strip the neutral, then all expressions."""
    rows, count, channels = bottom - top, 1 + len(stored.textures), stored.neutral.shape[2]
    size = rows * count * channels * WIDE
    # Three channels are looked at, whether there are as many or not.
    numbers = np.empty(size + 2 * LANES, stored.neutral.dtype)
    numbers[size:] = 0
    return numbers[:size].reshape(rows, WIDE // LANES, count, channels, LANES)


@inner()
def read_tile(stored: Stored, top: int, bottom: int, left: int, tile: Texels) -> None:
    """Copy the texels of some rows from column ``left`` on; beside the texture the last one is repeated."""
    count, height, width, _ = stored.textures.shape
    _copy(stored.neutral.reshape(-1), 1, height, width, top, bottom, left, 0, tile)
    _copy(stored.textures.reshape(-1), count, height, width, top, bottom, left, 1, tile)


@inner()
def _copy(
    texels: Texels, count: int, height: int, width: int, top: int, bottom: int, left: int, begin: int, tile: Texels
) -> None:
    """Of so many textures ``(H, W, C)`` one after the other, from place ``begin`` of the tile on."""
    (_, strips, every, channels, _), line = tile.shape, _LINE // tile.itemsize
    # Lines begin anywhere.
    lines, flat, whole = WIDE * channels // line + 1, tile.reshape(-1), left + WIDE <= width
    for y in range(top, bottom):
        for n in range(count):
            later, row = (n + AHEAD, y) if n + AHEAD < count else (n + AHEAD - count, y + 1)
            ahead = ((later * height + row) * width + left) * channels
            for k in range(lines):
                prefetch(texels, ahead + k * line)
            at = ((n * height + y) * width + left) * channels
            for s in range(strips):
                there = (((y - top) * strips + s) * every + begin + n) * channels * LANES
                if channels == 3 and whole:
                    split_texels(texels, at, 3, flat, there, LANES)
                elif channels == 1 and whole:
                    split_texels(texels, at, 1, flat, there, LANES)
                else:
                    _copy_strip(texels, at, width - left - s * LANES, channels, there, flat)
                at += channels * LANES


@inner()
def _copy_strip(texels: Texels, at: int, many: int, channels: int, there: int, out: Texels) -> None:
    """Of 16 texels, of which ``many`` lie within the texture; where none do, the last one lies before ``at``."""
    for x in range(LANES):
        texel = at + min(x, many - 1) * channels
        for c in range(channels):
            out[there + c * LANES + x] = texels[texel + c]


@inner()
def start_of(tile: Texels, row: int, left: int) -> int:
    """Which number of a tile is the first of a strip in one of its rows, for a strip at column ``left``."""
    _, strips, all_rows, channels, _ = tile.shape
    return (row * strips + left // LANES % strips) * all_rows * channels * LANES


@inner()
def says_anything(tile: Texels, start: int) -> bool:
    """Whether any expression differs from the neutral in a strip of a tile, which begins with number ``start``."""
    _, _, all_rows, channels, _ = tile.shape
    size = channels * LANES
    for n in range(start + size, start + all_rows * size, size):
        squares = all_of(np.float32(0))
        for c in range(0, size, LANES):
            change = minus(load(tile, n + c), load(tile, start + c))
            squares = plus_product(squares, change, change)
        if totals(squares, squares, squares, squares)[0] > 0:
            return True
    return False


@inner()
def read_importance(
    importance: NDArray[np.float32],
    y: int,
    bottom: int,
    left: int,
    little: np.float32,
    row: int,
    out: NDArray[np.float32],
) -> np.float32:
    """How much texels of a row count, to ``out[row]``; the largest of them, 0 for a row that may be left out.

    Where four rows, or those that are left of them, count no more than ``little``, one stands for all.
    """
    begin, width = y - y % ROWS, importance.shape[1]
    end, many, most = min(begin + ROWS, bottom), min(LANES, width - left), np.float32(0)
    if many == LANES:
        largest = load(importance, y * width + left)
        for other in range(begin, end):
            largest = larger(largest, load(importance, other * width + left))
            prefetch(importance, other * width + left + LANES)
        most = maximum(largest)
    else:
        for other in range(begin, end):
            for x in range(left, width):
                most = max(most, importance[other, x])
    factor = np.float32(1)
    if most <= little:
        factor = np.float32(end - begin) if y == begin + (end - begin) // 2 else np.float32(0)
    if many == LANES:
        store(out, row * LANES, times(all_of(factor), load(importance, y * width + left)))
    else:
        for x in range(LANES):
            out[row, x] = factor * importance[y, left + x] if x < many else np.float32(0)
    return factor * most


@inner()
def read_textures(
    textures: NDArray[np.float32], y: int, left: int, slot: int, row: int, normal: NDArray[np.float32]
) -> None:
    """Textures ``(R, H, W, C)`` from ``slot`` on, to where they would be solved (:mod:`facezip.fit.cholesky`)."""
    (slots, height, width, channels), (_, padded, columns, _) = textures.shape, normal.shape
    for i in range(slot, slots):
        if channels == 3 and left + LANES <= width:
            there = ((row * padded + i) * columns + padded) * LANES
            split_texels(textures, ((i * height + y) * width + left) * 3, 3, normal, there, LANES)
        else:
            for c in range(channels):
                for x in range(LANES):
                    normal[row, i, padded + c, x] = textures[i, y, min(left + x, width - 1), c]


@inner()
def write_textures(
    normal: NDArray[np.float32], row: int, slot: int, y: int, left: int, out: NDArray[np.float32]
) -> None:
    """Solved textures from ``slot`` on."""
    (count, height, width, channels), (_, padded, columns, _) = out.shape, normal.shape
    for i in range(count):
        if channels == 3 and left + LANES <= width:
            at = ((row * padded + slot + i) * columns + padded) * LANES
            found = load(normal, at), load(normal, at + LANES), load(normal, at + 2 * LANES)
            store_texels(out, ((i * height + y) * width + left) * 3, found)
        else:
            for x in range(min(LANES, width - left)):
                for c in range(channels):
                    out[i, y, left + x, c] = normal[row, slot + i, padded + c, x]
