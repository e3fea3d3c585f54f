"""Curves out of points, and the honest question: at no more bytes than the rival, how much error is left?"""

from collections.abc import Mapping, Sequence
from typing import Any

from reports.rates.families import OURS, PAPER_RANK

Row = Mapping[str, Any]
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


def compare(points: Sequence[Row]) -> list[dict[str, Any]]:
    """For every point of a rival, our best ones that cost no more, of codecs that lie on the same devices.

    Returns
    -------
    Rows of ``rival``; ``ours``, ``ratio`` of all packs; ``few``, ``few_ratio`` of those of at most four differences,
    six fetches of one map: points, and their errors divided by the rival's. Null where nothing costs so little.
    """
    return [_compared(rival, points, ours) for family, ours in OURS.items() for rival in of_family(points, family)]


def _compared(rival: Row, points: Sequence[Row], family: str) -> dict[str, Any]:
    within = [one for one in of_family(points, family) if one["bytes_per_texel"] <= rival["bytes_per_texel"]]
    ours = _best(within)
    few = _best([one for one in within if one["differences"] <= PAPER_RANK])
    return {"rival": rival, "ours": ours, "ratio": _ratio(ours, rival), "few": few, "few_ratio": _ratio(few, rival)}


def _best(points: Sequence[Row]) -> Row | None:
    return min(points, key=lambda one: one["rmse"], default=None)


def _ratio(ours: Row | None, rival: Row) -> float | None:
    return ours["rmse"] / rival["rmse"] if ours else None


def in_use(rows: Sequence[Row]) -> list[Row]:
    """The rows of :func:`compare` between ``LEAST`` and ``MOST`` bytes a texel for which there is a pack."""
    return [row for row in rows if row["ours"] and LEAST <= row["rival"]["bytes_per_texel"] <= MOST]
