"""The paper's method step by step: each step timed, its results kept for every experiment that needs them."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from facezip.character.scans import Character
from facezip.fit.methods import PAPER_DIFFERENCES
from facezip.fit.paper.factorise import cluster_shares, difference_textures, weight_maps
from facezip.fit.paper.fragments import cluster_fragments, masked_gram
from facezip.fit.paper.masks import Masks, compute_masks
from facezip.fit.paper.paircosts import pair_costs
from facezip.fit.paper.stitching import Stitching
from facezip.pack.measure import model_errors
from facezip.pack.model import CompressedTextures
from facezip.pack.quantise import dequantise, quantise


@dataclass(frozen=True, eq=False)
class Fragments:
    """All that the paper's method has before it stitches.

    Attributes
    ----------
    character : the textures.
    masks : K masks.
    labels : ``(K, N)``, the cluster of each fragment.
    table : ``(K, K, R, R)``, the terms of equation (3).
    seconds : of the steps ``masks``, ``clustering`` (Gram matrices and k-means) and ``table``.
    """

    character: Character
    masks: Masks
    labels: NDArray[np.int32]
    table: NDArray[np.float64]
    seconds: dict[str, float]

    def stitched(self, stitching: Stitching, weight_scale: int) -> CompressedTextures:
        """Equations (5) and (6) for one permutation."""
        shares, alpha = cluster_shares(self.labels, stitching.permutation)
        return CompressedTextures(
            neutral=self.character.texture("neutral"),
            differences=difference_textures(self.character, self.masks, shares),
            weights=weight_maps(self.masks, alpha, weight_scale),
            expressions=self.character.expressions,
            method="paper",
        )


def make_fragments(character: Character, masks: int, seed: int) -> Fragments:
    """Masks, clusters and the table of stitching costs; raises ``TOO_MANY_MASKS``."""
    clusters = min(PAPER_DIFFERENCES, len(character.expressions))
    clock = Clock()
    with clock.step("masks"):
        computed = compute_masks(character, masks, seed)
    with clock.step("clustering"):
        labels = cluster_fragments(masked_gram(character, computed), clusters, seed)
    with clock.step("table"):
        table = pair_costs(character, computed, labels, clusters)
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


def stored_errors(character: Character, model: CompressedTextures) -> dict[str, float]:
    """RMSE of every expression, 0..255, of the maps as a pack stores them: 8 bits a channel."""
    bits = 8 if character.neutral.itemsize == 1 else 16
    stored = dequantise(quantise(model, bits), model.expressions, model.method, None)
    return model_errors(character, stored)
