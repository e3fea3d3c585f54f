"""Kept figures as CSV: a dataclass a row, in a file that anybody can read and compare line by line."""

import csv
import io
from collections.abc import Iterable, Mapping
from dataclasses import fields
from pathlib import Path
from typing import TypeVar

import msgspec

from facezip.files.writing import write_whole

R = TypeVar("R")


def read_table(path: Path, kind: type[R]) -> list[R]:
    """The rows of a file, an empty cell being the default of its field; none where there is no file yet."""
    if not path.is_file():
        return []
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    return [msgspec.convert({name: cell for name, cell in row.items() if cell}, kind, strict=False) for row in rows]


def write_table(path: Path, kind: type, rows: Iterable[Mapping[str, object]]) -> None:
    """Write the cells of rows under the names of the fields of ``kind``; raises ``CANNOT_WRITE``."""
    text = io.StringIO()
    table = csv.DictWriter(text, [field.name for field in fields(kind)], lineterminator="\n")
    table.writeheader()
    table.writerows(rows)
    write_whole(path, text.getvalue().encode())
