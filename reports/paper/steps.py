"""The paper's method step by step: each step timed, its results kept for every experiment that needs them."""

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import Key
from facezip.character.scans import Character
from facezip.files.images import to_float
from facezip.fit.paper.factorise import cluster_shares, difference_textures, weight_maps
from facezip.fit.paper.fragments import cluster_fragments, masked_gram
from facezip.fit.paper.masks import Masks, compute_masks
from facezip.fit.paper.paircosts import pair_costs
from facezip.fit.paper.stitching import Stitching
from facezip.fit.settings import PAPER_DIFFERENCES
from facezip.pack.errors import albedo_errors
from facezip.pack.model import CompressedTextures, Part
from facezip.pack.quantise import quantise


@dataclass(frozen=True, eq=False)
class Fragments:
    """All that the paper's method has before it stitches.

    Attributes
    ----------
    character : the textures.
    masks : K masks, on every tile.
    labels : ``(K, N)``, the cluster of each fragment.
    table : ``(K, K, R, R)``, the terms of equation (3).
    seconds : of the steps ``masks``, ``clustering`` (Gram matrices and k-means) and ``table``.
    """

    character: Character
    masks: dict[Key, Masks]
    labels: NDArray[np.int32]
    table: NDArray[np.float64]
    seconds: dict[str, float]

    @property
    def mask_count(self) -> int:
        """K."""
        return len(self.labels)

    def stitched(self, stitching: Stitching, weight_scale: int) -> CompressedTextures:
        """Equations (5) and (6) for one permutation."""
        shares, alpha = cluster_shares(self.labels, stitching.permutation)
        character, first = self.character, self.character.maps[0].name
        parts = {
            key: Part(to_float(stack.neutral), difference_textures(stack, self.masks[key], shares))
            for key, stack in character.stacks.items()
        }
        weights = {tile: weight_maps(self.masks[first, tile], alpha, weight_scale) for tile in character.tiles}
        return CompressedTextures("paper", character.expressions, character.maps, parts, weights)


def make_fragments(character: Character, masks: int, seed: int) -> Fragments:
    """Masks, clusters and the table of stitching costs; raises ``TOO_MANY_MASKS``."""
    clusters = min(PAPER_DIFFERENCES, len(character.expressions))
    clock = Clock()
    with clock.step("masks"):
        computed = compute_masks(character, masks, seed)
    with clock.step("clustering"):
        grams = _total(masked_gram(stack, computed[key]) for key, stack in character.stacks.items())
        labels = cluster_fragments(grams, clusters, seed)
    with clock.step("table"):
        table = _total(pair_costs(stack, computed[key], labels, clusters) for key, stack in character.stacks.items())
    return Fragments(character, computed, labels, table, clock.seconds)


class Clock:
    """Seconds of wall time by step."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}

    @contextmanager
    def step(self, name: str) -> Iterator[None]:
        """Add what the block takes to the step ``name``."""
        begin = perf_counter()
        yield
        self.seconds[name] = self.seconds.get(name, 0.0) + perf_counter() - begin


def stored_errors(character: Character, model: CompressedTextures) -> Mapping[str, float]:
    """RMSE of every expression's albedo, 0..255, as a pack stores it: 8 bits a channel."""
    return albedo_errors(character, quantise(model))


def _total(tables: Iterable[NDArray[np.float64]]) -> NDArray[np.float64]:
    total: NDArray[np.float64] = np.sum([*tables], axis=0)
    return total
