"""Layers that show under an engine's rule what a pack shows: fitted texel by texel, in 8 bits.

A layer is not the neutral and a difference: engines mix linear light and unit vectors, packs add encoded values and
slopes, and both agree at weights of 0 and 1 alone. So the layers of a texel are the least squares over all expressions,
within what an image holds; they stay near the neutral and its difference where expressions leave them free.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import Map, angles
from facezip.export.fill import Fill
from facezip.export.mixing import Rule, limits, mixed_of, sampled, stored_of, unmixed
from facezip.machine import memory
from facezip.machine.kernels import kernel
from facezip.machine.progress import track
from facezip.machine.rows import BLOCK, by_rows, each_block
from facezip.pack.model import Part, blended_rows

# How much the neutral and its difference count beside an expression whose weight is 1.
PRIOR = np.float32(1e-3)
# Of coordinate descent, which ends when no value moves by more than that.
SWEEPS, STILL = 100, np.float32(1e-6)
# Half a step of 8 bits: what is less is rounding.
CUT = np.float32(0.5 / 255)


# The weight maps ``(h, w, R)`` of one blend, a pack's and an engine's.
Pair = tuple[NDArray[np.float32], NDArray[np.float32]]


@dataclass(frozen=True, eq=False)
class Layers:
    """A map as an engine holds it.

    Attributes
    ----------
    kind : of the map.
    neutral : ``(H, W, C)`` uint8, an ordinary image; normals have three channels, y down.
    pictures : R of the same.
    beyond : the share of their values inside the chart that images cannot hold, and that are cut.
    """

    kind: Map
    neutral: NDArray[np.uint8]
    pictures: tuple[NDArray[np.uint8], ...]
    beyond: float


@dataclass(frozen=True, eq=False)
class Weights:
    """The weight maps of a pack and what an engine has in their place.

    Attributes
    ----------
    pack : ``(N, h, w, R)`` float32.
    engine : ``(N, h, w, R)`` float32, in 0..1.
    """

    pack: NDArray[np.float32]
    engine: NDArray[np.float32]

    def pairs(self) -> Iterator[Pair]:
        """Both, of every expression."""
        yield from zip(self.pack, self.engine, strict=True)

    def blends(self) -> Iterator[Pair]:
        """Both, of neighbouring expressions half and half, which no layer was fitted to."""
        for (one, first), (other, second) in pairwise(self.pairs()):
            yield np.float32(0.5) * (one + other), np.float32(0.5) * (first + second)


@dataclass(frozen=True)
class LayerErrors:
    """How far what an engine shows is from what the pack shows, inside the chart.

    Of colours RMSE in units of 0..255, of normals the mean angle in degrees.

    Attributes
    ----------
    mean, per_expression : over expressions, and of each.
    blends : mean over blends of neighbours half and half; 0 where there are none.
    largest : of a texel in an expression.
    """

    mean: float
    per_expression: Mapping[str, float]
    blends: float
    largest: float


def fitted_layers(kind: Map, part: Part, weights: Weights, rule: Rule, fill: Fill) -> Layers:
    """The layers of a map under a rule."""
    height, width, channels = part.neutral.shape
    slots, size = len(part.differences), (height, width)
    neutral = by_rows(
        lambda rows: stored_of(kind, unmixed(kind, part.neutral[rows])),
        (*size, 3 if kind.is_normal else channels),
        np.uint8,
    )
    shown = [blended_rows(part, maps) for maps in weights.pack]
    shares = [sampled(maps, size) for maps in weights.engine]
    low, high = limits(kind)
    pictures: NDArray[np.uint8] = memory.empty((slots, *neutral.shape), np.uint8)

    def block(top: int, bottom: int) -> tuple[int, int]:
        """How many values are cut, and how many there are."""
        rows = slice(top, bottom)
        base, covered = mixed_of(kind, neutral[rows]), fill.covered[rows]
        alone = [np.clip(part.neutral[rows] + part.differences[i, rows], 0, 1) for i in range(slots)]
        layers = np.stack([rule.wanted(kind, texels, base) - base for texels in alone], axis=2)
        matrix = np.broadcast_to(PRIOR * np.eye(slots, dtype=np.float32), (*base.shape[:2], slots, slots)).copy()
        right = PRIOR * layers
        for blend, share in zip(shown, shares, strict=True):
            some = rule.shares(share(rows))
            matrix += some[..., :, None] * some[..., None, :]
            right += some[..., None] * (rule.wanted(kind, blend(rows), base) - base)[..., None, :]
        cut = _solve(matrix, right, np.float32(low) - base, np.float32(high) - base, covered, layers)
        for i in range(slots):
            pictures[i, rows] = stored_of(kind, base + layers[:, :, i])
        return int(cut), int(covered.sum()) * channels * slots

    blocks = list(track(each_block(block, height), f"Fitting {kind.name}", -(-height // BLOCK)))
    cut, count = (sum(numbers) for numbers in zip(*blocks, strict=True))
    return Layers(kind, fill(neutral), tuple(fill(picture) for picture in pictures), cut / count)


def layer_errors(
    layers: Layers, part: Part, weights: Weights, rule: Rule, fill: Fill, expressions: Sequence[str]
) -> LayerErrors:
    """The errors of a map, of the ``expressions`` whose weights are given and of their blends."""
    count = len(expressions)
    means, largest = _errors(layers, part, [*weights.pairs(), *weights.blends()], rule, fill)
    return LayerErrors(
        mean=float(means[:count].mean()),
        per_expression=dict(zip(expressions, means[:count].tolist(), strict=True)),
        blends=float(means[count:].mean()) if len(means) > count else 0.0,
        largest=float(largest[:count].max()),
    )


def _errors(
    layers: Layers, part: Part, pairs: Sequence[Pair], rule: Rule, fill: Fill
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Of each pair of weight maps, the mean and the largest of a texel."""
    kind, size = layers.kind, (fill.covered.shape[0], fill.covered.shape[1])
    shown = [blended_rows(part, ours) for ours, _ in pairs]
    shares = [sampled(theirs, size) for _, theirs in pairs]

    def block(top: int, bottom: int) -> NDArray[np.float64]:
        """Sums, counts and maxima ``(3, pairs)``."""
        rows = slice(top, bottom)
        base, covered = mixed_of(kind, layers.neutral[rows]), fill.covered[rows]
        changes = [mixed_of(kind, picture[rows]) - base for picture in layers.pictures]
        found = np.zeros((3, len(pairs)))
        for number, (blend, share) in enumerate(zip(shown, shares, strict=True)):
            mixed, some = base.copy(), rule.shares(share(rows))
            for i, change in enumerate(changes):
                mixed += some[..., i, None] * change
            seen, wanted = rule.shown(kind, mixed, base), kind.decode(blend(rows))
            gaps = angles(seen, wanted) if kind.is_normal else np.abs(255 * (seen - wanted))
            inside = gaps[covered]
            summed = inside if kind.is_normal else np.square(inside)
            found[:, number] = summed.sum(dtype=np.float64), inside.size, inside.max(initial=0)
        return found

    blocks = np.array(list(track(each_block(block, size[0]), "Measuring", -(-size[0] // BLOCK))))
    means = blocks[:, 0].sum(axis=0) / blocks[:, 1].sum(axis=0)
    return means if kind.is_normal else np.sqrt(means), blocks[:, 2].max(axis=0)


@kernel()
def _solve(
    matrix: NDArray[np.float32],
    right: NDArray[np.float32],
    low: NDArray[np.float32],
    high: NDArray[np.float32],
    covered: NDArray[np.bool_],
    layers: NDArray[np.float32],
) -> int:
    """Coordinate descent within bounds, from ``layers`` ``(rows, W, R, C)``: how many covered values are cut."""
    cut = 0
    for y in range(layers.shape[0]):
        for x in range(layers.shape[1]):
            for c in range(layers.shape[3]):
                for sweep in range(SWEEPS):
                    moved, beyond = np.float32(0), 0
                    for i in range(layers.shape[2]):
                        value = right[y, x, i, c]
                        for j in range(layers.shape[2]):
                            if j != i:
                                value -= matrix[y, x, i, j] * layers[y, x, j, c]
                        value /= matrix[y, x, i, i]
                        if value < low[y, x, c] - CUT or value > high[y, x, c] + CUT:
                            beyond += 1
                        value = min(max(value, low[y, x, c]), high[y, x, c])
                        moved = max(moved, abs(value - layers[y, x, i, c]))
                        layers[y, x, i, c] = value
                    if moved < STILL or sweep == SWEEPS - 1:
                        break
                if covered[y, x]:
                    cut += beyond
    return cut
