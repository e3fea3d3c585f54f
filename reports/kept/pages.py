"""Numbers of the documentation that come from the kept figures.

A comment after a number says where it comes from, and a page shows nothing of it:
``1.19<!--kept embedded/512/refined/rmse-->`` of a row, ``1.39<!--kept maps/ways/shared/errors/albedo/rmse-->`` of a
benchmark's answer. Two of them with `` / `` between are their ratio. Bytes are in MB; each number keeps the decimals
that it is written with.
"""

import re
from collections.abc import Mapping
from pathlib import Path

from facezip.errors import ErrorCode, FaceZipError
from reports.kept.answers import Figure
from reports.kept.rows import COLUMNS, Row
from reports.site import BESIDE, ROOT

NUMBER = re.compile(r"(\d+(?:\.(\d+))?)(\**<!--kept ([^>]+)-->)")


def pages() -> list[Path]:
    """All pages of the documentation."""
    return [*sorted((ROOT / "docs").glob("*.md")), *(ROOT / name for name in BESIDE)]


def renewed(text: str, rows: Mapping[str, Row], figures: Mapping[str, Figure]) -> str:
    """A page with the numbers of rows and figures, by their keys.

    Raises
    ------
    FaceZipError
        ``UNKNOWN_NAME``: a number that is not kept.
    """

    def number(found: re.Match[str]) -> str:
        _, decimals, comment, source = found.groups()
        above, _, below = source.partition(" / ")
        value = number_of(above, rows, figures) / (number_of(below, rows, figures) if below else 1)
        return f"{value:.{len(decimals or '')}f}{comment}"

    return NUMBER.sub(number, text)


def number_of(source: str, rows: Mapping[str, Row], figures: Mapping[str, Figure]) -> float:
    """The number of ``character/size/method/column``, or of a figure's key; bytes in MB."""
    key, _, column = source.rpartition("/")
    if source in figures:
        value: float | None = figures[source].value
    else:
        value = getattr(rows[key], column) if key in rows and column in COLUMNS else None
    if value is None:
        reason = "benchmarks/ has no such figure; name a row and a column, or a figure of an answer"
        raise FaceZipError(ErrorCode.UNKNOWN_NAME, f"kept {source}: {reason}")
    return float(value) / (1e6 if column.startswith("bytes") else 1)
