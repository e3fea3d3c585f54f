"""The one pass over the texels of an alternation: solve every texel's textures, add it to the weights' equations.

With the weights fixed, the R values of a texel and channel are a small linear system; its solution is at once a term of
the system that the weight maps solve next. Texels are handled in runs along a row, one value of a run beside the other,
so that every innermost loop fills vector registers.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from facezip.character.samples import Samples
from facezip.fit.runs import (
    RUN,
    accumulate_run,
    collect_run,
    expand_row,
    factor_run,
    mix_rows,
    read_run,
    solve_run,
    substitute_run,
)
from facezip.fit.weights import WeightSystem
from facezip.machine import memory
from facezip.machine.rows import each_block, map_rows
from facezip.pack.model import bilinear_taps

# Of the mean trace of a texel's system: bounds a texture where all weights are small.
RIDGE = 1e-3


def weight_system(
    samples: Samples, weights: NDArray[np.float32], textures: NDArray[np.float32] | None = None
) -> WeightSystem:
    """The system that the weight maps solve under ``textures``, or under those that fit best to ``weights``.

    Parameters
    ----------
    samples : the texels.
    weights : ``(h, R, N, w)``, sampled bilinearly.
    textures : ``(R, H, W, C)``, or None.
    """
    height = len(samples.neutral)
    first, second, _ = bilinear_taps(height, len(weights))
    system = WeightSystem.zeros(weights.shape)
    given = np.empty((weights.shape[1], 0, 0, 0), np.float32) if textures is None else textures
    pass_ = _Pass(samples, weights)

    def block(top: int, bottom: int) -> tuple[int, WeightSystem]:
        begin, end = int(first[top]), int(second[bottom - 1]) + 1
        part = WeightSystem.zeros((end - begin, *weights.shape[1:]))
        pass_.rows(top, bottom, given, _NO_STEPS, textures is not None, begin, part)
        return begin, part

    for begin, part in each_block(block, height):
        system.matrix[begin : begin + len(part.matrix)] += part.matrix
        system.right[begin : begin + len(part.right)] += part.right
    return system


def solve_textures(
    samples: Samples, weights: NDArray[np.float32], steps: NDArray[np.float32] | None = None
) -> NDArray[np.float32]:
    """The difference textures ``(R, H, W, C)`` that fit best under given weights ``(h, R, N, w)``.

    Parameters
    ----------
    samples, weights : as in :func:`weight_system`.
    steps : ``(R, C)``; where given, values are multiples of it within ±127, rounded one texture after the other so
        that those that follow make up for the rounding (Babai's nearest plane).
    """
    height, width, channels = samples.neutral.shape
    textures: NDArray[np.float32] = memory.empty((weights.shape[1], height, width, channels), np.float32)
    nothing = WeightSystem.zeros((0, 0, 0, 0))
    pass_ = _Pass(samples, weights)
    rounding = _NO_STEPS if steps is None else steps
    map_rows(lambda top, bottom: pass_.rows(top, bottom, textures, rounding, False, 0, nothing), height)
    return textures


def solve_texture(
    samples: Samples, weights: NDArray[np.float32], textures: NDArray[np.float32], slot: int
) -> NDArray[np.float32]:
    """The difference texture ``(H, W, C)`` of one slot that fits best given those of later slots, earlier ones free.

    So textures can be stored one after the other, from the last slot to the first, each making up for what storing
    lost before.

    Parameters
    ----------
    samples, weights : as in :func:`weight_system`.
    textures : ``(R, H, W, C)``, of which those after ``slot`` are read.
    """
    texture: NDArray[np.float32] = memory.empty(textures.shape[1:], np.float32)
    pass_ = _Pass(samples, weights)
    map_rows(lambda top, bottom: pass_.slot(top, bottom, textures, slot, texture), len(texture))
    return texture


_NO_STEPS = np.empty((0, 0), np.float32)


class _Pass:
    """The arguments of a pass that all its blocks of rows share."""

    def __init__(self, samples: Samples, weights: NDArray[np.float32]) -> None:
        height, width, _ = samples.neutral.shape
        h, _, _, w = weights.shape
        squares = map_rows(lambda top, bottom: np.square(weights[top:bottom]).sum(dtype=np.float64), h)
        ridge = np.float32(RIDGE * np.sum(squares) / (h * w))
        self._stored = samples.textures, samples.neutral, samples.scale, samples.importance
        self._sampled = weights, *bilinear_taps(height, h), *bilinear_taps(width, w), max(ridge, np.float32(1e-30))

    def rows(
        self,
        top: int,
        bottom: int,
        textures: NDArray[np.float32],
        steps: NDArray[np.float32],
        given: bool,
        begin: int,
        system: WeightSystem,
    ) -> None:
        """Write what is solved to ``textures`` unless it is empty or ``given``; fill the system unless it is empty."""
        _sweep(top, bottom, *self._stored, *self._sampled, textures, steps, given, begin, system.matrix, system.right)

    def slot(
        self, top: int, bottom: int, textures: NDArray[np.float32], slot: int, texture: NDArray[np.float32]
    ) -> None:
        """Write what is solved for ``slot``, with the textures of later slots as they are."""
        _sweep_slot(top, bottom, *self._stored[:3], *self._sampled, textures, slot, texture)


@njit(cache=True, nogil=True, fastmath={"contract"})
def _sweep(
    top: int,
    bottom: int,
    stored: NDArray[np.uint8],
    neutral: NDArray[np.uint8],
    scale: np.float32,
    importance: NDArray[np.float32],
    weights: NDArray[np.float32],
    row0: NDArray[np.int64],
    row1: NDArray[np.int64],
    row_f: NDArray[np.float32],
    column0: NDArray[np.int64],
    column1: NDArray[np.int64],
    column_f: NDArray[np.float32],
    ridge: np.float32,
    textures: NDArray[np.float32],
    steps: NDArray[np.float32],
    given: bool,
    begin: int,
    matrix: NDArray[np.float32],
    right: NDArray[np.float32],
) -> None:
    count, _, width, channels = stored.shape
    slots = weights.shape[1]
    pairs = slots * (slots + 1) // 2
    building = len(matrix) > 0
    upper = np.empty((slots, count, RUN), np.float32)
    lower = np.empty((slots, count, RUN), np.float32)
    weight = np.empty((slots, count, RUN), np.float32)
    differences = np.empty((channels, count, RUN), np.float32)
    normal = np.empty((slots, slots, RUN), np.float32)
    solved = np.empty((slots, channels, RUN), np.float32)
    squares = np.zeros((3, pairs, RUN), np.float32)
    products = np.zeros((2, slots, count, RUN), np.float32)
    for left in range(0, width, RUN):
        run = min(RUN, width - left)
        for y in range(top, bottom):
            if y == top or row0[y] != row0[y - 1] or row1[y] != row1[y - 1]:
                if y > top and row0[y] == row1[y - 1]:
                    upper, lower = lower, upper
                else:
                    expand_row(weights[row0[y]], column0, column1, column_f, left, run, upper)
                expand_row(weights[row1[y]], column0, column1, column_f, left, run, lower)
                squares[:] = 0
                products[:] = 0
            read_run(stored, neutral, scale, y, left, run, differences)
            if given:
                _load(textures, y, left, run, solved)
            else:
                mix_rows(upper, lower, row_f[y], run, weight)
                solve_run(weight, differences, ridge, steps, run, normal, solved)
                if textures.shape[1]:
                    _store(solved, y, left, run, textures)
            if building:
                accumulate_run(solved, differences, importance[y, left : left + run], row_f[y], squares, products)
                if y + 1 == bottom or row0[y] != row0[y + 1] or row1[y] != row1[y + 1]:
                    at = row0[y] - begin, row1[y] - begin
                    collect_run(squares, products, at, column0, column1, column_f, left, run, matrix, right)


@njit(cache=True, nogil=True, fastmath={"contract"})
def _sweep_slot(
    top: int,
    bottom: int,
    stored: NDArray[np.uint8],
    neutral: NDArray[np.uint8],
    scale: np.float32,
    weights: NDArray[np.float32],
    row0: NDArray[np.int64],
    row1: NDArray[np.int64],
    row_f: NDArray[np.float32],
    column0: NDArray[np.int64],
    column1: NDArray[np.int64],
    column_f: NDArray[np.float32],
    ridge: np.float32,
    textures: NDArray[np.float32],
    slot: int,
    texture: NDArray[np.float32],
) -> None:
    count, _, width, channels = stored.shape
    slots = weights.shape[1]
    upper = np.empty((slots, count, RUN), np.float32)
    lower = np.empty((slots, count, RUN), np.float32)
    weight = np.empty((slots, count, RUN), np.float32)
    differences = np.empty((channels, count, RUN), np.float32)
    normal = np.empty((slots, slots, RUN), np.float32)
    solved = np.empty((slots, channels, RUN), np.float32)
    for left in range(0, width, RUN):
        run = min(RUN, width - left)
        for y in range(top, bottom):
            if y == top or row0[y] != row0[y - 1] or row1[y] != row1[y - 1]:
                expand_row(weights[row0[y]], column0, column1, column_f, left, run, upper)
                expand_row(weights[row1[y]], column0, column1, column_f, left, run, lower)
            read_run(stored, neutral, scale, y, left, run, differences)
            mix_rows(upper, lower, row_f[y], run, weight)
            factor_run(weight, differences, ridge, run, normal, solved)
            _load(textures[slot + 1 :], y, left, run, solved[slot + 1 :])
            substitute_run(slot, normal, run, solved)
            _store(solved[slot : slot + 1], y, left, run, texture[None])


@njit(cache=True, nogil=True)
def _load(textures: NDArray[np.float32], y: int, left: int, run: int, out: NDArray[np.float32]) -> None:
    for i in range(len(out)):
        for c in range(out.shape[1]):
            for x in range(run):
                out[i, c, x] = textures[i, y, left + x, c]


@njit(cache=True, nogil=True)
def _store(solved: NDArray[np.float32], y: int, left: int, run: int, textures: NDArray[np.float32]) -> None:
    for i in range(len(solved)):
        for x in range(run):
            for c in range(solved.shape[1]):
                textures[i, y, left + x, c] = solved[i, c, x]
