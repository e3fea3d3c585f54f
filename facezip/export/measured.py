"""How far what an engine shows is from what the pack holds: by the codec at full size, by mip-maps at every other."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice, pairwise

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import Map, angles
from facezip.export.documents.maps import CodecErrors, MipErrors
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


@dataclass(frozen=True)
class Added:
    """The error that a codec adds to a map of expressions: of each."""

    per_expression: Mapping[str, float]

    @property
    def mean(self) -> float:
        """Over expressions."""
        return float(np.mean([*self.per_expression.values()]))


def stated(kind: Map, codec: str, seen: Added, without: Added) -> CodecErrors:
    """What a document says of a map in a codec, and without fitting each texture to what was lost of the others."""
    if kind.is_normal:
        return CodecErrors(
            name=codec,
            angular_error=seen.mean,
            angular_error_per_expression=seen.per_expression,
            angular_error_without_fit=without.mean,
        )
    return CodecErrors(
        name=codec, rmse=seen.mean, rmse_per_expression=seen.per_expression, rmse_without_fit=without.mean
    )


def codec_errors(sheet: Sheet, part: Part, pyramid: Pyramid, seen: Part) -> dict[str, Added]:
    """By map, the error that a codec adds to the textures of expressions, inside the chart.

    ``part`` is what the pack holds, and ``seen`` what a sampler sees of it once it is stored.
    """
    share, names = pyramid.shares[0], sheet.expressions
    errors = {
        name: _errors(sheet, blended_rows(seen, weights), blended_rows(part, weights), share)
        for name, weights in zip(track(names, "Measuring", len(names)), sheet.weights, strict=True)
    }
    return {kind.name: Added({name: error[kind.name] for name, error in errors.items()}) for kind, _ in sheet.maps}


def mip_errors(
    sheet: Sheet, part: Part, pyramid: Pyramid, plain: Sequence[Level], **candidates: Sequence[Level]
) -> dict[str, list[MipErrors]]:
    """By map, how far levels are from how a blend should look from afar; one entry a level.

    Parameters
    ----------
    sheet, part, pyramid : the maps, what the pack holds of them, and which texels count.
    plain : every texture averaged on its own and stored as it is.
    **candidates : ``averaged`` and ``fitted`` levels, of textures as an engine sees them.
    """
    numbers = range(len(sheet.expressions))
    most = max(TEXELS_MEASURED // pyramid.shares[0].size, LEAST)
    alone: list[Blend] = [(n,) for n in numbers[:: -(-len(numbers) // most)]]
    mixed: list[Blend] = list(islice(pairwise(numbers), min(most, BLENDS)))
    count = sum(min(size) >= SMALLEST for size in pyramid.sizes)
    rows = {kind.name: [Errors() for _ in range(count)] for kind, _ in sheet.maps}
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
    return {
        name: [MipErrors(size=size, **row) for size, row in zip(pyramid.sizes, of_map, strict=False)]
        for name, of_map in rows.items()
    }


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
