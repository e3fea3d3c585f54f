"""Squared errors of textures against the scans, summed over the texels of a map on a tile."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from facezip.character.samples import Stored, samples_of
from facezip.character.scans import Stack
from facezip.machine.kernels import inner, kernel
from facezip.machine.rows import by_rows, map_rows, sum_rows
from facezip.machine.vectors import LANES, all_of, clipped, load, minus, plus, plus_product, times, totals
from facezip.pack.model import Part
from facezip.pack.quantise import ZERO, StoredPart
from facezip.pack.sampling import Grid, bilinear_grid, same_rows
from facezip.pack.strips import expand_strip, find_shares, mix_strip, no_shares, read_strip


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
    shares, counts = no_shares(grid.columns), np.empty(LANES, np.float32)
    upper, lower, weight = np.empty((3, slots, count, LANES), np.float32)
    original = np.empty((channels, count, LANES), np.float32)
    before, neutral = np.empty((2, channels, LANES), np.float32)
    differences = np.empty((channels, slots, LANES), np.float32)
    total = np.zeros(count)
    for left in range(0, width, LANES):
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
            mix_strip(upper, lower, grid.rows.fraction[y], weight)
            read_strip(stored, y, left, 0, original)
            _decode(stored, encoded, y, left, before, neutral, differences)
            for n in range(count):
                total[n] += _squared_gap(n, before, neutral, differences, weight, original, counts)
    return total


@inner()
def _decode(
    stored: Stored,
    encoded: Encoded,
    y: int,
    left: int,
    before: NDArray[np.float32],
    neutral: NDArray[np.float32],
    differences: NDArray[np.float32],
) -> None:
    """Of a strip ``(C, LANES)`` of both neutrals, and ``(C, R, LANES)`` of the difference textures."""
    channels, slots, _ = differences.shape
    last = stored.neutral.shape[1] - 1
    for c in range(channels):
        for x in range(LANES):
            at = min(left + x, last)
            before[c, x] = stored.scale * np.float32(stored.neutral[y, at, c])
            neutral[c, x] = encoded.unit * np.float32(encoded.neutral[y, at, c])
            for i in range(slots):
                steps = np.float32(encoded.differences[i, y, at, c]) - encoded.zero
                differences[c, i, x] = encoded.steps[i, c] * steps


@inner()
def _squared_gap(
    n: int,
    before: NDArray[np.float32],
    neutral: NDArray[np.float32],
    differences: NDArray[np.float32],
    weight: NDArray[np.float32],
    original: NDArray[np.float32],
    counts: NDArray[np.float32],
) -> np.float32:
    """Of expression n, between the scan and equation (1), over all channels of a strip."""
    channels, slots, _ = differences.shape
    count = original.shape[1]
    squares = all_of(np.float32(0))
    for c in range(channels):
        value = load(neutral, c * LANES)
        for i in range(slots):
            change = load(differences, (c * slots + i) * LANES)
            value = plus_product(value, change, load(weight, (i * count + n) * LANES))
        gap = minus(plus(load(original, (c * count + n) * LANES), load(before, c * LANES)), clipped(value))
        squares = plus_product(squares, gap, gap)
    squares = times(squares, load(counts, 0))
    return totals(squares, squares, squares, squares)[0]
