"""How far a compressed surface is from its scans: RMSE of colours and data, degrees of normals."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.character import Character
from facezip.measure import mean_rmse, model_errors, texture_errors
from facezip.progress import track
from facezip.surface.maps import MapKind, angles
from facezip.surface.model import CompressedSurface
from facezip.surface.scans import Surface


# The scans of a map on a tile, and what stands against them: errors by expression, and fitted texels of one.
@dataclass(frozen=True, eq=False)
class _Pair:
    part: Character
    errors: Callable[[], dict[str, float]]
    texture: Callable[[str], NDArray[np.float32]]


def surface_errors(surface: Surface, model: CompressedSurface) -> dict[str, dict[str, Any]]:
    """For each map, the errors over all its tiles inside the mask.

    Returns
    -------
    ``rmse`` and ``rmse_per_expression`` of colours and data, in units of 0..255 (of a map's range where it has one);
    for normals ``angular_error`` and ``angular_error_per_expression``, the mean angle in degrees, and
    ``angular_error_rms``.
    """

    def pair(part: Character, key: tuple[str, int]) -> _Pair:
        fitted = model.parts[key]
        return _Pair(part, lambda: model_errors(part, fitted), fitted.reconstruct)

    return _errors(surface, pair)


def texture_surface_errors(surface: Surface, other: Surface) -> dict[str, dict[str, Any]]:
    """The same for maps that another tool made, of the same sizes and ranges."""

    def pair(part: Character, key: tuple[str, int]) -> _Pair:
        theirs = other.parts[key]
        return _Pair(part, lambda: texture_errors(part, theirs.texture), theirs.texture)

    return _errors(surface, pair)


def _errors(surface: Surface, pair: Callable[[Character, tuple[str, int]], _Pair]) -> dict[str, dict[str, Any]]:
    found = {}
    for kind in surface.maps:
        keys = [(kind.name, tile) for tile in surface.tiles]
        pairs = [pair(surface.parts[key], key) for key in keys if _weight(surface.parts[key]).any()]
        found[kind.name] = _angular(kind, pairs) if kind.is_normal else _rmse(pairs)
    return found


def _rmse(pairs: Sequence[_Pair]) -> dict[str, Any]:
    texels = [_weight(pair.part).sum(dtype=np.float64) for pair in pairs]
    errors = [pair.errors() for pair in pairs]
    mean = {
        name: float(np.sqrt(sum(n * one[name] ** 2 for n, one in zip(texels, errors, strict=True)) / sum(texels)))
        for name in errors[0]
    }
    return {"rmse": mean_rmse(mean), "rmse_per_expression": mean}


def _angular(kind: MapKind, pairs: Sequence[_Pair]) -> dict[str, Any]:
    names = pairs[0].part.expressions
    mean, square, total = np.zeros(len(names)), np.zeros(len(names)), 0.0
    for pair in pairs:
        weight = _weight(pair.part)
        total += weight.sum(dtype=np.float64)
        for n, name in enumerate(track(names, "Measuring normals", len(names))):
            degrees = angles(kind.values(pair.part.textures[n]), kind.values(pair.texture(name)))
            mean[n] += np.vdot(weight, degrees)
            square[n] += np.vdot(weight, np.square(degrees))
    per_expression = dict(zip(names, (mean / total).tolist(), strict=True))
    rms = np.sqrt(square / total).mean()
    return {
        "angular_error": mean_rmse(per_expression),
        "angular_error_rms": float(rms),
        "angular_error_per_expression": per_expression,
    }


def _weight(part: Character) -> NDArray[np.float32]:
    return np.ones(part.resolution, np.float32) if part.mask is None else part.mask
