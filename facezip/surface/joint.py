"""One fit of all maps on all tiles.

Weight maps that several maps share minimise the sum of the maps' errors, so their normal equations are sums too: of
Gram matrices for principal components and clusters, of the weights' sparse systems in the refined fit. Difference
textures are solved map by map under the shared weights. Tiles share what lives on the mesh or is one number for all:
masks and principal components; the refined weight maps of a tile are its own.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from facezip.baselines import combined, principal_weights
from facezip.beam import beam_search
from facezip.character import Character
from facezip.errors import ErrorCode, FaceZipError
from facezip.factorise import cluster_shares, difference_textures, weight_maps
from facezip.fragments import cluster_fragments, masked_gram
from facezip.masks import compute_shared_masks
from facezip.methods import METHODS, PAPER_DIFFERENCES, Settings
from facezip.model import CompressedTextures, Meshes
from facezip.paircosts import pair_costs
from facezip.refine import as_stored, fit_weights, fitted
from facezip.rows import sum_rows
from facezip.samples import BESIDE_THE_FACE, Samples, samples_of, thinned
from facezip.stitching import Stitching, search, unpermuted
from facezip.surface.model import CompressedSurface
from facezip.surface.neutrals import as_packed
from facezip.surface.scans import Surface

Keys = tuple[str, int]
# By map and tile.
Parts = Mapping[Keys, CompressedTextures]


def compress_surface(
    surface: Surface,
    method: str = "refined",
    *,
    map_weights: Mapping[str, float] | None = None,
    differences: int = 4,
    weight_scale: int = 8,
    masks: int = 53,
    restarts: int = 100,
    seed: int = 0,
) -> CompressedSurface:
    """Fit difference textures of every map, and weight maps that they share, to a surface.

    Parameters
    ----------
    surface : the scans.
    method, differences, weight_scale, masks, restarts, seed : as of :func:`facezip.compress`; weight maps are
        ``weight_scale`` times smaller than the first map.
    map_weights : how much a map counts, > 0. With 1, the default, the expressions' differences of each map count alike
        in sum, whatever its units, channels and size.

    Raises
    ------
    FaceZipError
        ``BAD_VALUE`` for a setting outside its range, ``UNKNOWN_NAME`` for the weight of a map that there is not,
        ``TOO_MANY_MASKS``.
    """
    if method not in METHODS:
        raise FaceZipError(ErrorCode.BAD_VALUE, f"method '{method}': must be one of {', '.join(METHODS)}")
    settings = Settings(differences, weight_scale, masks, restarts, seed)
    settings.check()
    weights = _map_weights(surface, dict(map_weights or {}))
    parts = _METHODS[method](surface, settings, weights)
    whole = surface.whole
    meshes = Meshes(surface.topology, whole.neutral_vertices, whole.vertices - whole.neutral_vertices)
    named = {key: replace(part, method=method) for key, part in parts.items()}
    return CompressedSurface(surface.maps, named, meshes)


def _map_weights(surface: Surface, given: dict[str, float]) -> dict[str, float]:
    """The factor of each map's squared error: the first one's is what is given for it, 1 if nothing is."""
    names = [kind.name for kind in surface.maps]
    for name, weight in given.items():
        if name not in names:
            raise FaceZipError(ErrorCode.UNKNOWN_NAME, f"no map '{name}' in {surface.whole.name}; it has {names}")
        if not 0 < weight <= 1e6:
            raise FaceZipError(ErrorCode.BAD_VALUE, f"weight {weight} of map '{name}': must lie within 0 and 1e6")
    if len(names) == 1:
        return {names[0]: 1.0}
    energy = {name: sum(_energy(part) for part in surface.of_map(name)) for name in names}
    unit = energy[names[0]] or 1.0
    return {name: given.get(name, 1.0) * unit / (energy[name] or unit) for name in names}


def _energy(part: Character) -> float:
    """Σ_n Σ_p m(p) ‖D_n(p)‖²."""
    samples = samples_of(part)

    def block(top: int, bottom: int) -> NDArray[np.float64]:
        neutral = samples.neutral[top:bottom].astype(np.float32)
        gaps = (samples.scale * (texture[top:bottom].astype(np.float32) - neutral) for texture in samples.textures)
        squares = sum(np.einsum("hwc,hwc->hw", gap, gap) for gap in gaps)
        return np.vdot(samples.importance[top:bottom], squares).astype(np.float64)

    return float(sum_rows(block, len(samples.neutral)))


def _weighted(part: Character, weight: float, beside: float = 0) -> Samples:
    samples = samples_of(part, beside=beside)
    return samples if weight == 1 else replace(samples, importance=samples.importance * np.float32(weight))


def _refined(surface: Surface, settings: Settings, weights: dict[str, float]) -> Parts:
    slots = min(settings.differences, len(surface.whole.expressions))
    kinds, bits = {kind.name: kind for kind in surface.maps}, surface.neutral_bits
    # Difference textures make up for what storing the neutral loses.
    scans = {
        key: replace(part, neutral=as_packed(part.neutral, kinds[key[0]], bits[key]))
        for key, part in surface.parts.items()
    }
    samples = {key: _weighted(part, weights[key[0]], BESIDE_THE_FACE) for key, part in scans.items()}
    few = [thinned(one, settings.weight_scale // 2) for one in samples.values()]
    components = principal_weights(few, slots)
    parts: dict[Keys, CompressedTextures] = {}
    for tile in surface.tiles:
        keys = [(kind.name, tile) for kind in surface.maps]
        shared = as_stored(
            fit_weights([samples[key] for key in keys], slots, settings.weight_scale, components=components)
        )
        parts |= {key: fitted(scans[key], samples[key], shared) for key in keys}
    return parts


def _pca(surface: Surface, settings: Settings, weights: dict[str, float]) -> Parts:
    slots = min(settings.differences, len(surface.whole.expressions))
    samples = [_weighted(part, weights[name]) for (name, _), part in surface.parts.items()]
    components = principal_weights(samples, slots)
    return {key: combined(part, components) for key, part in surface.parts.items()}


def _stitched(
    surface: Surface,
    settings: Settings,
    weights: dict[str, float],
    choose: Callable[[NDArray[np.float64]], Stitching],
) -> Parts:
    if settings.differences != PAPER_DIFFERENCES:
        raise FaceZipError(
            ErrorCode.BAD_VALUE,
            f"differences {settings.differences}: the paper's method makes exactly {PAPER_DIFFERENCES} textures",
        )
    clusters = min(PAPER_DIFFERENCES, len(surface.whole.expressions))
    keys, characters = [*surface.parts], [*surface.parts.values()]
    masks = dict(zip(keys, compute_shared_masks(characters, settings.masks, settings.seed), strict=True))

    def total(of: Callable[[Keys], NDArray[np.float64]]) -> NDArray[np.float64]:
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


def _paper(surface: Surface, settings: Settings, weights: dict[str, float]) -> Parts:
    return _stitched(surface, settings, weights, lambda table: search(table, settings.restarts, settings.seed))


def _paper_optimised(surface: Surface, settings: Settings, weights: dict[str, float]) -> Parts:
    return _stitched(surface, settings, weights, beam_search)


def _paper_unpermuted(surface: Surface, settings: Settings, weights: dict[str, float]) -> Parts:
    return _stitched(surface, settings, weights, unpermuted)


_METHODS: dict[str, Callable[[Surface, Settings, dict[str, float]], Parts]] = {
    "refined": _refined,
    "paper": _paper,
    "paper-optimised": _paper_optimised,
    "paper-unpermuted": _paper_unpermuted,
    "pca": _pca,
}
