"""A region of the face that stays as it is in an older pack, while all else is fitted anew.

Inside it textures and weights of the older pack stay, so what is blended there has the same bytes. A sampler takes four
weights about each texel, so all weights that texels of the region sample stay, some of which lie beyond its border. All
textures and weights keep the ranges that give the older pack's bytes their meaning, which bound what is fitted.

Expressions that the older pack lacks have their weights solved inside, under the textures that stay.
"""

from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import Key
from facezip.character.samples import Samples
from facezip.fit.held import Held
from facezip.fit.refine import Textures
from facezip.fit.rounding import as_fitted
from facezip.fit.sweep import solve_textures
from facezip.machine.rows import by_rows, write_rows
from facezip.pack.model import CompressedTextures, Part
from facezip.pack.quantise import STEPS, StoredTextures, StoredWeights
from facezip.pack.sampling import Taps, bilinear_grid


@dataclass(frozen=True, eq=False)
class KeptRegion:
    """What stays.

    Attributes
    ----------
    names : of the regions that it is made of.
    stored, model : the older pack as it is stored, with maps of weights, and as a reader sees it.
    inside : by map and tile, ``(H, W)``: the texels that stay.
    nonnegative : whether weights lie in 0..1.
    """

    names: tuple[str, ...]
    stored: StoredTextures
    model: CompressedTextures
    inside: dict[Key, NDArray[np.bool_]]
    nonnegative: bool

    def weights(self, tile: int) -> StoredWeights:
        """The weight maps of the older pack."""
        return self.stored.weight_maps(tile)

    def ranges(self, tile: int) -> NDArray[np.float32]:
        """Offset and span ``(2, R)`` of weight maps."""
        weights = self.weights(tile)
        return np.stack([weights.offset, weights.span])

    def held(self, tile: int, expressions: tuple[str, ...]) -> Held:
        """The weights that stay; the values of others are where a fit may start: the older pack's, or none at all."""
        weights = self.weights(tile)
        theirs = {name: n for n, name in enumerate(self.stored.expressions)}
        low, high = weights.offset, weights.offset + weights.span
        nothing, maps = np.clip(np.zeros_like(low), low, high), weights.values
        shape = (len(expressions), *maps.shape[1:])

        def values_of(rows: slice) -> NDArray[np.float32]:
            start = np.broadcast_to(nothing, maps[0, rows].shape)
            return np.stack([maps[theirs[name], rows] if name in theirs else start for name in expressions])

        values = as_fitted(by_rows(values_of, shape, np.float32, axis=1))
        sampled, old = self.sampled(tile), np.isin(expressions, self.stored.expressions)
        where = by_rows(lambda rows: sampled[rows, None, None] & old[:, None], values.shape, np.bool_)
        each = (len(low), len(expressions))
        return Held(where, values, np.broadcast_to(low[:, None], each), np.broadcast_to(high[:, None], each))

    def sampled(self, tile: int) -> NDArray[np.bool_]:
        """``(h, w)``: the weight texels of a tile that a texel of the region samples, of any map."""
        _, h, w, _ = self.weights(tile).texels.shape
        found = np.zeros((h, w), bool)
        for (_, number), inside in self.inside.items():
            if number == tile:
                grid = bilinear_grid((inside.shape[0], inside.shape[1]), (h, w))
                found |= _reached(grid.columns, _reached(grid.rows, inside, h).T, w).T
        return found

    def textures(self, key: Key) -> Textures:
        """How the textures of a map on a tile are solved around those that stay."""
        return partial(self._textures, key, steps=None)

    def part(self, key: Key, samples: Samples, weights: NDArray[np.float32]) -> Part:
        """The textures of a map, rounded in the older pack's ranges, that fit best to weights ``(N, h, w, R)``."""
        old = self.stored.parts[key]
        differences = self._textures(key, samples, as_fitted(weights), steps=old.span / np.float32(255))
        ranges = old.span.astype(np.float64) * STEPS / 255
        slots = frozenset(range(len(differences)))
        return Part(self.model.parts[key].neutral, differences, old.bits, ranges, slots, old.neutral)

    def _textures(
        self, key: Key, samples: Samples, weights: NDArray[np.float32], steps: NDArray[np.float32] | None
    ) -> NDArray[np.float32]:
        found = solve_textures(samples, weights, steps)
        inside, old = self.inside[key], self.model.parts[key].differences

        def mixed(rows: slice) -> NDArray[np.float32]:
            return np.where(inside[rows, :, None], old[:, rows], found[:, rows])

        write_rows(mixed, found, axis=1)
        return found


def _reached(taps: Taps, inside: NDArray[np.bool_], low: int) -> NDArray[np.bool_]:
    """Of ``low`` rows, or columns, of weight texels those that rows of texels ``(H, ...)`` sample."""
    found = np.zeros((low, inside.shape[1]), bool)
    for row, first, second in zip(inside, taps.first, taps.second, strict=True):
        found[first] |= row
        found[second] |= row
    return found
