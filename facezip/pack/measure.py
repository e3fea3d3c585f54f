"""How far reconstructed textures are from the originals."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from facezip.character.samples import samples_of
from facezip.character.scans import Character
from facezip.fit.paper.fragments import texel_scale
from facezip.fit.runs import RUN, expand_row, mix_rows, read_run
from facezip.machine.progress import track
from facezip.machine.rows import by_rows, map_rows, sum_rows
from facezip.pack.model import CompressedTextures, bilinear_taps
from facezip.pack.quantise import ZERO
from facezip.pack.version_1 import read_stored, verify_pack


def texture_errors(character: Character, texture: Callable[[str], NDArray[np.float32]]) -> dict[str, float]:
    """RMSE of every expression, in units of 0..255, over channels and texels weighted by the character's mask.

    Parameters
    ----------
    character : the originals.
    texture : gives the other side, ``(H, W, C)`` float32 in [0, 1], for an expression's name.
    """
    weight = character.weight
    names = track(character.expressions, "Measuring textures", len(character.expressions))
    return {name: _rmse(character, name, texture(name), weight) for name in names}


def model_errors(character: Character, model: CompressedTextures) -> dict[str, float]:
    """:func:`texture_errors` of ``model.reconstruct``, of all expressions in one pass without any whole texture."""
    one = np.float32(1)
    steps = np.ones((len(model.differences), model.neutral.shape[2]), np.float32)
    values = model.neutral, one, model.differences, np.float32(0), steps
    return _errors(character, values, model.weights, model.expressions)


def pack_errors(character: Character, path: str | Path) -> dict[str, float]:
    """:func:`model_errors` of a pack, which is verified first; its difference textures stay the bytes that they are.

    Raises
    ------
    FaceZipError
        What :func:`facezip.pack.version_1.version_1.read_pack` raises.
    """
    manifest = verify_pack(Path(path))
    maps, _ = read_stored(Path(path), manifest)
    unit = np.float32(1 / np.iinfo(str(maps.neutral.dtype)).max)
    values = maps.neutral, unit, maps.differences, np.float32(ZERO), maps.difference_scale / np.float32(255)
    return _errors(character, values, maps.weight_values, manifest.expressions)


def _errors(
    character: Character, values: tuple[Any, ...], weights: NDArray[np.float32], expressions: tuple[str, ...]
) -> dict[str, float]:
    names = character.expressions
    chosen = [expressions.index(name) for name in names]
    weights = weights.transpose(1, 3, 0, 2)
    h, slots, _, w = weights.shape
    rows = by_rows(lambda some: weights[some][:, :, chosen], (h, slots, len(chosen), w), np.float32)
    height, width = character.resolution
    taps = *bilinear_taps(height, rows.shape[0]), *bilinear_taps(width, rows.shape[3])
    samples = samples_of(character)
    stored = samples.textures, samples.neutral, samples.scale, samples.importance, *values, rows

    total = sum_rows(lambda top, bottom: _squared_errors(top, bottom, *stored, *taps), height)
    counts = map_rows(lambda top, bottom: samples.importance[top:bottom].sum(dtype=np.float64), height)
    texels = np.sum(counts) * samples.neutral.shape[2]
    return dict(zip(names, (255 * np.sqrt(total / texels)).tolist(), strict=True))


def mean_rmse(errors: Mapping[str, float]) -> float:
    """The mean over expressions of their RMSE: one number for a character, as in the paper's Figure 6."""
    return sum(errors.values()) / len(errors)


def _rmse(character: Character, name: str, other: NDArray[np.float32], weight: NDArray[np.float32]) -> float:
    original = character.textures[character.index(name)]
    scale = texel_scale(character)

    def block(top: int, bottom: int) -> float:
        return float(_squared_error(top, bottom, original, scale, other, weight))

    total = sum(map_rows(block, len(original)))
    return float(255 * np.sqrt(total / (weight.sum(dtype=np.float64) * original.shape[2])))


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
