"""The ways to compress, by name: each fits every map on every tile in one go.

Weight maps that several maps share minimise the sum of the maps' errors, so their normal equations are sums too: of
Gram matrices for principal components and clusters, of the weights' sparse systems in the refined fit. Difference
textures are solved map by map under the shared weights. Tiles share what lives on the mesh or is one number for all:
masks and principal components; the refined weight maps of a tile are its own. One albedo on one tile is a sum of one.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import Key
from facezip.character.neutrals import as_packed
from facezip.character.raster import BYTES_OF_NEAREST
from facezip.character.samples import BESIDE_THE_FACE, Samples, thinned
from facezip.character.scans import Character, Stack
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.images import to_float
from facezip.fit.activations import Bounds
from facezip.fit.given import GivenMasks, as_bytes
from facezip.fit.importance import Importance, by_key, map_factors, weighted_samples
from facezip.fit.kept import KeptRegion
from facezip.fit.locks import Lock, of_maps
from facezip.fit.masked import fit_activations
from facezip.fit.painted import Painted, Scale, held_by, ranges_of, scales_of
from facezip.fit.paper.beam import beam_search
from facezip.fit.paper.factorise import cluster_shares, difference_textures, weight_maps
from facezip.fit.paper.fragments import cluster_fragments, masked_gram
from facezip.fit.paper.masks import compute_masks
from facezip.fit.paper.paircosts import pair_costs
from facezip.fit.paper.stitching import Stitching, search, unpermuted
from facezip.fit.pca import combine_differences, principal_weights
from facezip.fit.refine import around, at_most_one, fit_around, fit_weights
from facezip.fit.rounding import as_stored, best_differences
from facezip.fit.settings import PAPER_DIFFERENCES, Settings
from facezip.machine import memory
from facezip.pack.masked import MaskedWeights
from facezip.pack.model import CompressedTextures, Part
from facezip.pack.quantise import STEPS


def compress(
    character: Character,
    method: str = "refined",
    *,
    differences: int = 4,
    weight_scale: int = 8,
    masks: int = 53,
    restarts: int = 100,
    seed: int = 0,
    nonnegative: bool = False,
    sparse: int | None = None,
    effort: str = "default",
    given_masks: GivenMasks | None = None,
    locks: Sequence[Lock] = (),
    painted: Sequence[Painted] = (),
    kept: KeptRegion | None = None,
    importance: Importance | None = None,
    map_weights: Mapping[str, float] | None = None,
) -> CompressedTextures:
    """Fit neutrals, R difference textures of every map and N weight maps of every tile to a character (equation 1).

    Parameters
    ----------
    character : neutral and expressions.
    method : ``"refined"``, ``"paper"``, ``"paper-optimised"`` (with our search of the permutation),
        ``"paper-unpermuted"`` (its ablation), ``"pca"``, or ``"masks"`` (weight maps that are sums of fixed masks).
    differences, weight_scale, masks, restarts, seed, nonnegative, sparse, effort : see
        :class:`facezip.fit.settings.Settings`.
    given_masks : those of the method ``"masks"``; None for ``masks`` of the paper's.
    locks : difference textures that stay as they are (refined).
    painted : weight maps that stay as they are (refined, not sparse).
    kept : a region that stays as it is in an older pack, whose neutral, number of differences, size of weight maps and
        ranges the fit has (refined, not sparse, nothing locked or painted).
    importance : ``(H, W)`` ≥ 0, of the albedo's size, what a texel's squared error counts besides the mask (refined,
        masks); or one for each map and tile. Maps without one take the albedo's.
    map_weights : how much a map counts, > 0. With 1, the default, the expressions' differences of each map count alike
        in sum, whatever its units, channels and size; those with an importance of their own count by that.

    Raises
    ------
    FaceZipError
        ``BAD_VALUE`` for a setting outside its range, or what its method cannot do, ``UNKNOWN_NAME`` for the weight of
        a map that there is not, or painted weight maps of an expression or a tile, ``TOO_MANY_MASKS``;
        ``SIZE_MISMATCH`` or ``BAD_TEXELS`` for an importance that does not fit; and what
        :class:`facezip.fit.given.GivenMasks` raises.
    """
    settings = Settings(differences, weight_scale, masks, restarts, seed, nonnegative, sparse, effort)
    settings.check(method)
    images = by_key(importance, character)
    factors = map_factors(character, map_weights or {}, {name for name, _ in images})
    task = _Task(character, settings, factors, images, given_masks, tuple(locks), tuple(painted), kept)
    task.check(method)
    fit = METHODS[method](task)
    whole = character.expressions, character.maps, fit.parts, fit.weights, character.meshes, fit.weight_ranges
    return CompressedTextures(method, *whole)


@dataclass(frozen=True, eq=False)
class _Task:
    """What a method is given: ``factors`` are those of each map's squared error."""

    character: Character
    settings: Settings
    factors: Mapping[str, float]
    importance: Mapping[Key, NDArray[np.float32]]
    given_masks: GivenMasks | None
    locks: tuple[Lock, ...] = ()
    painted: tuple[Painted, ...] = ()
    kept: KeptRegion | None = None

    def check(self, method: str) -> None:
        """Raise for what is asked of a method that cannot do it, or of an expression or a tile that there is not."""
        sparse = self.settings.sparse is not None
        refusals = {
            f"given masks: method {method} takes none; use masks": self.given_masks and method != "masks",
            f"locks: method {method} takes none; use refined": self.locks and method != "refined",
            f"painted weight maps: method {method} takes none; use refined": self.painted and method != "refined",
            "painted weight maps: they say which layers an expression uses; leave sparse out": self.painted and sparse,
            f"a region to keep: method {method} keeps none; use refined": self.kept and method != "refined",
            "a region to keep: all layers and weights stay in it; leave sparse, locks and painted weight maps out": (
                self.kept and (sparse or self.locks or self.painted)
            ),
        }
        for reason in (reason for reason, holds in refusals.items() if holds):
            raise FaceZipError(ErrorCode.BAD_VALUE, reason)
        for one in self.painted:
            self.character.index(one.expression)
            self.character.tile(one.tile)

    @property
    def slots(self) -> int:
        """Difference textures: no more than there are expressions."""
        return min(self.settings.differences, len(self.character.expressions))

    @property
    def sparse(self) -> int | None:
        """How many of the slots an expression may use, where that is fewer than all."""
        sparse = self.settings.sparse
        return sparse if sparse is not None and sparse < self.slots else None

    @property
    def beside_packed(self) -> dict[Key, Samples]:
        """The texels of all maps beside their neutrals as a pack stores them, those off the face counting a little."""
        character = self.character
        return {key: self.samples(key, _as_packed(character, key), BESIDE_THE_FACE) for key in character.stacks}

    def samples(self, key: Key, stack: Stack, beside: float = 0) -> Samples:
        """The texels of a map on a tile, weighted."""
        albedos = self.importance.get((self.character.maps[0].name, key[1]))
        return weighted_samples(stack, self.factors[key[0]], self.importance.get(key, albedos), beside)

    def part(self, key: Key, differences: NDArray[np.float32], ranges: NDArray[np.float32] | None = None) -> Part:
        """Difference textures with the neutral that they belong to."""
        neutral = to_float(self.character.stacks[key].neutral)
        return Part(neutral, differences, self.character.neutral_bits[key], ranges)


class _Fit(NamedTuple):
    """Attributes as of :class:`facezip.pack.model.CompressedTextures`."""

    parts: dict[Key, Part]
    weights: Mapping[int, NDArray[np.float32]]
    weight_ranges: Mapping[int, NDArray[np.float32]] = {}


def _refined(task: _Task) -> _Fit:
    character, samples = task.character, task.beside_packed
    components = None
    if len(character.tiles) > 1 and not task.kept:
        few = [thinned(some, task.settings.weight_scale // 2) for some in samples.values()]
        components = principal_weights(few, task.slots)
    parts: dict[Key, Part] = {}
    weights: dict[int, NDArray[np.float32]] = {}
    ranges: dict[int, NDArray[np.float32]] = {}
    for tile in character.tiles:
        own = {key: some for key, some in samples.items() if key[1] == tile}
        fit = _around(task.kept, tile, own, task) if task.kept else _on_tile(task, tile, own, components)
        parts |= fit.parts
        weights |= fit.weights
        ranges |= fit.weight_ranges
    return _Fit(parts, weights, ranges)


def _on_tile(task: _Task, tile: int, samples: Mapping[Key, Samples], components: NDArray[np.float32] | None) -> _Fit:
    """The fit of a tile, around layers that are locked and weight maps that are painted."""
    settings, locks = task.settings, [lock for lock in task.locks if lock.key in samples]
    units = {lock.name: lock.unit(samples[lock.key]) for lock in locks}
    maps = [*samples.values()]
    fitted = fit_weights(
        maps,
        task.slots,
        settings.weight_scale,
        components=components,
        nonnegative=settings.nonnegative,
        locked=of_maps(locks, [*samples], units),
        sparse=task.sparse,
        effort=settings.effort,
    )
    painted, scales = [one for one in task.painted if one.tile == tile], {}
    if painted:
        scales = scales_of(painted, fitted, settings.nonnegative)
        held = held_by(painted, scales, task.character.expressions, fitted.shape, settings.nonnegative)
        textures = around(of_maps(locks, [*samples], units)) if locks else ()
        fitted = fit_around(maps, fitted, held, textures, settings.effort)
    if settings.nonnegative:
        fitted, largest = at_most_one(fitted, {slot: scale.unit for slot, scale in scales.items()})
        units = {lock.name: units[lock.name] * largest[lock.slot] for lock in locks}
        scales = {slot: Scale(np.float32(1), nonnegative=True) for slot in scales}
    ranges = {tile: ranges_of(scales, task.slots)} if scales else {}
    stored, parts = as_stored(fitted, ranges.get(tile)), {}
    for key, some, locked in zip(samples, maps, of_maps(locks, [*samples], units), strict=True):
        differences, limits = best_differences(some, stored, locked)
        for lock in locks:
            if lock.key == key:
                limits[lock.slot] = units[lock.name] * np.float32(STEPS)
        parts[key] = replace(task.part(key, differences, limits), locked=frozenset(locked))
    return _Fit(parts, {tile: stored}, ranges)


def _around(kept: KeptRegion, tile: int, samples: Mapping[Key, Samples], task: _Task) -> _Fit:
    """The fit of a tile around what is kept of an older pack."""
    held, textures = kept.held(tile, task.character.expressions), [kept.textures(key) for key in samples]
    fitted = fit_around([*samples.values()], held.values, held, textures, task.settings.effort)
    stored = as_stored(fitted, kept.ranges(tile))
    parts = {key: kept.part(key, some, stored) for key, some in samples.items()}
    return _Fit(parts, {tile: stored}, {tile: kept.ranges(tile)})


def _masked(task: _Task) -> _Fit:
    character, settings, samples = task.character, task.settings, task.beside_packed
    tiles = {tile: [some for key, some in samples.items() if key[1] == tile] for tile in character.tiles}
    names, masks, bounds = _masks(task)
    components = principal_weights([thinned(some, settings.weight_scale // 2) for some in samples.values()], task.slots)
    weights = MaskedWeights(names, masks, fit_activations(tiles, masks, components, bounds))
    parts = {key: task.part(key, *best_differences(some, weights[key[1]])) for key, some in samples.items()}
    return _Fit(parts, weights)


def _masks(task: _Task) -> tuple[tuple[str, ...], dict[int, NDArray[np.uint8]], Bounds]:
    """Names, masks ``(K, h, w)`` by tile, and the bounds of their activations."""
    character, settings, given = task.character, task.settings, task.given_masks
    first, scale = character.maps[0].name, settings.weight_scale
    _check_memory(task)
    if given is not None:
        stacks = character.of_map(first).items()
        sizes = {tile: (-(-stack.resolution[0] // scale), -(-stack.resolution[1] // scale)) for tile, stack in stacks}
        bounds = Bounds.of(given.allowed(task.slots), given.nonnegative or settings.nonnegative)
        return given.names, given.on_grids(sizes), bounds
    papers = compute_masks(character, settings.masks, settings.seed)
    names = tuple(f"mask_{k:0{len(str(settings.masks - 1))}}" for k in range(settings.masks))
    masks = {tile: as_bytes(papers[first, tile].downsampled(scale)) for tile in character.tiles}
    return names, masks, Bounds.of(np.ones((len(names), task.slots), bool), settings.nonnegative)


def _check_memory(task: _Task) -> None:
    """Before any work, for what masks hold whole: a few copies of them as bytes, and their equations."""
    given = task.given_masks
    count, scale = len(given.names) if given else task.settings.masks, task.settings.weight_scale
    texels = max(stack.neutral[..., 0].size for stack in task.character.stacks.values())
    nearest = 0 if given else BYTES_OF_NEAREST * texels
    memory.check(0, 4 * count * texels // scale**2 + 3 * 8 * (count * task.slots) ** 2 + nearest)


def _as_packed(character: Character, key: Key) -> Stack:
    """The scans beside their neutral as a pack stores it: difference textures make up for what that loses."""
    stack = character.stacks[key]
    return replace(stack, neutral=as_packed(stack.neutral, character.kind(key[0]), character.neutral_bits[key]))


def _pca(task: _Task) -> _Fit:
    stacks = task.character.stacks
    components = principal_weights([task.samples(key, stack) for key, stack in stacks.items()], task.slots)
    parts = {key: task.part(key, combine_differences(stack, components.T)) for key, stack in stacks.items()}
    uniform = np.ascontiguousarray(components[:, None, None, :])
    return _Fit(parts, dict.fromkeys(task.character.tiles, uniform))


def _stitched(task: _Task, choose: Callable[[NDArray[np.float64]], Stitching]) -> _Fit:
    character, settings = task.character, task.settings
    clusters = min(PAPER_DIFFERENCES, len(character.expressions))
    masks = compute_masks(character, settings.masks, settings.seed)

    def total(of: Callable[[Key], NDArray[np.float64]]) -> NDArray[np.float64]:
        return np.sum([task.factors[key[0]] * of(key) for key in masks], axis=0)

    labels = cluster_fragments(
        total(lambda key: masked_gram(character.stacks[key], masks[key])), clusters, settings.seed
    )
    stitching = choose(total(lambda key: pair_costs(character.stacks[key], masks[key], labels, clusters)))
    shares, alpha = cluster_shares(labels, stitching.permutation)
    first = character.maps[0].name
    weights = {tile: weight_maps(masks[first, tile], alpha, settings.weight_scale) for tile in character.tiles}
    parts = {key: task.part(key, difference_textures(character.stacks[key], masks[key], shares)) for key in masks}
    return _Fit(parts, weights)


def _paper(task: _Task) -> _Fit:
    return _stitched(task, lambda table: search(table, task.settings.restarts, task.settings.seed))


METHODS: dict[str, Callable[[_Task], _Fit]] = {
    "refined": _refined,
    "paper": _paper,
    "paper-optimised": lambda task: _stitched(task, beam_search),
    "paper-unpermuted": lambda task: _stitched(task, unpermuted),
    "pca": _pca,
    "masks": _masked,
}
