"""Tables as data; a template draws them."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Cell:
    """A number or a word, a smaller note under it, and whether it is the best of its row."""

    text: str
    note: str = ""
    best: bool = False
    share: float | None = None


@dataclass(frozen=True)
class Row:
    """A header and its cells; ``strong`` rows are those the page is about."""

    name: str
    cells: tuple[Cell, ...]
    note: str = ""
    strong: bool = False


@dataclass(frozen=True)
class Table:
    """A captioned table whose first column names the rows."""

    caption: str
    corner: str
    columns: tuple[str, ...]
    rows: tuple[Row, ...]
