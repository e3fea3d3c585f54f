"""Exposure and white balance: a factor a scan and channel, found where no expression moves, and evened out.

A gain of the light multiplies encoded values alike, nearly. All scans come to the exposure of the neutral; unless the
scans together show that the neutral's is off itself: then all come to the mean of what they have.
"""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.character.raster import rasterise
from facezip.character.scans import NEUTRAL, Character, Stack
from facezip.cleaning.cells import cells_of
from facezip.files.images import Texels
from facezip.machine.rows import by_rows

# Cells rest where a scan moves them by no more than this part of the farthest that any scan moves any vertex.
STILL = 0.03
# Where fewer than this part of the face's cells rests, as where a head was never aligned, all cells are asked.
FEWEST = 0.05
# Iterations of the reweighted least squares (Geman and McClure's weights), and their width in standard deviations.
ITERATIONS, WIDTH = 12, 2.0
# An exposure farther from the median than so many standard deviations of all is a fault, and does not count.
FAULTY = 3.0
# The neutral's is off where the mean of all is farther away than so many of its standard errors.
OFF = 2.0
# A factor is one where it moves no texel of 8 bits to another value.
LEAST = 0.5 / 255


def even_out(character: Character) -> tuple[Character, dict[str, list[float]]]:
    """Divide all colours by the gains of their scans.

    Returns
    -------
    The character; and by scan the gains over the common exposure, one a channel, of those that were changed. Those of
    colours besides the albedo have the name of their map too, ``expr_01 makeup``.
    """
    stacks, changed = dict(character.stacks), {}
    for kind in character.maps:
        if kind.encoding != "srgb":
            continue
        tiles = character.of_map(kind.name)
        gains = _relative(_gains(character, tiles))
        if (gains == 1).all():
            continue
        for tile, stack in tiles.items():
            stacks[kind.name, tile] = _evened(stack, gains)
        of_map = "" if kind is character.maps[0] else f" {kind.name}"
        for name, one in zip((NEUTRAL, *character.expressions), gains, strict=True):
            if (one != 1).any():
                changed[f"{name}{of_map}"] = [round(float(gain), 5) for gain in one]
    return (replace(character, stacks=stacks) if changed else character), changed


def _gains(character: Character, tiles: dict[int, Stack]) -> NDArray[np.float64]:
    """``(N, C)``: every scan's exposure over the neutral's."""
    neutrals, scans, moved = [], [], []
    lengths = np.linalg.norm(character.meshes.deltas, axis=2).T
    for tile, stack in tiles.items():
        cells = cells_of(stack)
        raster = rasterise(character.chart(tile), cells.face.shape).dilated()
        neutrals.append(cells.neutral[cells.face])
        scans.append(cells.scans[:, cells.face])
        moved.append(raster.interpolate(np.ascontiguousarray(lengths, np.float32))[cells.face])
    neutral, values, reach = np.concatenate(neutrals), np.concatenate(scans, axis=1), np.concatenate(moved)
    still = reach <= STILL * float(lengths.max(initial=0))
    still[:, still.mean(axis=0) < FEWEST] = True
    return np.array([_gain(neutral[rests], scan[rests]) for scan, rests in zip(values, still.T, strict=True)])


def _gain(neutral: NDArray[np.float32], scan: NDArray[np.float32]) -> NDArray[np.float64]:
    """``(C,)``, of cells ``(K, C)``; flushes and shadows, which are not the light's, hardly count."""
    one, other = neutral.astype(np.float64), scan.astype(np.float64)
    gain = np.median(other / np.maximum(one, LEAST), axis=0)
    for _ in range(ITERATIONS):
        residual = other - gain * one
        width = WIDTH * 1.4826 * np.median(np.abs(residual), axis=0) + LEAST / 10
        weight = one / (1 + (residual / width) ** 2) ** 2
        gain = np.sum(weight * other, axis=0) / np.maximum(np.sum(weight * one, axis=0), LEAST)
    return gain


def _relative(gains: NDArray[np.float64]) -> NDArray[np.float64]:
    """``(1 + N, C)``, the neutral's first: over the common exposure, and 1 where there is nothing to see."""
    logs = np.log(np.concatenate([np.ones((1, gains.shape[1])), np.maximum(gains, LEAST)]))
    logs[(np.abs(np.expm1(logs)) < LEAST).all(axis=1)] = 0
    apart = np.abs(logs - np.median(logs, axis=0)).max(axis=1)
    sound = apart <= FAULTY * 1.4826 * np.median(apart)
    mean, spread = logs[sound].mean(axis=0), logs[sound].std(axis=0)
    if np.square(mean).sum() <= OFF**2 * np.square(spread).sum() / np.count_nonzero(sound):
        mean = np.zeros_like(mean)
    over = np.exp(logs - mean)
    over[(np.abs(over - 1) < LEAST).all(axis=1)] = 1
    return over


def _evened(stack: Stack, gains: NDArray[np.float64]) -> Stack:
    given = stack.textures
    textures = by_rows(lambda rows: given[:, rows], given.shape, given.dtype, axis=1)
    for texture, gain in zip(textures, gains[1:], strict=True):
        if (gain != 1).any():
            texture[...] = _divided(texture, gain, float(stack.scale))
    neutral = stack.neutral if (gains[0] == 1).all() else _divided(stack.neutral, gains[0], float(stack.scale))
    return replace(stack, neutral=neutral, textures=textures)


def _divided(texels: Texels, gain: NDArray[np.float64], scale: float) -> Texels:
    factor = (1 / gain).astype(np.float32)

    def rows(some: slice) -> Texels:
        return stored(texels[some] * factor, texels.dtype, scale)

    return by_rows(rows, texels.shape, texels.dtype)


def stored(values: NDArray[np.float32], dtype: np.dtype[Any], scale: float) -> Texels:
    """Values in steps of ``scale`` as texels: rounded where those are whole numbers, and clipped to [0, 1]."""
    clipped = np.clip(values, 0, 1 / np.float32(scale))
    return (clipped if dtype.kind == "f" else np.rint(clipped)).astype(dtype)
