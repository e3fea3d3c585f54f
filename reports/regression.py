"""The page of an image test: every comparison with its reference, failures first, with the pictures of each."""

import base64
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from facezip.machine.progress import track
from reports.page import write_page
from reports.tables import Cell, Row, Table

OUTCOMES = {"failed": "Failed", "passed": "Passed", "generated": "Generated"}
PICTURES = {
    "image": "Image",
    "reference": "Reference",
    "error": "Error",
    "p_value": "Probability",
}


@dataclass(frozen=True)
class Card:
    """One comparison: its result, and label and data URI of each picture that it left."""

    result: Mapping[str, Any]
    pictures: tuple[tuple[str, str], ...]


def write_regression_report(document: Mapping[str, Any], path: Path) -> Path:
    """Write the page of the results of a run, self-contained, whole or not at all.

    Parameters
    ----------
    document : ``results``, each with ``name``, ``test``, ``outcome``, and for a comparison ``probability``, ``level``,
        ``deviations``, ``reference``; ``evidence`` is the folder of its pictures, ``message`` what a failure says.

    Raises
    ------
    FaceZipError
        ``CANNOT_WRITE``.
    """
    order = list(OUTCOMES)
    results = sorted(document["results"], key=lambda result: (order.index(result["outcome"]), result["name"]))
    counts = {outcome: sum(result["outcome"] == outcome for result in results) for outcome in OUTCOMES}
    cards = [_card(result) for result in track(results, "Embedding pictures", len(results))]
    return write_page(
        path,
        "regression.html",
        document=document,
        title="FaceZip image tests",
        headline=_headline(counts),
        cards=[card for card in cards if card.pictures or card.result["outcome"] == "failed"],
        table=_table(results),
        outcomes=OUTCOMES,
    )


def _card(result: Mapping[str, Any]) -> Card:
    folder = Path(result["evidence"]) if "evidence" in result else None
    files = {label: folder / f"{name}.png" for name, label in PICTURES.items()} if folder else {}
    return Card(result, tuple((label, _data_uri(file)) for label, file in files.items() if file.is_file()))


def _data_uri(file: Path) -> str:
    return "data:image/png;base64," + base64.b64encode(file.read_bytes()).decode("ascii")


def _headline(counts: Mapping[str, int]) -> str:
    images = {outcome: f"{count} image{'s' * (count != 1)}" for outcome, count in counts.items()}
    if counts["failed"]:
        compared = counts["failed"] + counts["passed"]
        return f"{counts['failed']} of {compared} differ from their references by more than render noise"
    parts = [f"{images['passed']} as their references show them"] if counts["passed"] else []
    parts += [f"{images['generated']} generated"] if counts["generated"] else []
    return ", ".join(parts) or "No image was compared"


def _table(results: list[Mapping[str, Any]]) -> Table:
    rows = tuple(
        Row(result["name"], _cells(result), result["test"], strong=result["outcome"] == "failed") for result in results
    )
    columns = ("outcome", "p", "level", "largest deviation", "renders")
    return Table("Every image, failures first", "image", columns, rows)


def _cells(result: Mapping[str, Any]) -> tuple[Cell, ...]:
    if "probability" not in result:
        count = str(result.get("renders", "–"))
        return Cell(OUTCOMES[result["outcome"]]), Cell("–"), Cell("–"), Cell("–"), Cell(count)
    return (
        Cell(OUTCOMES[result["outcome"]]),
        Cell(f"{result['probability']:.2g}"),
        Cell(f"{result['level']:g}"),
        Cell(f"{abs(result['deviations']):.1f} standard errors", f"blocks of {result['side']} px"),
        Cell(str(result["renders"])),
    )
