"""The best activations of fixed masks: alternations of textures and activations, as of free weight maps."""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from facezip.character.samples import Samples
from facezip.fit.activations import ActivationSystem, Bounds, project, solve_activations
from facezip.fit.momentum import accelerated
from facezip.fit.pca import larger_sides
from facezip.fit.refine import alternations
from facezip.fit.rounding import as_fitted
from facezip.fit.sweep import joint_system
from facezip.machine.progress import track
from facezip.pack.masked import expanded


def fit_activations(
    tiles: Mapping[int, Sequence[Samples]],
    masks: Mapping[int, NDArray[np.uint8]],
    components: NDArray[np.float32],
    bounds: Bounds,
) -> NDArray[np.float16]:
    """The activations ``(N, K, R)`` of masks that all tiles share, the largest of each layer scaled to 1.

    The size of a layer is free, since its difference textures are fitted to it: scaled so, activations that are not
    negative lie in 0..1. Of those the largest under each mask is near 1, so that no texture is larger than it need be.

    Parameters
    ----------
    tiles : the texels of each map on each tile. The error that is least is the sum over all of them.
    masks : by tile, ``(K, h, w)``.
    components : ``(N, R)`` uniform weights to start from.
    bounds : of the activations.
    """
    count = alternations(max(maps[0].importance.size for maps in tiles.values()), "fast")
    activations = _alternated(tiles, masks, _start(components, bounds), bounds, track(range(count), "Refining", count))
    if bounds.nonnegative:
        # Where one mask acts alone, its layers have a size of their own. At 1 each is a whole texture, I0 + D_i.
        activations, more = _scaled(activations, axis=0), count // 2
        activations = _alternated(tiles, masks, activations, bounds.at_most_one, track(range(more), "Clamping", more))
    return _scaled(activations, axis=(0, 1)).astype(np.float16)


def _scaled(activations: NDArray[np.float64], axis: int | tuple[int, ...]) -> NDArray[np.float64]:
    """With the largest along ``axis`` at 1."""
    largest = np.abs(activations).max(axis=axis)
    scaled: NDArray[np.float64] = activations / np.where(largest > 0, largest, 1)
    return scaled


def _alternated(
    tiles: Mapping[int, Sequence[Samples]],
    masks: Mapping[int, NDArray[np.uint8]],
    start: NDArray[np.float64],
    bounds: Bounds,
    steps: Iterable[int],
) -> NDArray[np.float64]:
    """Activations ``(N, K, R)`` after some alternations from ``start``."""
    units: dict[int, float] = {}

    def alternate(ahead: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
        return solve_activations(_joint(tiles, masks, ahead, units), ahead, bounds)

    return accelerated(
        start, steps, lambda here, before, share: bounds.clipped(here + share * (here - before)), alternate
    )


def _joint(
    tiles: Mapping[int, Sequence[Samples]],
    masks: Mapping[int, NDArray[np.uint8]],
    activations: NDArray[np.float64],
    units: dict[int, float],
) -> ActivationSystem:
    """The equations of all tiles; ``units`` keeps the first unit of each one's regularisation."""
    parts = []
    for tile, maps in tiles.items():
        system = joint_system(maps, as_fitted(expanded(masks[tile], activations.astype(np.float32))))
        system.regularise(units.setdefault(tile, system.mean_diagonal))
        parts.append(project(system, masks[tile]))
    return ActivationSystem.joint(parts)


def _start(components: NDArray[np.float32], bounds: Bounds) -> NDArray[np.float64]:
    """The same weights ``(N, R)`` under every mask, ``(N, K, R)``."""
    weights = larger_sides(components) if bounds.nonnegative else components
    return bounds.clipped(np.repeat(weights[:, None].astype(np.float64), len(bounds.low), axis=1))
