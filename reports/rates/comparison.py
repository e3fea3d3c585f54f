"""Curves out of points, and the honest question: at no more bytes than the rival, how much error is left?"""

from collections.abc import Callable, Sequence

from facezip.documents.document import Data
from reports.rates.documents import Comparison
from reports.rates.families import OURS, PAPER_RANK
from reports.rates.points import Point

# A point or a row of a document, as data.
Row = Data
# What a point costs.
Size = Callable[[Row], float]
# Bytes a texel between which block compression of every texture is used: below it looks bad, above it is not needed.
LEAST, MOST = 2.0, 6.0


def of_family(points: Sequence[Row], family: str) -> list[Row]:
    """The points of a family, by bytes."""
    return sorted((point for point in points if point["family"] == family), key=lambda point: point["bytes_per_texel"])


def on_gpu(point: Row) -> float:
    """Bytes of GPU memory a texel."""
    return float(point["bytes_per_texel"])


def on_wire(point: Row) -> float:
    """Bytes of files a texel."""
    return on_gpu(point) * float(point["bytes_on_wire"]) / float(point["bytes"])


def envelope(points: Sequence[Row], size: Size = on_gpu) -> list[Row]:
    """The points, sorted by size, that have less error than all that cost no more."""
    kept: list[Row] = []
    for point in sorted(points, key=lambda one: (size(one), one["rmse"])):
        if not kept or point["rmse"] < kept[-1]["rmse"]:
            kept.append(point)
    return kept


def compare(points: Sequence[Point]) -> list[Comparison]:
    """For every point of a rival, our best ones that cost no more, of codecs that lie on the same devices."""
    rows = []
    for family, ours in OURS.items():
        for rival in sorted((one for one in points if one.family == family), key=lambda one: one.bytes_per_texel):
            within = [one for one in points if one.family == ours and one.bytes_per_texel <= rival.bytes_per_texel]
            if within:
                rows.append(_compared(rival, within))
    return rows


def _compared(rival: Point, within: Sequence[Point]) -> Comparison:
    ours = min(within, key=_by_error)
    few = min((one for one in within if (one.differences or 0) <= PAPER_RANK), key=_by_error, default=None)
    few_ratio = few.rmse / rival.rmse if few else None
    return Comparison(rival=rival, ours=ours, ratio=ours.rmse / rival.rmse, few=few, few_ratio=few_ratio)


def _by_error(point: Point) -> tuple[float, float]:
    return point.rmse, point.bytes_per_texel


def in_use(rows: Sequence[Row]) -> list[Row]:
    """The rows of :func:`compare` between ``LEAST`` and ``MOST`` bytes a texel."""
    return [row for row in rows if LEAST <= row["rival"]["bytes_per_texel"] <= MOST]
