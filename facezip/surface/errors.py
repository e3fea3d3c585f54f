"""How far a compressed surface is from its scans: RMSE of colours and data, degrees of normals."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.character import Character
from facezip.measure import mean_rmse, model_errors
from facezip.model import CompressedTextures
from facezip.progress import track
from facezip.surface.maps import MapKind, angles
from facezip.surface.model import CompressedSurface
from facezip.surface.scans import Surface

Pair = tuple[Character, CompressedTextures]


def surface_errors(surface: Surface, model: CompressedSurface) -> dict[str, dict[str, Any]]:
    """For each map, the errors over all its tiles inside the mask.

    Returns
    -------
    ``rmse`` and ``rmse_per_expression`` of colours and data, in units of 0..255 (of a map's range where it has one);
    for normals ``angular_error`` and ``angular_error_per_expression``, the mean angle in degrees, and
    ``angular_error_rms``.
    """
    found = {}
    for kind in surface.maps:
        both = [(surface.parts[kind.name, tile], model.parts[kind.name, tile]) for tile in surface.tiles]
        pairs = [(part, fitted) for part, fitted in both if _weight(part).any()]
        found[kind.name] = _angular(kind, pairs) if kind.is_normal else _rmse(pairs)
    return found


def _rmse(pairs: Sequence[Pair]) -> dict[str, Any]:
    texels = [_weight(part).sum(dtype=np.float64) for part, _ in pairs]
    errors = [model_errors(part, model) for part, model in pairs]
    mean = {
        name: float(np.sqrt(sum(n * one[name] ** 2 for n, one in zip(texels, errors, strict=True)) / sum(texels)))
        for name in errors[0]
    }
    return {"rmse": mean_rmse(mean), "rmse_per_expression": mean}


def _angular(kind: MapKind, pairs: Sequence[Pair]) -> dict[str, Any]:
    names = pairs[0][0].expressions
    mean, square, total = np.zeros(len(names)), np.zeros(len(names)), 0.0
    for part, model in pairs:
        weight = _weight(part)
        total += weight.sum(dtype=np.float64)
        for n, name in enumerate(track(names, "Measuring normals", len(names))):
            degrees = angles(kind.values(part.textures[n]), kind.values(model.reconstruct(name)))
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
