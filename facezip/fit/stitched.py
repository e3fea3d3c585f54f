"""The paper's methods: clusters of fragments, stitched to difference textures."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import Key
from facezip.fit.paper.factorise import cluster_shares, difference_textures, weight_maps
from facezip.fit.paper.fragments import cluster_fragments, masked_gram
from facezip.fit.paper.masks import compute_masks
from facezip.fit.paper.paircosts import pair_costs
from facezip.fit.paper.stitching import Stitching, search
from facezip.fit.settings import PAPER_DIFFERENCES
from facezip.fit.task import Fit, Task


def stitched(task: Task, choose: Callable[[NDArray[np.float64]], Stitching]) -> Fit:
    """Clusters of fragments, of which ``choose`` says from the costs of pairs how they are stitched."""
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
    return Fit(parts, weights)


def paper(task: Task) -> Fit:
    """As the paper stitches them."""
    return stitched(task, lambda table: search(table, task.settings.restarts, task.settings.seed))
