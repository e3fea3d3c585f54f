"""How far a compressed surface is from its scans: RMSE of colours and data, degrees of normals."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import MapKind, angles
from facezip.character.scans import Character
from facezip.character.surface import Surface
from facezip.files.images import to_float
from facezip.machine.progress import track
from facezip.machine.rows import map_rows, sum_rows
from facezip.pack.measure import mean_rmse, model_errors, texture_errors
from facezip.pack.surface_model import CompressedSurface


# The scans of a map on a tile, and what stands against them: errors by expression, and rows of fitted texels of one.
@dataclass(frozen=True, eq=False)
class _Pair:
    part: Character
    errors: Callable[[], dict[str, float]]
    rows_of: Callable[[str], Callable[[slice], NDArray[np.float32]]]

    @cached_property
    def weight(self) -> NDArray[np.float32]:
        return self.part.weight

    @cached_property
    def texels(self) -> float:
        sums = map_rows(lambda top, bottom: float(self.weight[top:bottom].sum(dtype=np.float64)), len(self.weight))
        return sum(sums)


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
        return _Pair(part, lambda: model_errors(part, fitted), lambda name: fitted.rows_of({name: 1.0}))

    return _errors(surface, pair)


def texture_surface_errors(surface: Surface, other: Surface) -> dict[str, dict[str, Any]]:
    """The same for maps that another tool made, of the same sizes and ranges."""

    def pair(part: Character, key: tuple[str, int]) -> _Pair:
        theirs = other.parts[key]

        def rows_of(name: str) -> Callable[[slice], NDArray[np.float32]]:
            texture = theirs.textures[theirs.index(name)]
            return lambda rows: to_float(texture[rows])

        return _Pair(part, lambda: texture_errors(part, theirs.texture), rows_of)

    return _errors(surface, pair)


def _errors(surface: Surface, pair: Callable[[Character, tuple[str, int]], _Pair]) -> dict[str, dict[str, Any]]:
    found = {}
    for kind in surface.maps:
        pairs = [pair(surface.parts[kind.name, tile], (kind.name, tile)) for tile in surface.tiles]
        seen = [one for one in pairs if one.texels > 0]
        found[kind.name] = _angular(kind, seen) if kind.is_normal else _rmse(seen)
    return found


def _rmse(pairs: Sequence[_Pair]) -> dict[str, Any]:
    texels = [pair.texels for pair in pairs]
    errors = [pair.errors() for pair in pairs]
    mean = {
        name: float(np.sqrt(sum(n * one[name] ** 2 for n, one in zip(texels, errors, strict=True)) / sum(texels)))
        for name in errors[0]
    }
    return {"rmse": mean_rmse(mean), "rmse_per_expression": mean}


def _angular(kind: MapKind, pairs: Sequence[_Pair]) -> dict[str, Any]:
    names = pairs[0].part.expressions
    total, texels = np.zeros((len(names), 2)), sum(pair.texels for pair in pairs)
    for pair in pairs:
        for n, name in enumerate(track(names, "Measuring normals", len(names))):
            total[n] += _moments(kind, pair, name)
    mean, square = total.T / texels
    per_expression = dict(zip(names, mean.tolist(), strict=True))
    rms = np.sqrt(square).mean()
    return {
        "angular_error": mean_rmse(per_expression),
        "angular_error_rms": float(rms),
        "angular_error_per_expression": per_expression,
    }


def _moments(kind: MapKind, pair: _Pair, name: str) -> NDArray[np.float64]:
    """The sums over texels of an expression's angles in degrees, and of their squares."""
    original, theirs = pair.part.textures[pair.part.index(name)], pair.rows_of(name)

    def block(top: int, bottom: int) -> NDArray[np.float64]:
        rows = slice(top, bottom)
        degrees = angles(kind.values(original[rows]), kind.values(theirs(rows)))
        weighted = pair.weight[rows] * degrees
        return np.array([weighted.sum(dtype=np.float64), (weighted * degrees).sum(dtype=np.float64)])

    return sum_rows(block, len(original))
