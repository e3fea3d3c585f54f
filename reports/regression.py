"""The page of an image test: every comparison with its reference, failures first, with the pictures of each."""

import base64
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from facezip.machine.progress import track
from reports.page import write_page
from reports.tables import Cell, Row, Table

OUTCOMES = {"failed": "Failed", "warned": "Warned", "generated": "Generated", "passed": "Passed"}
PICTURES = {
    "image": "Image",
    "reference": "Reference",
    "error": "Error",
    "p_value": "Probability",
}
CHANGES = {"new": "new", "added": "added beside others", "changed": "changed", "same": "as it was"}


@dataclass(frozen=True)
class Card:
    """One comparison: its result, and the data URI of each picture that it left, by the names of :data:`PICTURES`."""

    result: Mapping[str, Any]
    pictures: Mapping[str, str]


def write_regression_report(document: Mapping[str, Any], path: Path) -> Path:
    """Write the page of the results of a run, self-contained, whole or not at all.

    Parameters
    ----------
    document : ``results``, each with ``name``, ``test``, ``outcome``, and for a comparison ``probability``, ``level``,
        ``deviations``, ``reference``; ``evidence`` is the folder of its pictures, ``message`` what a failure says;
        ``stale``, references without a test, and ``idle``, the number of tests that compared nothing where none did.

    Raises
    ------
    FaceZipError
        ``CANNOT_WRITE``.
    """
    order = list(OUTCOMES)
    results = sorted(document["results"], key=lambda result: (order.index(result["outcome"]), result["name"]))
    counts = counted(results)
    cards = [_card(result) for result in track(results, "Embedding pictures", len(results))]
    return write_page(
        path,
        "regression.html",
        document=document,
        title="FaceZip image tests",
        headline=headline(document, counts),
        cards=[card for card in cards if card.pictures or card.result["outcome"] == "failed"],
        table=_table(results),
        outcomes=OUTCOMES,
        labels=PICTURES,
        changes=CHANGES,
        counts=counts,
    )


def _card(result: Mapping[str, Any]) -> Card:
    folder = Path(result["evidence"]) if "evidence" in result else None
    files = {name: folder / f"{name}.png" for name in PICTURES} if folder else {}
    return Card(result, {name: _data_uri(file) for name, file in files.items() if file.is_file()})


def _data_uri(file: Path) -> str:
    return "data:image/png;base64," + base64.b64encode(file.read_bytes()).decode("ascii")


def counted(results: Iterable[Mapping[str, Any]]) -> dict[str, int]:
    """How many results have each outcome."""
    outcomes = [result["outcome"] for result in results]
    return {outcome: outcomes.count(outcome) for outcome in OUTCOMES}


def headline(document: Mapping[str, Any], counts: Mapping[str, int]) -> str:
    """A run in one sentence: what is wrong with it, or what it did."""
    images = {outcome: f"{count} image{'s' * (count != 1)}" for outcome, count in counts.items()}
    compared = counts["failed"] + counts["passed"] + counts["warned"]
    parts = [f"{counts['failed']} of {compared} {_wrong(document['results'])}"] if counts["failed"] else []
    stale = len(document.get("stale", ()))
    parts += [f"{stale} reference{'s' * (stale != 1)} without a test"] if stale else []
    if not parts and counts["passed"] + counts["warned"]:
        passed = counts["passed"] + counts["warned"]
        parts = [f"{passed} image{'s' * (passed != 1)} as their references show them"]
    parts += [f"{images['generated']} generated"] if counts["generated"] else []
    return ", ".join(parts) or "No image was compared"


def _wrong(results: Iterable[Mapping[str, Any]]) -> str:
    failed = [result for result in results if result["outcome"] == "failed"]
    differ = all(result.get("probability", 1) < result.get("level", 0) for result in failed)
    return "differ from their references by more than render noise" if differ else "failed"


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
