"""Sixteen texels side by side, a vector of each of their numbers: where they look in weight maps, and what they hold.

A sweep goes down a texture strip by strip, so that all that it needs of one stays in the first-level cache. Buffers are
``(…, LANES)``, and vectors are read from and written to them whole; texels beside the texture count nothing.
"""

import numpy as np
from numpy.typing import NDArray

from facezip.character.samples import Stored
from facezip.machine.kernels import inner
from facezip.machine.vectors import (
    ABREAST,
    LANES,
    all_of,
    load,
    load_texels,
    minus,
    plus_product,
    store,
    times,
    totals,
)
from facezip.pack.sampling import Grid, Taps

# Of so many rows one stands for all where they count little: a divisor of a block's.
ROWS = 4


@inner()
def no_shares(columns: Taps) -> NDArray[np.float32]:
    """Room for the shares of any strip, a multiple of :data:`ABREAST`."""
    width, most = len(columns.first), 0
    for left in range(0, width, LANES):
        most = max(most, columns.second[min(left + LANES, width) - 1] - columns.first[left] + 1)
    return np.zeros(((most + ABREAST - 1) // ABREAST * ABREAST, LANES), np.float32)


def visited_strips(moving: NDArray[np.bool_], grid: Grid) -> NDArray[np.bool_]:
    """Which strips look at weight texels ``moving`` ``(h, w)``: ``(h, S)``, of rows that lie below each row of them."""
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
    """Sample row y of weight texels ``(h, R, N, w)`` at the columns of a strip: ``(R, N, LANES)``."""
    _, slots, count, w = weights.shape
    columns = min(len(shares), w - first)
    for i in range(slots):
        for n in range(count):
            total = all_of(np.float32(0))
            for q in range(columns):
                total = plus_product(total, all_of(weights[y, i, n, first + q]), load(shares, q * LANES))
            store(out, (i * count + n) * LANES, total)


@inner()
def mix_strip(upper: NDArray[np.float32], lower: NDArray[np.float32], v: np.float32, out: NDArray[np.float32]) -> None:
    """Weights between two rows of weight texels, v of the lower one: into the first R of ``out`` ``(K, N, LANES)``."""
    slots, count, _ = upper.shape
    share = all_of(v)
    for i in range(slots):
        for n in range(count):
            at = (i * count + n) * LANES
            near = load(upper, at)
            mixed = plus_product(near, share, minus(load(lower, at), near))
            store(out, (i * out.shape[1] + n) * LANES, mixed)


@inner()
def read_strip(stored: Stored, y: int, left: int, begin: int, out: NDArray[np.float32]) -> bool:
    """D_n = I_n - I_0 of a strip, into ``out[begin:]``; whether there are any. The texels must lie row by row."""
    count, _, width, channels = stored.textures.shape
    if channels == 3 and left + LANES <= width:
        scale, apart = all_of(stored.scale), out.shape[1] * LANES
        before, squares = load_texels(stored.neutral, (y * width + left) * 3), all_of(np.float32(0))
        for n in range(count):
            here = load_texels(stored.textures, ((n * stored.textures.shape[1] + y) * width + left) * 3)
            for c in range(3):
                there = (begin + c) * apart + n * LANES
                change = minus(here[c], before[c])
                squares = plus_product(squares, change, change)
                store(out, there, times(scale, change))
        return totals(squares, squares, squares, squares)[0] > 0
    found = False
    for n in range(count):
        for c in range(channels):
            for x in range(LANES):
                at = min(left + x, width - 1)
                difference = np.float32(stored.textures[n, y, at, c]) - np.float32(stored.neutral[y, at, c])
                out[begin + c, n, x] = stored.scale * difference
                found |= difference != 0
    return found


@inner()
def read_importance(
    importance: NDArray[np.float32], y: int, bottom: int, left: int, little: np.float32, out: NDArray[np.float32]
) -> np.float32:
    """How much texels of a row count, ``(LANES,)``; the largest of them, 0 for a row that may be left out.

    Where four rows, or those that are left of them, count no more than ``little``, one stands for all.
    """
    begin, right = y - y % ROWS, min(left + LANES, importance.shape[1])
    end, most = min(begin + ROWS, bottom), np.float32(0)
    for row in range(begin, end):
        for x in range(left, right):
            most = max(most, importance[row, x])
    factor = np.float32(1)
    if most <= little:
        factor = np.float32(end - begin) if y == begin + (end - begin) // 2 else np.float32(0)
    for x in range(LANES):
        out[x] = factor * importance[y, left + x] if left + x < right else np.float32(0)
    return factor * most


@inner()
def read_textures(textures: NDArray[np.float32], y: int, left: int, slot: int, normal: NDArray[np.float32]) -> None:
    """Textures ``(R, H, W, C)`` from ``slot`` on, to where they would be solved (:mod:`facezip.fit.cholesky`)."""
    slots, _, width, channels = textures.shape
    for i in range(slot, slots):
        for c in range(channels):
            for x in range(LANES):
                normal[i, slots + c, x] = textures[i, y, min(left + x, width - 1), c]


@inner()
def write_textures(normal: NDArray[np.float32], slot: int, y: int, left: int, out: NDArray[np.float32]) -> None:
    """Solved textures from ``slot`` on."""
    slots, (count, _, width, channels) = len(normal), out.shape
    for i in range(count):
        for x in range(min(LANES, width - left)):
            for c in range(channels):
                out[i, y, left + x, c] = normal[slot + i, slots + c, x]
