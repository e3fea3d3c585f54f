"""Squared errors of textures against the scans, summed over the texels of a map on a tile."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from facezip.character.samples import samples_of
from facezip.character.scans import Stack
from facezip.files.images import Texels
from facezip.fit.runs import RUN, expand_row, mix_rows, read_run
from facezip.machine.rows import by_rows, map_rows, sum_rows
from facezip.pack.model import Part, bilinear_taps
from facezip.pack.quantise import ZERO, StoredPart


@dataclass(frozen=True, eq=False)
class Layers:
    """Neutral and differences in any type, with what turns them into values.

    Attributes
    ----------
    neutral : ``(H, W, C)``, times ``unit``.
    differences : ``(R, H, W, C)``, less ``zero``, times ``steps`` ``(R, C)``.
    """

    neutral: Texels
    unit: np.float32
    differences: Texels
    zero: np.float32
    steps: NDArray[np.float32]

    @classmethod
    def of(cls, part: Part | StoredPart) -> "Layers":
        """Of colours or data, in memory or as a pack has them: bytes stay bytes."""
        if isinstance(part, Part):
            steps = np.ones((len(part.differences), part.neutral.shape[2]), np.float32)
            return cls(part.neutral, np.float32(1), part.differences, np.float32(0), steps)
        unit = np.float32(1 / np.iinfo(str(part.neutral.dtype)).max)
        return cls(part.neutral, unit, part.differences, np.float32(ZERO), part.span / np.float32(255))


def model_squares(
    stack: Stack, layers: Layers, weights: NDArray[np.float32], order: Sequence[int]
) -> NDArray[np.float64]:
    """``(N,)``: for every expression, Σ_p m(p) ‖I_n(p) - equation (1)‖², in one pass without any whole texture.

    Parameters
    ----------
    stack : the scans; m is their mask.
    layers, weights : the other side; weight maps ``(N', h, w, R)``.
    order : of each expression, which of these N' is its own.
    """
    turned = weights.transpose(1, 3, 0, 2)
    h, slots, _, w = turned.shape
    rows = by_rows(lambda some: turned[some][:, :, list(order)], (h, slots, len(order), w), np.float32)
    height, width = stack.resolution
    taps = *bilinear_taps(height, h), *bilinear_taps(width, w)
    samples = samples_of(stack)
    stored = samples.textures, samples.neutral, samples.scale, samples.importance
    values = layers.neutral, layers.unit, layers.differences, layers.zero, layers.steps, rows
    return sum_rows(lambda top, bottom: _squared_errors(top, bottom, *stored, *values, *taps), height)


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


@njit(cache=True, nogil=True)
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


@njit(cache=True, nogil=True)
def _squared_errors(
    top: int,
    bottom: int,
    textures: NDArray[np.uint8],
    base: NDArray[np.uint8],
    scale: np.float32,
    importance: NDArray[np.float32],
    neutral: NDArray[Any],
    unit: np.float32,
    differences: NDArray[Any],
    zero: np.float32,
    steps: NDArray[np.float32],
    weights: NDArray[np.float32],
    row0: NDArray[np.int64],
    row1: NDArray[np.int64],
    row_f: NDArray[np.float32],
    column0: NDArray[np.int64],
    column1: NDArray[np.int64],
    column_f: NDArray[np.float32],
) -> NDArray[np.float64]:
    count, _, width, channels = textures.shape
    slots = weights.shape[1]
    upper = np.empty((slots, count, RUN), np.float32)
    lower = np.empty((slots, count, RUN), np.float32)
    weight = np.empty((slots, count, RUN), np.float32)
    original = np.empty((channels, count, RUN), np.float32)
    offsets = np.empty((slots, RUN), np.float32)
    before, start, value = np.empty(RUN, np.float32), np.empty(RUN, np.float32), np.empty(RUN, np.float32)
    total = np.zeros(count)
    for left in range(0, width, RUN):
        run = min(RUN, width - left)
        for y in range(top, bottom):
            if y == top or row0[y] != row0[y - 1] or row1[y] != row1[y - 1]:
                expand_row(weights[row0[y]], column0, column1, column_f, left, run, upper)
                expand_row(weights[row1[y]], column0, column1, column_f, left, run, lower)
            mix_rows(upper, lower, row_f[y], run, weight)
            read_run(textures, base, scale, y, left, run, original)
            counts = importance[y, left : left + run]
            for c in range(channels):
                for x in range(run):
                    before[x] = scale * np.float32(base[y, left + x, c])
                    start[x] = unit * np.float32(neutral[y, left + x, c])
                for i in range(slots):
                    for x in range(run):
                        offsets[i, x] = steps[i, c] * (np.float32(differences[i, y, left + x, c]) - zero)
                for n in range(count):
                    _add(start, offsets, weight, n, run, value)
                    total[n] += _squared_gap(original[c, n], before, value, counts)
    return total


@njit(cache=True, nogil=True, fastmath={"contract"})
def _add(
    start: NDArray[np.float32],
    offsets: NDArray[np.float32],
    weight: NDArray[np.float32],
    n: int,
    run: int,
    out: NDArray[np.float32],
) -> None:
    """Equation (1) of a run, two difference textures at a time."""
    slots = len(offsets)
    for x in range(run):
        out[x] = start[x]
    for i in range(0, slots - 1, 2):
        for x in range(run):
            out[x] += offsets[i, x] * weight[i, n, x] + offsets[i + 1, x] * weight[i + 1, n, x]
    if slots % 2:
        for x in range(run):
            out[x] += offsets[slots - 1, x] * weight[slots - 1, n, x]


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc"})
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
