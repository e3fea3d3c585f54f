"""Table 1 as tables of a page: times, memory and errors, the paper's own figures in small print."""

from collections.abc import Sequence

from reports.metrics import megabytes, number
from reports.paper.documents.figures import TableRow
from reports.paper.documents.paper import PaperDocument, PublishedRow
from reports.paper.methods import METHODS
from reports.tables import Cell, Row, Table

STEPS = {
    "masks": ("Masks", ""),
    "clustering": ("Clustering", "Gram matrices and k-means"),
    "stitching": ("Stitching", "the paper’s permutation: table of costs and random starts"),
    "factorisation": ("Factorisation", "difference textures and weight maps"),
}
COMPARED = ("pca_4", "pca_8", "paper", "refined")


def times(document: PaperDocument) -> Table:
    """Seconds by step and method, and by size."""
    rows = document.table_1
    lines = [Row(label, _times(document, step), note) for step, (label, note) in STEPS.items()]
    lines.append(Row("Paper, all steps", _times(document, "paper"), strong=True))
    ours = "in the place of the paper’s: the same table of costs and our search"
    lines.append(Row("Stitching, optimised", _times(document, "stitching_optimised"), ours))
    lines += [
        Row(METHODS[key].label, _times(document, key), strong=key == "refined") for key in COMPARED if key != "paper"
    ]
    caption = (
        f"Seconds of one run for {rows[0].expressions} expressions on {document.conditions.cores} cores. "
        f"In small print the paper’s own figures, from another machine ({document.published.machine})."
    )
    return Table(caption, "Time, s", _columns(document), tuple(lines))


def memory(document: PaperDocument) -> Table:
    """GPU memory by method and size, for this character and for the paper's 51 expressions."""
    rows, published = document.table_1, document.published
    lines = []
    for key in ("raw", *COMPARED):
        fetches = f"{rows[0].fetches.get(key, rows[0].expressions + 1)} fetches a pixel"
        cells = tuple(
            Cell(megabytes(row.bytes_on_gpu[key]), _of_51(row, key, _published(document, row))) for row in rows
        )
        label = METHODS[key].label if key in METHODS else "Raw textures"
        lines.append(Row(label, cells, fetches, key == "refined"))
    caption = (
        f"GPU memory of the neutral and {rows[0].expressions} expressions at 8 bits a channel; 1 MB is 10⁶ bytes. "
        f"In small print the same for the paper’s {published.expressions_in_memory} expressions, and what it prints."
    )
    return Table(caption, "GPU memory, MB", _columns(document), tuple(lines))


def errors(document: PaperDocument) -> Table:
    """Mean RMSE by method and size."""
    rows = document.table_1
    best = [min(row.rmse.values()) for row in rows]
    lines = []
    for key in COMPARED:
        values = [row.rmse[key] for row in rows]
        cells = tuple(Cell(number(value, 2), best=value == low) for value, low in zip(values, best, strict=True))
        lines.append(Row(METHODS[key].label, cells, strong=key == "refined"))
    region = document.conditions.texture_region
    caption = f"RMSE, 0 to 255, over {region}, mean over expressions; the paper’s Table 1 states no errors."
    return Table(caption, "RMSE, of 255", _columns(document), tuple(lines))


def size(resolution: Sequence[int]) -> str:
    """A texture's size: ``512²``, or ``512 × 256`` where it is not square."""
    height, width = resolution
    return f"{width}²" if width == height else f"{width} × {height}"


def _columns(document: PaperDocument) -> tuple[str, ...]:
    return tuple(size(row.resolution) for row in document.table_1)


def _times(document: PaperDocument, key: str) -> tuple[Cell, ...]:
    cells = []
    for row in document.table_1:
        published = _published(document, row)
        stated = published.seconds.get(key) if published else None
        cells.append(Cell(number(row.seconds[key], 2), "" if stated is None else f"paper {stated:,.0f}"))
    return tuple(cells)


def _of_51(row: TableRow, key: str, published: PublishedRow | None) -> str:
    ours, stated = megabytes(row.bytes_on_gpu_of_51[key]), published.megabytes.get(key) if published else None
    return ours if stated is None else f"{ours}, paper\N{NO-BREAK SPACE}{number(stated, 2)}"


def _published(document: PaperDocument, row: TableRow) -> PublishedRow | None:
    """What the paper prints at the size of a row, where it does."""
    return next((one for one in document.published.table_1 if one.resolution == row.resolution), None)
