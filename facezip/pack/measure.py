"""Squared errors of textures against the scans, summed over the texels of a map on a tile."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from facezip.character.samples import Stored, samples_of
from facezip.character.scans import Stack
from facezip.files.images import Texels
from facezip.machine.kernels import inner, kernel
from facezip.machine.rows import by_rows, map_rows, sum_rows
from facezip.machine.shuffles import totals
from facezip.machine.vectors import LANES, all_of, clipped, load, minus, plus_product, room, store, times
from facezip.pack.model import Part
from facezip.pack.quantise import ZERO, StoredPart
from facezip.pack.sampling import Grid, bilinear_grid, same_rows
from facezip.pack.strips import WIDE, expand_strip, find_shares, most_columns, no_tile, read_tile, start_of


class Encoded(NamedTuple):
    """A neutral and difference textures in the numbers that hold them, and what these stand for.

    Attributes
    ----------
    neutral : ``(H, W, C)``; the neutral is ``unit`` times it.
    unit : of the neutral.
    differences : ``(R, H, W, C)``; a difference is ``steps`` times what lies above ``zero``.
    zero : the number that stands for no difference.
    steps : ``(R, C)``.
    """

    neutral: NDArray[Any]
    unit: np.float32
    differences: NDArray[Any]
    zero: np.float32
    steps: NDArray[np.float32]


def encoded(part: Part | StoredPart) -> Encoded:
    """Colours or data, in memory or as a pack has them: bytes stay bytes."""
    if isinstance(part, Part):
        steps = np.ones((len(part.differences), part.neutral.shape[2]), np.float32)
        return Encoded(part.neutral, np.float32(1), part.differences, np.float32(0), steps)
    unit = np.float32(1 / np.iinfo(str(part.neutral.dtype)).max)
    return Encoded(part.neutral, unit, part.differences, np.float32(ZERO), part.span / np.float32(255))


def model_squares(
    stack: Stack, theirs: Encoded, weights: NDArray[np.float32], order: Sequence[int]
) -> NDArray[np.float64]:
    """``(N,)``: for every expression, Σ_p m(p) ‖I_n(p) - equation (1)‖², in one pass without any whole texture.

    Parameters
    ----------
    stack : the scans; m is their mask.
    theirs, weights : the other side; weight maps ``(N', h, w, R)``.
    order : of each expression, which of these N' is its own.
    """
    turned = weights.transpose(1, 3, 0, 2)
    h, slots, _, w = turned.shape
    rows = by_rows(lambda some: turned[some][:, :, list(order)], (h, slots, len(order), w), np.float32)
    samples, grid = samples_of(stack), bilinear_grid(stack.resolution, (h, w))
    shared = samples.stored, samples.importance, theirs, rows, grid
    return sum_rows(lambda top, bottom: _squared_errors(top, bottom, *shared), len(samples.importance))


def texture_square(stack: Stack, n: int, texels: NDArray[np.float32]) -> float:
    """Σ_p m(p) ‖I_n(p) - texels(p)‖² of expression n against ``(H, W, C)`` in [0, 1]."""
    original, weight = stack.textures[n], stack.weight

    def block(top: int, bottom: int) -> float:
        return float(_squared_error(top, bottom, original, stack.scale, texels, weight))

    return sum(map_rows(block, len(original)))


def texels_seen(stack: Stack) -> float:
    """Σ_p m(p): how many texels count."""
    if stack.mask is None:
        return float(np.prod(stack.resolution))
    mask = stack.mask
    return float(sum(map_rows(lambda top, bottom: float(mask[top:bottom].sum(dtype=np.float64)), len(mask))))


@kernel()
def _squared_error(
    top: int,
    bottom: int,
    original: NDArray[np.uint8],
    scale: np.float32,
    other: NDArray[np.float32],
    weight: NDArray[np.float32],
) -> float:
    total = 0.0
    for y in range(top, bottom):
        for x in range(original.shape[1]):
            for c in range(original.shape[2]):
                gap = scale * np.float32(original[y, x, c]) - other[y, x, c]
                total += weight[y, x] * gap * gap
    return total


@kernel()
def _squared_errors(
    top: int,
    bottom: int,
    stored: Stored,
    importance: NDArray[np.float32],
    encoded: Encoded,
    weights: NDArray[np.float32],
    grid: Grid,
) -> NDArray[np.float64]:
    count, _, width, channels = stored.textures.shape
    slots = weights.shape[1]
    columns, counts = most_columns(grid.columns), room(1)
    shares, weight = room(columns).reshape(columns, LANES), room(slots).reshape(slots, LANES)
    upper, lower = room(count * slots).reshape(count, slots, LANES), room(count * slots).reshape(count, slots, LANES)
    tile, neutral = no_tile(stored, top, bottom), room(channels).reshape(channels, LANES)
    differences = room(channels * slots).reshape(channels, slots, LANES)
    total = np.zeros(count)
    for left in range(0, width, LANES):
        if left % WIDE == 0:
            read_tile(stored, top, bottom, left, tile)
        find_shares(grid.columns, left, shares)
        first, right = grid.columns.first[left], min(left + LANES, width)
        for y in range(top, bottom):
            if y == top or not same_rows(grid.rows, y, y - 1):
                expand_strip(weights, grid.rows.first[y], first, shares, upper)
                expand_strip(weights, grid.rows.second[y], first, shares, lower)
            most = np.float32(0)
            for x in range(LANES):
                counts[x] = importance[y, left + x] if left + x < right else np.float32(0)
                most = max(most, counts[x])
            if most == 0:
                continue
            _decode(encoded, y, left, neutral, differences)
            start = start_of(tile, y - top, left)
            for n in range(count):
                _mix(n, upper, lower, grid.rows.fraction[y], weight)
                total[n] += _squared_gap(n, tile, start, stored.scale, neutral, differences, weight, counts)
    return total


@inner()
def _mix(
    n: int, upper: NDArray[np.float32], lower: NDArray[np.float32], v: np.float32, weight: NDArray[np.float32]
) -> None:
    """Weights ``(R, LANES)`` between two rows of weight texels, v of the lower one."""
    at, share = n * len(weight) * LANES, all_of(v)
    for i in range(0, len(weight) * LANES, LANES):
        near = load(upper, at + i)
        store(weight, i, plus_product(near, share, minus(load(lower, at + i), near)))


@inner()
def _decode(
    encoded: Encoded,
    y: int,
    left: int,
    neutral: NDArray[np.float32],
    differences: NDArray[np.float32],
) -> None:
    """Of a strip ``(C, LANES)`` of the neutral, and ``(C, R, LANES)`` of the difference textures."""
    channels, slots, _ = differences.shape
    last = encoded.neutral.shape[1] - 1
    for c in range(channels):
        for x in range(LANES):
            at = min(left + x, last)
            neutral[c, x] = encoded.unit * np.float32(encoded.neutral[y, at, c])
            for i in range(slots):
                steps = np.float32(encoded.differences[i, y, at, c]) - encoded.zero
                differences[c, i, x] = encoded.steps[i, c] * steps


@inner()
def _squared_gap(
    n: int,
    tile: Texels,
    start: int,
    scale: np.float32,
    neutral: NDArray[np.float32],
    differences: NDArray[np.float32],
    weight: NDArray[np.float32],
    counts: NDArray[np.float32],
) -> np.float32:
    """Of expression n, between the scan and equation (1), over all channels of a strip, which starts with
    number ``start`` of a tile.
    """
    channels, slots, _ = differences.shape
    squares, unit = all_of(np.float32(0)), all_of(scale)
    for c in range(channels):
        value = load(neutral, c * LANES)
        for i in range(slots):
            change = load(differences, (c * slots + i) * LANES)
            value = plus_product(value, change, load(weight, i * LANES))
        original = load(tile, start + ((1 + n) * channels + c) * LANES)
        gap = minus(times(unit, original), clipped(value))
        squares = plus_product(squares, gap, gap)
    squares = times(squares, load(counts, 0))
    return totals(squares, squares, squares, squares)[0]
