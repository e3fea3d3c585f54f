"""The compressed textures in memory: equation (1) for one expression, (8) and (12) for any blend."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import ALBEDO, Key, Map
from facezip.character.meshes import Meshes
from facezip.character.scans import NEUTRAL, map_named, tile_among, unknown
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.images import Texels
from facezip.machine.kernels import kernel
from facezip.machine.rows import by_rows
from facezip.names import one_form
from facezip.pack.footprint import Footprint, Texture
from facezip.pack.masked import MaskedWeights
from facezip.pack.sampling import Grid, bilinear_grid

# Blendshape weights lie within 0 and 1, and somewhat beyond where an animator exaggerates.
MAX_BLEND = 1000


@dataclass(frozen=True, eq=False)
class Part:
    """One map on one tile: a neutral and R difference textures, as texels (:class:`facezip.character.maps.Map`).

    Attributes
    ----------
    neutral : ``(H, W, C)`` float32 in [0, 1].
    differences : ``(R, H, W, C)`` float32, signed.
    bits : 8 or 16 a channel, which keep what the scans' neutral held.
    difference_range : ``(R, C)``, the largest value of a difference texture that a pack has to hold where the
        fit chose one; None for the largest there is.
    locked : slots whose values are the bytes that somebody gave, down to a byte of 0, with their range.
    packed : the neutral as a pack stores it, where it is that of one; its own rounding otherwise.
    """

    neutral: NDArray[np.float32]
    differences: NDArray[np.float32]
    bits: int = 8
    difference_range: NDArray[np.floating[Any]] | None = None
    locked: frozenset[int] = frozenset()
    packed: Texels | None = None


@dataclass(frozen=True, eq=False)
class CompressedTextures:
    """Neutrals, R difference textures of every map, and N low-resolution weight maps of every tile (equation 1).

    Attributes
    ----------
    method : what fitted them: paper, paper-optimised, paper-unpermuted, pca, refined, masks.
    expressions : N names in the order of ``weights``.
    maps : the kinds of maps, albedo first.
    parts : neutral and difference textures by map and tile.
    weights : by tile, ``(N, h, w, R)`` float32, sampled bilinearly; the maps of a tile share them. PCA is the special
        case of one texel, ``h = w = 1``; a :class:`MaskedWeights` makes them of fixed masks.
    meshes : the geometry, whose UV layout spans all tiles, or None.
    weight_ranges : by tile, offset and span ``(2, R)`` float32 of weight maps in a pack, where the fit chose them; NaN
        for a slot, or no tile, where they are the least weight and how far the largest is from it.
    """

    method: str
    expressions: tuple[str, ...]
    maps: tuple[Map, ...]
    parts: Mapping[Key, Part]
    weights: Mapping[int, NDArray[np.float32]]
    meshes: Meshes | None = None
    weight_ranges: Mapping[int, NDArray[np.float32]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Names are kept in one Unicode form, whoever makes a model."""
        object.__setattr__(self, "expressions", tuple(map(one_form, self.expressions)))

    @property
    def tiles(self) -> tuple[int, ...]:
        """UDIM numbers, ascending."""
        return tuple(sorted(self.weights))

    @property
    def masked(self) -> MaskedWeights | None:
        """The masks and activations that the weight maps are made of, where they are."""
        return self.weights if isinstance(self.weights, MaskedWeights) else None

    @property
    def footprint(self) -> Footprint:
        """Bytes and fetches at run time."""
        maps = self.masked.masks if self.masked else self.weights
        return Footprint(
            tuple(
                tuple(Texture(*self.parts[kind.name, tile].neutral.shape) for kind in self.maps) for tile in self.tiles
            ),
            tuple(maps[tile].shape[1:3] for tile in self.tiles),
            len(next(iter(self.parts.values())).differences),
            len(self.expressions),
            masks=len(self.masked.names) if self.masked else 0,
        )

    def reconstruct(self, expression: str, map: str = ALBEDO, tile: int | None = None) -> NDArray[np.float32]:
        """A map of one expression, equation (1), or of ``"neutral"``; as :meth:`blend`."""
        return self.blend({} if expression == NEUTRAL else {expression: 1.0}, map, tile)

    def blend(self, weights: Mapping[str, float], map: str = ALBEDO, tile: int | None = None) -> NDArray[np.float32]:
        """A map of a blend β, equations (8) and (12), on the first tile where none is named.

        The weight maps are combined at low resolution first, as a shader does once a frame.

        Returns
        -------
        float32: ``(H, W, C)`` encoded values clipped to [0, 1] of a colour, values of data clipped to their range, unit
        vectors ``(H, W, 3)`` of normals.

        Raises
        ------
        FaceZipError
            ``UNKNOWN_NAME`` for a name that is no expression, map or tile, ``BAD_VALUE`` for a weight outside ±1000.
        """
        kind = map_named(map, self.maps, "this pack")
        return kind.decode(self.texels(weights, (map, tile_among(tile, self.tiles, "this pack"))))

    def texels(self, weights: Mapping[str, float], key: Key) -> NDArray[np.float32]:
        """The texels ``(H, W, C)`` of a blend, float32 in [0, 1]; raises as :meth:`blend`."""
        return by_rows(self.rows_of(weights, key), self.parts[key].neutral.shape, np.float32)

    def rows_of(self, weights: Mapping[str, float], key: Key) -> Callable[[slice], NDArray[np.float32]]:
        """As :meth:`texels`, but only those rows that are asked for, so that no whole texture need be held."""
        return blended_rows(self.parts[key], self.combined(weights, key[1]))

    def combined(self, weights: Mapping[str, float], tile: int) -> NDArray[np.float32]:
        """The weight map ``(h, w, R)`` of a blend on a tile, Σ_n β_n W_n; raises as :meth:`blend`."""
        betas = np.zeros(len(self.expressions), np.float32)
        for name, weight in ((one_form(name), weight) for name, weight in weights.items()):
            if name not in self.expressions:
                raise unknown("expression", name, self.expressions, "this pack")
            if not abs(weight) <= MAX_BLEND:
                raise FaceZipError(ErrorCode.BAD_VALUE, f"weight {weight} of '{name}': must lie within ±{MAX_BLEND}")
            betas[self.expressions.index(name)] += weight
        if self.masked:
            return self.masked.combined(betas, tile)
        maps = self.weights[tile]
        total = np.zeros(maps.shape[1:], np.float32)
        for n in np.flatnonzero(betas):
            total += betas[n] * maps[n]
        return total


def blended_rows(part: Part, weights: NDArray[np.float32]) -> Callable[[slice], NDArray[np.float32]]:
    """Equation (1) with one weight map ``(h, w, R)``: gives rows ``(rows, W, C)`` of texels, clipped to [0, 1]."""
    height, width, channels = part.neutral.shape
    grid = bilinear_grid((height, width), weights.shape[:2])
    maps = part.neutral, part.differences, np.ascontiguousarray(weights)

    def blended(rows: slice) -> NDArray[np.float32]:
        out = np.empty((rows.stop - rows.start, width, channels), np.float32)
        _blend(rows.start, *maps, grid, out)
        return out

    return blended


@kernel()
def _blend(
    top: int,
    neutral: NDArray[np.float32],
    differences: NDArray[np.float32],
    weights: NDArray[np.float32],
    grid: Grid,
    out: NDArray[np.float32],
) -> None:
    slots, _, width, channels = differences.shape
    rows, columns = grid
    for y in range(top, top + len(out)):
        upper, lower, v = weights[rows.first[y]], weights[rows.second[y]], rows.fraction[y]
        for x in range(width):
            a, b, u = columns.first[x], columns.second[x], columns.fraction[x]
            for c in range(channels):
                out[y - top, x, c] = neutral[y, x, c]
            for i in range(slots):
                above = upper[a, i] + u * (upper[b, i] - upper[a, i])
                below = lower[a, i] + u * (lower[b, i] - lower[a, i])
                weight = above + v * (below - above)
                for c in range(channels):
                    out[y - top, x, c] += weight * differences[i, y, x, c]
            for c in range(channels):
                out[y - top, x, c] = min(max(out[y - top, x, c], np.float32(0)), np.float32(1))
