"""Numbers of the documentation that come from the kept figures.

A comment after a number says where it comes from, and a page shows nothing of it:
``1.19<!--kept embedded/512/refined/rmse-->``. Two of them with `` / `` between are their ratio. Bytes are in MB;
each number keeps the decimals that it is written with.
"""

import re
from collections.abc import Mapping
from pathlib import Path

from facezip.errors import ErrorCode, FaceZipError
from reports.kept.rows import COLUMNS, Row
from reports.site import BESIDE, ROOT

NUMBER = re.compile(r"(\d+(?:\.(\d+))?)(\**<!--kept ([^>]+)-->)")


def pages() -> list[Path]:
    """All pages of the documentation."""
    return [*sorted((ROOT / "docs").glob("*.md")), *(ROOT / name for name in BESIDE)]


def renewed(text: str, rows: Mapping[str, Row]) -> str:
    """A page with the numbers of ``rows``, by :attr:`reports.kept.rows.Row.key`.

    Raises
    ------
    FaceZipError
        ``UNKNOWN_NAME``: a row or a column that there is not.
    """

    def number(found: re.Match[str]) -> str:
        _, decimals, comment, source = found.groups()
        above, _, below = source.partition(" / ")
        value = figure(above, rows) / (figure(below, rows) if below else 1)
        return f"{value:.{len(decimals or '')}f}{comment}"

    return NUMBER.sub(number, text)


def figure(source: str, rows: Mapping[str, Row]) -> float:
    """The number of ``character/size/method/column``; bytes in MB."""
    key, _, column = source.rpartition("/")
    if key not in rows or column not in COLUMNS:
        raise FaceZipError(
            ErrorCode.UNKNOWN_NAME, f"kept {source}: benchmarks/results.csv has no such figure; name a row and a column"
        )
    value = getattr(rows[key], column)
    return float(value) / (1e6 if column.startswith("bytes") else 1)
