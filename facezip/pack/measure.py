"""How far reconstructed textures are from the originals."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from facezip.character.samples import Stored, samples_of, texel_scale
from facezip.character.scans import Character
from facezip.machine.progress import track
from facezip.machine.rows import by_rows, map_rows, sum_rows
from facezip.pack.model import CompressedTextures
from facezip.pack.quantise import ZERO
from facezip.pack.sampling import RUN, Grid, bilinear_grid, expand_rows, mix_rows, read_run
from facezip.pack.version_1 import read_stored, verify_pack


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
    steps = np.ones((len(model.differences), model.neutral.shape[2]), np.float32)
    plain = Encoded(model.neutral, np.float32(1), model.differences, np.float32(0), steps)
    return _errors(character, plain, model.weights, model.expressions)


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
    steps = maps.difference_scale / np.float32(255)
    encoded = Encoded(maps.neutral, unit, maps.differences, np.float32(ZERO), steps)
    return _errors(character, encoded, maps.weight_values, manifest.expressions)


def _errors(
    character: Character, encoded: Encoded, weights: NDArray[np.float32], expressions: tuple[str, ...]
) -> dict[str, float]:
    names = character.expressions
    chosen = [expressions.index(name) for name in names]
    weights = weights.transpose(1, 3, 0, 2)
    h, slots, _, w = weights.shape
    rows = by_rows(lambda some: weights[some][:, :, chosen], (h, slots, len(chosen), w), np.float32)
    samples, grid = samples_of(character), bilinear_grid(character.resolution, (h, w))
    shared = samples.stored, samples.importance, encoded, rows, grid

    total = sum_rows(lambda top, bottom: _squared_errors(top, bottom, *shared), len(samples.importance))
    counts = map_rows(lambda top, bottom: samples.importance[top:bottom].sum(dtype=np.float64), len(samples.importance))
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


@njit(cache=True, nogil=True)
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


@njit(cache=True, nogil=True, fastmath={"contract"})
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
