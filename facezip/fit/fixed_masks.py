"""The method of fixed masks: an expression is a few numbers a mask."""

import numpy as np
from numpy.typing import NDArray

from facezip.character.raster import BYTES_OF_NEAREST
from facezip.character.samples import thinned
from facezip.fit.activations import Bounds
from facezip.fit.given import as_bytes
from facezip.fit.masked import fit_activations
from facezip.fit.paper.masks import compute_masks
from facezip.fit.pca import principal_weights
from facezip.fit.rounding import best_differences
from facezip.fit.task import Fit, Task
from facezip.machine import memory
from facezip.pack.masked import MaskedWeights


def fixed_masks(task: Task) -> Fit:
    """Weight maps that are sums of masks, those given or the paper's, and difference textures under them."""
    character, settings, samples = task.character, task.settings, task.beside_packed
    tiles = {tile: [some for key, some in samples.items() if key[1] == tile] for tile in character.tiles}
    names, masks, bounds = _masks(task)
    components = principal_weights([thinned(some, settings.weight_scale // 2) for some in samples.values()], task.slots)
    weights = MaskedWeights(names, masks, fit_activations(tiles, masks, components, bounds))
    parts = {key: task.part(key, *best_differences(some, weights[key[1]])) for key, some in samples.items()}
    return Fit(parts, weights)


def _masks(task: Task) -> tuple[tuple[str, ...], dict[int, NDArray[np.uint8]], Bounds]:
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


def _check_memory(task: Task) -> None:
    """Before any work, for what masks hold whole: a few copies of them as bytes, and their equations."""
    given = task.given_masks
    count, scale = len(given.names) if given else task.settings.masks, task.settings.weight_scale
    texels = max(stack.neutral[..., 0].size for stack in task.character.stacks.values())
    nearest = 0 if given else BYTES_OF_NEAREST * texels
    memory.check(0, 4 * count * texels // scale**2 + 3 * 8 * (count * task.slots) ** 2 + nearest)
