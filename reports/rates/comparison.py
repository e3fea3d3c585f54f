"""Curves out of points, and the honest question: at no more bytes than the rival, how much error is left?"""

from collections.abc import Sequence

from facezip.documents.document import Data
from reports.rates.documents import Comparison
from reports.rates.families import OURS, RIVAL
from reports.rates.points import Point

# A point or a row of a document, as data.
Row = Data
# Bytes a texel between which block compression of every texture is used: below it looks bad, above it is not needed.
LEAST, MOST = 2.0, 6.0


def of_family(points: Sequence[Row], family: str) -> list[Row]:
    """The points of a family, by bytes."""
    return sorted((point for point in points if point["family"] == family), key=lambda point: point["bytes_per_texel"])


def envelope(points: Sequence[Row]) -> list[Row]:
    """The points, sorted by bytes, that have less error than all that cost no more."""
    kept: list[Row] = []
    for point in sorted(points, key=lambda one: (one["bytes_per_texel"], one["rmse"])):
        if not kept or point["rmse"] < kept[-1]["rmse"]:
            kept.append(point)
    return kept


def compare(points: Sequence[Point]) -> list[Comparison]:
    """For every point of the rival, our best one that costs no more."""
    rows = []
    for rival in sorted((one for one in points if one.family == RIVAL), key=lambda one: one.bytes_per_texel):
        within = [one for one in points if one.family == OURS and one.bytes_per_texel <= rival.bytes_per_texel]
        if within:
            ours = min(within, key=lambda one: (one.rmse, one.bytes_per_texel))
            rows.append(Comparison(rival=rival, ours=ours, ratio=ours.rmse / rival.rmse))
    return rows


def in_use(rows: Sequence[Row]) -> list[Row]:
    """The rows of :func:`compare` between ``LEAST`` and ``MOST`` bytes a texel."""
    return [row for row in rows if LEAST <= row["rival"]["bytes_per_texel"] <= MOST]
