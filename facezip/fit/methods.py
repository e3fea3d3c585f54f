"""The ways to compress, by name: each fits every map on every tile of a surface in one go.

Weight maps that several maps share minimise the sum of the maps' errors, so their normal equations are sums too: of
Gram matrices for principal components and clusters, of the weights' sparse systems in the refined fit. Difference
textures are solved map by map under the shared weights. Tiles share what lives on the mesh or is one number for all:
masks and principal components; the refined weight maps of a tile are its own. One albedo on one tile is a sum of one.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.character.neutrals import as_packed
from facezip.character.samples import BESIDE_THE_FACE, Samples, samples_of, thinned
from facezip.character.scans import Character
from facezip.character.surface import Surface
from facezip.errors import ErrorCode, FaceZipError
from facezip.fit.paper.beam import beam_search
from facezip.fit.paper.factorise import cluster_shares, difference_textures, weight_maps
from facezip.fit.paper.fragments import cluster_fragments, masked_gram
from facezip.fit.paper.masks import compute_shared_masks
from facezip.fit.paper.paircosts import pair_costs
from facezip.fit.paper.stitching import Stitching, search, unpermuted
from facezip.fit.pca import combined, principal_weights
from facezip.fit.refine import as_stored, fit_weights, solve_model
from facezip.machine.rows import by_rows
from facezip.pack.model import CompressedTextures, Meshes
from facezip.pack.ranges import MAX_DIFFERENCES

# By map and tile.
Parts = dict[tuple[str, int], CompressedTextures]

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
    settings = Settings(differences, weight_scale, masks, restarts, seed, importance)
    surface = Surface.of(character)
    (model,) = fit(surface, method, settings, {kind.name: 1.0 for kind in surface.maps}).values()
    return replace(model, meshes=meshes_of(character))


def meshes_of(character: Character) -> Meshes:
    """The neutral mesh and the displacements of the expressions."""
    return Meshes(character.topology, character.neutral_vertices, character.vertices - character.neutral_vertices)


def fit(surface: Surface, method: str, settings: Settings, weights: Mapping[str, float]) -> Parts:
    """Every map on every tile, compressed; ``weights`` are the factors of each map's squared error.

    Raises
    ------
    FaceZipError
        ``BAD_VALUE``, ``TOO_MANY_MASKS``; ``SIZE_MISMATCH`` or ``BAD_TEXELS`` for an importance that does not fit.
    """
    check(method, settings)
    return {key: replace(part, method=method) for key, part in METHODS[method](surface, settings, weights).items()}


def check(method: str, settings: Settings) -> None:
    """Raise ``BAD_VALUE`` for a method that there is not, or a setting outside its range."""
    if method not in METHODS:
        raise FaceZipError(ErrorCode.BAD_VALUE, f"method '{method}': must be one of {', '.join(METHODS)}")
    settings.check()
    if method.startswith("paper") and settings.differences != PAPER_DIFFERENCES:
        raise FaceZipError(
            ErrorCode.BAD_VALUE,
            f"differences {settings.differences}: the paper's method makes exactly {PAPER_DIFFERENCES} textures",
        )


def _weighted(
    part: Character, weight: float, importance: NDArray[np.float32] | None = None, beside: float = 0
) -> Samples:
    samples = samples_of(part, importance, beside)
    if weight == 1:
        return samples
    before, factor = samples.importance, np.float32(weight)
    return replace(samples, importance=by_rows(lambda rows: before[rows] * factor, before.shape, np.float32))


def _refined(surface: Surface, settings: Settings, weights: Mapping[str, float]) -> Parts:
    slots = min(settings.differences, len(surface.whole.expressions))
    kinds, bits = {kind.name: kind for kind in surface.maps}, surface.neutral_bits
    # Difference textures make up for what storing the neutral loses.
    scans = {
        key: replace(part, neutral=as_packed(part.neutral, kinds[key[0]], bits[key]))
        for key, part in surface.parts.items()
    }
    samples = {
        key: _weighted(part, weights[key[0]], settings.importance, BESIDE_THE_FACE) for key, part in scans.items()
    }
    components = None
    if len(surface.tiles) > 1:
        components = principal_weights([thinned(one, settings.weight_scale // 2) for one in samples.values()], slots)
    parts: Parts = {}
    for tile in surface.tiles:
        keys = [(kind.name, tile) for kind in surface.maps]
        shared = as_stored(
            fit_weights([samples[key] for key in keys], slots, settings.weight_scale, components=components)
        )
        parts |= {key: solve_model(scans[key], samples[key], shared) for key in keys}
    return parts


def _pca(surface: Surface, settings: Settings, weights: Mapping[str, float]) -> Parts:
    slots = min(settings.differences, len(surface.whole.expressions))
    samples = [_weighted(part, weights[name]) for (name, _), part in surface.parts.items()]
    components = principal_weights(samples, slots)
    return {key: combined(part, components) for key, part in surface.parts.items()}


def _stitched(
    surface: Surface,
    settings: Settings,
    weights: Mapping[str, float],
    choose: Callable[[NDArray[np.float64]], Stitching],
) -> Parts:
    clusters = min(PAPER_DIFFERENCES, len(surface.whole.expressions))
    keys, characters = [*surface.parts], [*surface.parts.values()]
    masks = dict(zip(keys, compute_shared_masks(characters, settings.masks, settings.seed), strict=True))

    def total(of: Callable[[tuple[str, int]], NDArray[np.float64]]) -> NDArray[np.float64]:
        return np.sum([weights[key[0]] * of(key) for key in keys], axis=0)

    labels = cluster_fragments(total(lambda key: masked_gram(surface.parts[key], masks[key])), clusters, settings.seed)
    stitching = choose(total(lambda key: pair_costs(surface.parts[key], masks[key], labels, clusters)))
    shares, alpha = cluster_shares(labels, stitching.permutation)
    first = surface.maps[0].name
    shared = {tile: weight_maps(masks[first, tile], alpha, settings.weight_scale) for tile in surface.tiles}
    return {
        key: CompressedTextures(
            part.texture("neutral"), difference_textures(part, masks[key], shares), shared[key[1]],
            part.expressions, "paper",
        )
        for key, part in surface.parts.items()
    }  # fmt: skip


def _paper(surface: Surface, settings: Settings, weights: Mapping[str, float]) -> Parts:
    return _stitched(surface, settings, weights, lambda table: search(table, settings.restarts, settings.seed))


def _paper_optimised(surface: Surface, settings: Settings, weights: Mapping[str, float]) -> Parts:
    return _stitched(surface, settings, weights, beam_search)


def _paper_unpermuted(surface: Surface, settings: Settings, weights: Mapping[str, float]) -> Parts:
    return _stitched(surface, settings, weights, unpermuted)


METHODS: dict[str, Callable[[Surface, Settings, Mapping[str, float]], Parts]] = {
    "refined": _refined,
    "paper": _paper,
    "paper-optimised": _paper_optimised,
    "paper-unpermuted": _paper_unpermuted,
    "pca": _pca,
}

_OF_THE_PAPER = ("differences", "weight_scale", "masks", "seed")
# What a method takes notice of, besides an importance.
USED: dict[str, tuple[str, ...]] = {
    "refined": ("differences", "weight_scale"),
    "paper": (*_OF_THE_PAPER, "restarts"),
    "paper-optimised": _OF_THE_PAPER,
    "paper-unpermuted": _OF_THE_PAPER,
    "pca": ("differences",),
}


def made_with(method: str, settings: Mapping[str, Any]) -> dict[str, Any]:
    """The method, and those of the settings that it uses: what a pack states of how it was made."""
    return {"method": method, **{name: value for name, value in settings.items() if name in USED[method]}}
