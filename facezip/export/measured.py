"""How far what an engine shows is from what the pack holds: by the codec at full size, by mip-maps at every other."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import islice, pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import Map, angles
from facezip.export.levels import Level, as_model
from facezip.export.mips import Pyramid
from facezip.export.sheets import Sheet
from facezip.machine.progress import track
from facezip.pack.model import CompressedTextures

# Below this side a head is a few pixels, and a level has too few texels for a mean over them to say anything.
SMALLEST = 8
# A mean over a few expressions is as good as one over all: that many texels are looked at, of at least four of them.
TEXELS_MEASURED, LEAST = 2**24, 4
# Blends that the fit has not seen: neighbours in the order of expressions, half and half.
BLENDS = 8

Blend = Mapping[str, float]
# By map: of colours and data RMSE in units of 0..255 of the map's range, of normals the mean angle in degrees.
Errors = dict[str, float]


def measure_of(kind: Map) -> str:
    """What the error of a map is called, as in :func:`facezip.pack.errors.surface_errors`."""
    return "angular_error" if kind.is_normal else "rmse"


def codec_errors(sheet: Sheet, pyramid: Pyramid, level: Level) -> dict[str, dict[str, Any]]:
    """By map, the error that a codec adds to the textures of expressions, inside the chart: mean, and of each."""
    seen, share, names = as_model(sheet, level), pyramid.shares[0], sheet.model.expressions
    errors = {
        name: _errors(sheet, seen.reconstruct(name), sheet.model.reconstruct(name), share)
        for name in track(names, "Measuring", len(names))
    }
    found = {}
    for kind, _ in sheet.maps:
        alone, measure = {name: error[kind.name] for name, error in errors.items()}, measure_of(kind)
        found[kind.name] = {measure: float(np.mean([*alone.values()])), f"{measure}_per_expression": alone}
    return found


def mip_errors(
    sheet: Sheet, pyramid: Pyramid, plain: Sequence[Level], **candidates: Sequence[Level]
) -> dict[str, list[dict[str, Any]]]:
    """By map, how far levels are from how a blend should look from afar; one document a level.

    Parameters
    ----------
    sheet, pyramid : the maps, and which texels count.
    plain : every texture averaged on its own and stored as it is.
    **candidates : levels by name, of textures as an engine sees them.

    Returns
    -------
    For each level its ``size``, and errors inside the chart: ``product_gap``, how far the mean of a blend's fitted
    texels is from the blend of ``plain`` mips; for each candidate its error over expressions, and (``NAME_blends``)
    over blends of them that no fit has seen.
    """
    names = sheet.model.expressions
    most = max(TEXELS_MEASURED // pyramid.shares[0].size, LEAST)
    some = names[:: -(-len(names) // most)]
    alone: list[Blend] = [{name: 1.0} for name in some]
    mixed: list[Blend] = [dict.fromkeys(pair, 0.5) for pair in islice(pairwise(names), min(most, BLENDS))]
    count = sum(min(size) >= SMALLEST for size in pyramid.sizes)
    models = {
        name: [as_model(sheet, level) for level in levels[:count]]
        for name, levels in {"plain": plain, **candidates}.items()
    }
    rows: dict[str, list[dict[str, Any]]] = {
        kind.name: [{"size": list(size)} for size in pyramid.sizes[:count]] for kind, _ in sheet.maps
    }
    kinds: dict[str, list[Blend]] = {"": alone, "_blends": mixed}
    for which, blends in kinds.items():
        errors = [
            list(_errors_of(sheet, pyramid, blend, models, count)) for blend in track(blends, "Measuring", len(blends))
        ]
        for number, levels in enumerate(zip(*errors, strict=True)):
            for name, of_map in rows.items():
                row = of_map[number]
                row |= {key + which: float(np.mean([level[key][name] for level in levels])) for key in levels[0]}
    return rows


def _errors_of(
    sheet: Sheet, pyramid: Pyramid, blend: Blend, models: Mapping[str, Sequence[CompressedTextures]], count: int
) -> Iterator[dict[str, Errors]]:
    whole = sheet.model.blend(blend)
    levels = zip(pyramid.looks(sheet, whole), pyramid.levels(whole), pyramid.shares, strict=True)
    for number, (look, mean, share) in enumerate(islice(levels, count)):
        shown = {name: model[number].blend(blend) for name, model in models.items()}
        errors = {name: _errors(sheet, texture, look, share) for name, texture in shown.items()}
        yield {"product_gap": _errors(sheet, shown["plain"], mean, share), **errors}


def _errors(sheet: Sheet, seen: NDArray[np.float32], wanted: NDArray[np.float32], share: NDArray[np.float32]) -> Errors:
    return {kind.name: _error(kind, seen[..., at], wanted[..., at], share) for kind, at in sheet.maps}


def _error(kind: Map, seen: NDArray[np.float32], wanted: NDArray[np.float32], share: NDArray[np.float32]) -> float:
    whole = share.sum(dtype=np.float64)
    if kind.is_normal:
        degrees = angles(kind.values(seen), kind.values(wanted))
        return float((degrees * share).sum(dtype=np.float64) / whole)
    squares = np.square(seen - wanted).mean(axis=2)
    return float(255 * np.sqrt((squares * share).sum(dtype=np.float64) / whole))
