"""The refined method: weights in one sparse system a tile, and difference textures under them."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import Key
from facezip.character.samples import Samples, thinned
from facezip.fit.kept import KeptRegion
from facezip.fit.locks import of_maps
from facezip.fit.painted import Scale, held_by, ranges_of, scales_of
from facezip.fit.pca import principal_weights
from facezip.fit.refine import around, at_most_one, fit_around, fit_weights
from facezip.fit.rounding import as_stored, best_differences
from facezip.fit.task import Fit, Task
from facezip.pack.model import Part
from facezip.pack.quantise import STEPS


def refined(task: Task) -> Fit:
    """Weight maps of each tile, and difference textures of all maps under them."""
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
    return Fit(parts, weights, ranges)


def _on_tile(task: Task, tile: int, samples: Mapping[Key, Samples], components: NDArray[np.float32] | None) -> Fit:
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
    return Fit(parts, {tile: stored}, ranges)


def _around(kept: KeptRegion, tile: int, samples: Mapping[Key, Samples], task: Task) -> Fit:
    """The fit of a tile around what is kept of an older pack."""
    held, textures = kept.held(tile, task.character.expressions), [kept.textures(key) for key in samples]
    fitted = fit_around([*samples.values()], held.values, held, textures, task.settings.effort)
    stored = as_stored(fitted, kept.ranges(tile))
    parts = {key: kept.part(key, some, stored) for key, some in samples.items()}
    return Fit(parts, {tile: stored}, {tile: kept.ranges(tile)})
