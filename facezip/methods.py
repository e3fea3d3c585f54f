"""The ways to compress a character, by name."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from facezip.baselines import principal_components
from facezip.beam import beam_search
from facezip.character import Character
from facezip.errors import ErrorCode, FaceZipError
from facezip.factorise import cluster_shares, difference_textures, weight_maps
from facezip.fragments import cluster_fragments, masked_gram
from facezip.masks import compute_masks
from facezip.model import CompressedTextures, Meshes
from facezip.paircosts import pair_costs
from facezip.ranges import MAX_DIFFERENCES
from facezip.refine import refine
from facezip.stitching import Stitching, search, unpermuted

WEIGHT_SCALES = (4, 8, 16, 32)
PAPER_DIFFERENCES = 4


@dataclass(frozen=True, eq=False)
class Settings:
    """What a method may be told.

    Attributes
    ----------
    differences : number R of difference textures, 1 to 8.
    weight_scale : how many times smaller weight maps are than textures: 4, 8, 16 or 32.
    masks : number of masks on the face region (paper).
    restarts : random starts of the stitching (paper; not its variants).
    seed : of every random choice.
    importance : ``(H, W)`` ≥ 0, what a texel's squared error counts besides the mask (refined); None for 1 everywhere.
    """

    differences: int = 4
    weight_scale: int = 8
    masks: int = 53
    restarts: int = 100
    seed: int = 0
    importance: NDArray[np.float32] | None = None

    def check(self) -> None:
        """Raise ``BAD_VALUE`` for the first setting outside its range."""
        ranges = {
            "differences": (1, MAX_DIFFERENCES),
            "masks": (1, 100_000),
            "restarts": (1, 1_000_000),
            "seed": (0, 2**32 - 1),
        }
        for name, (low, high) in ranges.items():
            if not low <= getattr(self, name) <= high:
                raise FaceZipError(ErrorCode.BAD_VALUE, f"{name} {getattr(self, name)}: must lie in {low}..{high}")
        if self.weight_scale not in WEIGHT_SCALES:
            raise FaceZipError(ErrorCode.BAD_VALUE, f"weight scale {self.weight_scale}: must be one of {WEIGHT_SCALES}")


def compress(
    character: Character,
    method: str = "refined",
    *,
    differences: int = 4,
    weight_scale: int = 8,
    masks: int = 53,
    restarts: int = 100,
    seed: int = 0,
    importance: NDArray[np.float32] | None = None,
) -> CompressedTextures:
    """Fit one neutral, R difference textures and N weight maps to a character's textures (equation 1).

    Parameters
    ----------
    character : neutral and expressions.
    method : ``"refined"``, ``"paper"``, ``"paper-optimised"`` (with our search of the permutation),
        ``"paper-unpermuted"`` (its ablation) or ``"pca"``.
    differences, weight_scale, masks, restarts, seed, importance : see :class:`Settings`.

    Raises
    ------
    FaceZipError
        ``BAD_VALUE`` for a setting outside its range, ``TOO_MANY_MASKS``; ``SIZE_MISMATCH`` or ``BAD_TEXELS`` for an
        importance that does not fit.
    """
    if method not in METHODS:
        raise FaceZipError(ErrorCode.BAD_VALUE, f"method '{method}': must be one of {', '.join(METHODS)}")
    settings = Settings(differences, weight_scale, masks, restarts, seed, importance)
    settings.check()
    model = METHODS[method](character, settings)
    meshes = Meshes(character.topology, character.neutral_vertices, character.vertices - character.neutral_vertices)
    return replace(model, method=method, meshes=meshes)


def _paper(character: Character, settings: Settings) -> CompressedTextures:
    return _stitched(character, settings, lambda table: search(table, settings.restarts, settings.seed))


def _paper_optimised(character: Character, settings: Settings) -> CompressedTextures:
    return _stitched(character, settings, beam_search)


def _paper_unpermuted(character: Character, settings: Settings) -> CompressedTextures:
    return _stitched(character, settings, unpermuted)


def _stitched(
    character: Character, settings: Settings, choose: Callable[[NDArray[np.float64]], Stitching]
) -> CompressedTextures:
    if settings.differences != PAPER_DIFFERENCES:
        raise FaceZipError(
            ErrorCode.BAD_VALUE,
            f"differences {settings.differences}: the paper's method makes exactly {PAPER_DIFFERENCES} textures",
        )
    clusters = min(PAPER_DIFFERENCES, len(character.expressions))
    masks = compute_masks(character, settings.masks, settings.seed)
    labels = cluster_fragments(masked_gram(character, masks), clusters, settings.seed)
    stitching = choose(pair_costs(character, masks, labels, clusters))
    shares, alpha = cluster_shares(labels, stitching.permutation)
    return CompressedTextures(
        neutral=character.texture("neutral"),
        differences=difference_textures(character, masks, shares),
        weights=weight_maps(masks, alpha, settings.weight_scale),
        expressions=character.expressions,
        method="paper",
    )


def _pca(character: Character, settings: Settings) -> CompressedTextures:
    return principal_components(character, min(settings.differences, len(character.expressions)))


def _refined(character: Character, settings: Settings) -> CompressedTextures:
    return refine(character, settings.differences, settings.weight_scale, settings.importance)


METHODS: dict[str, Callable[[Character, Settings], CompressedTextures]] = {
    "refined": _refined,
    "paper": _paper,
    "paper-optimised": _paper_optimised,
    "paper-unpermuted": _paper_unpermuted,
    "pca": _pca,
}
