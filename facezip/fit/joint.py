"""One fit of all maps on all tiles, in which each map counts as it should (:mod:`facezip.fit.methods`)."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from facezip.character.samples import samples_of
from facezip.character.scans import Character
from facezip.character.surface import Surface
from facezip.errors import ErrorCode, FaceZipError
from facezip.fit.methods import Settings, check, fit, meshes_of
from facezip.machine.rows import sum_rows
from facezip.pack.surface_model import CompressedSurface


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
    settings = Settings(differences, weight_scale, masks, restarts, seed)
    check(method, settings)
    parts = fit(surface, method, settings, _map_weights(surface, dict(map_weights or {})))
    return CompressedSurface(surface.maps, parts, replace(meshes_of(surface.whole), topology=surface.topology))


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
