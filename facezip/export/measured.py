"""How far what an engine shows is from what the pack holds: by the codec at full size, by mip-maps at every other."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import islice, pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import Map, angles
from facezip.export.levels import Level
from facezip.export.mips import Pyramid
from facezip.export.sheets import Sheet
from facezip.machine.progress import track
from facezip.machine.rows import by_rows, sum_rows
from facezip.pack.model import Part, blended_rows

# Below this side a head is a few pixels, and a level has too few texels for a mean over them to say anything.
SMALLEST = 8
# A mean over a few expressions is as good as one over all: that many texels are looked at, of at least four of them.
TEXELS_MEASURED, LEAST = 2**24, 4
# Blends that the fit has not seen: neighbours in the order of expressions, half and half.
BLENDS = 8

# Numbers of expressions, each of the same weight.
Blend = tuple[int, ...]
Rows = Callable[[slice], NDArray[np.float32]]
# By map: of colours and data RMSE in units of 0..255 of the map's range, of normals the mean angle in degrees.
Errors = dict[str, float]


def measure_of(kind: Map) -> str:
    """What the error of a map is called, as in :func:`facezip.pack.errors.model_errors`."""
    return "angular_error" if kind.is_normal else "rmse"


def codec_errors(sheet: Sheet, part: Part, pyramid: Pyramid, seen: Part) -> dict[str, dict[str, Any]]:
    """By map, the error that a codec adds to the textures of expressions, inside the chart: mean, and of each.

    ``part`` is what the pack holds, and ``seen`` what a sampler sees of it once it is stored.
    """
    share, names = pyramid.shares[0], sheet.expressions
    errors = {
        name: _errors(sheet, blended_rows(seen, weights), blended_rows(part, weights), share)
        for name, weights in zip(track(names, "Measuring", len(names)), sheet.weights, strict=True)
    }
    found = {}
    for kind, _ in sheet.maps:
        alone, measure = {name: error[kind.name] for name, error in errors.items()}, measure_of(kind)
        found[kind.name] = {measure: float(np.mean([*alone.values()])), f"{measure}_per_expression": alone}
    return found


def mip_errors(
    sheet: Sheet, part: Part, pyramid: Pyramid, plain: Sequence[Level], **candidates: Sequence[Level]
) -> dict[str, list[dict[str, Any]]]:
    """By map, how far levels are from how a blend should look from afar; one document a level.

    Parameters
    ----------
    sheet, part, pyramid : the maps, what the pack holds of them, and which texels count.
    plain : every texture averaged on its own and stored as it is.
    **candidates : levels by name, of textures as an engine sees them.

    Returns
    -------
    For each level its ``size``, and errors inside the chart: ``product_gap``, how far the mean of a blend's texels is
    from the blend of ``plain`` mips; for each candidate its error over expressions, and (``NAME_blends``) over blends
    of them that no fit has seen.
    """
    numbers = range(len(sheet.expressions))
    most = max(TEXELS_MEASURED // pyramid.shares[0].size, LEAST)
    alone: list[Blend] = [(n,) for n in numbers[:: -(-len(numbers) // most)]]
    mixed: list[Blend] = list(islice(pairwise(numbers), min(most, BLENDS)))
    count = sum(min(size) >= SMALLEST for size in pyramid.sizes)
    rows: dict[str, list[dict[str, Any]]] = {
        kind.name: [{"size": list(size)} for size in pyramid.sizes[:count]] for kind, _ in sheet.maps
    }
    kinds: dict[str, list[Blend]] = {"": alone, "_blends": mixed}
    for which, blends in kinds.items():
        errors = [
            list(_errors_of(sheet, part, pyramid, blend, {"plain": plain, **candidates}, count))
            for blend in track(blends, "Measuring", len(blends))
        ]
        for number, levels in enumerate(zip(*errors, strict=True)):
            for name, of_map in rows.items():
                row = of_map[number]
                row |= {key + which: float(np.mean([level[key][name] for level in levels])) for key in levels[0]}
    return rows


def _errors_of(
    sheet: Sheet, part: Part, pyramid: Pyramid, blend: Blend, candidates: Mapping[str, Sequence[Level]], count: int
) -> Iterator[dict[str, Errors]]:
    weights = sheet.weights[[*blend]].mean(axis=0)
    whole = by_rows(blended_rows(part, weights), part.neutral.shape, np.float32)
    levels = zip(pyramid.looks(sheet, whole), pyramid.levels(whole), pyramid.shares, strict=True)
    for number, (look, mean, share) in enumerate(islice(levels, count)):
        shown = {name: blended_rows(levels[number].part, weights) for name, levels in candidates.items()}
        errors = {name: _errors(sheet, rows, look.__getitem__, share) for name, rows in shown.items()}
        yield {"product_gap": _errors(sheet, shown["plain"], mean.__getitem__, share), **errors}


def _errors(sheet: Sheet, seen: Rows, wanted: Rows, share: NDArray[np.float32]) -> Errors:
    """The error of each map, weighted by ``share`` ``(h, w)``."""

    def block(top: int, bottom: int) -> NDArray[np.float64]:
        rows = slice(top, bottom)
        ours, theirs, weight = seen(rows), wanted(rows), share[rows]
        gaps = [_gap(kind, ours[..., at], theirs[..., at]) * weight for kind, at in sheet.maps]
        return np.array([values.sum(dtype=np.float64) for values in (*gaps, weight)])

    *sums, whole = sum_rows(block, len(share))
    return {
        kind.name: float(total / whole if kind.is_normal else 255 * np.sqrt(total / whole))
        for (kind, _), total in zip(sheet.maps, sums, strict=True)
    }


def _gap(kind: Map, seen: NDArray[np.float32], wanted: NDArray[np.float32]) -> NDArray[np.float32]:
    """Of each texel: degrees between normals, else the mean square over channels."""
    if kind.is_normal:
        return angles(kind.decode(seen), kind.decode(wanted))
    squares: NDArray[np.float32] = np.square(seen - wanted).mean(axis=2)
    return squares
