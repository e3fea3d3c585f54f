"""Squared errors of textures against the scans, summed over the texels of a map on a tile."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from facezip.character.samples import Stored, samples_of
from facezip.character.scans import Stack
from facezip.machine.kernels import inner, kernel
from facezip.machine.rows import by_rows, map_rows, sum_rows
from facezip.pack.model import Part
from facezip.pack.quantise import ZERO, StoredPart
from facezip.pack.sampling import RUN, Grid, bilinear_grid, expand_rows, mix_rows, read_run


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
    upper = np.empty((slots, count, RUN), np.float32)
    lower = np.empty((slots, count, RUN), np.float32)
    weight = np.empty((slots, count, RUN), np.float32)
    original = np.empty((channels, count, RUN), np.float32)
    differences = np.empty((slots, RUN), np.float32)
    before, neutral, value = np.empty(RUN, np.float32), np.empty(RUN, np.float32), np.empty(RUN, np.float32)
    total = np.zeros(count)
    for left in range(0, width, RUN):
        run = min(RUN, width - left)
        for y in range(top, bottom):
            upper, lower = expand_rows(weights, grid, y, top, left, run, upper, lower)
            mix_rows(upper, lower, grid.rows.fraction[y], run, weight)
            read_run(stored, y, left, run, original)
            counts = importance[y, left : left + run]
            for c in range(channels):
                for x in range(run):
                    before[x] = stored.scale * np.float32(stored.neutral[y, left + x, c])
                _decode(encoded, y, left, c, run, neutral, differences)
                for n in range(count):
                    _add(neutral, differences, weight, n, run, value)
                    total[n] += _squared_gap(original[c, n], before, value, counts)
    return total


@inner()
def _decode(
    encoded: Encoded,
    y: int,
    left: int,
    c: int,
    run: int,
    neutral: NDArray[np.float32],
    differences: NDArray[np.float32],
) -> None:
    """One channel of a run: ``(RUN,)`` of the neutral, ``(R, RUN)`` of the difference textures."""
    for x in range(run):
        neutral[x] = encoded.unit * np.float32(encoded.neutral[y, left + x, c])
    for i in range(len(differences)):
        for x in range(run):
            steps = np.float32(encoded.differences[i, y, left + x, c]) - encoded.zero
            differences[i, x] = encoded.steps[i, c] * steps


@inner(fastmath={"contract"})
def _add(
    neutral: NDArray[np.float32],
    differences: NDArray[np.float32],
    weight: NDArray[np.float32],
    n: int,
    run: int,
    out: NDArray[np.float32],
) -> None:
    """Equation (1) of a run, two difference textures at a time."""
    slots = len(differences)
    for x in range(run):
        out[x] = neutral[x]
    for i in range(0, slots - 1, 2):
        for x in range(run):
            out[x] += differences[i, x] * weight[i, n, x] + differences[i + 1, x] * weight[i + 1, n, x]
    if slots % 2:
        for x in range(run):
            out[x] += differences[slots - 1, x] * weight[slots - 1, n, x]


@inner(fastmath={"contract", "reassoc"})
def _squared_gap(
    original: NDArray[np.float32],
    before: NDArray[np.float32],
    value: NDArray[np.float32],
    importance: NDArray[np.float32],
) -> np.float32:
    total = np.float32(0)
    for x in range(len(importance)):
        gap = original[x] + before[x] - min(max(value[x], np.float32(0)), np.float32(1))
        total += importance[x] * gap * gap
    return total
