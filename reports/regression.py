"""The page of an image test: every comparison with its reference, failures first, with the pictures of each."""

import base64
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from facezip.machine.progress import track
from render.plugin.results import Change, ImagesDocument, Outcome, Result
from reports.page import write_page
from reports.tables import Cell, Row, Table

OUTCOMES: Mapping[Outcome, str] = {"failed": "Failed", "warned": "Warned", "generated": "Generated", "passed": "Passed"}
PICTURES = {
    "image": "Image",
    "reference": "Reference",
    "error": "Error",
    "p_value": "Probability",
}
CHANGES: Mapping[Change, str] = {
    "new": "new",
    "added": "added beside others",
    "changed": "changed",
    "same": "as it was",
}


@dataclass(frozen=True)
class Card:
    """One comparison: its result, and the data URI of each picture that it left, by the names of :data:`PICTURES`."""

    result: Result
    pictures: Mapping[str, str]


def write_regression_report(document: ImagesDocument, path: Path) -> Path:
    """Write the page of the results of a run, self-contained, whole or not at all.

    Raises
    ------
    FaceZipError
        ``CANNOT_WRITE``.
    """
    order = list(OUTCOMES)
    results = sorted(document.results, key=lambda result: (order.index(result.outcome), result.name))
    counts = counted(results)
    cards = [_card(result) for result in track(results, "Embedding pictures", len(results))]
    return write_page(
        path,
        "regression.html",
        document=document,
        title="FaceZip image tests",
        headline=headline(document, counts),
        cards=[card for card in cards if card.pictures or card.result.outcome == "failed"],
        table=_table(results),
        outcomes=OUTCOMES,
        labels=PICTURES,
        changes=CHANGES,
        counts=counts,
    )


def _card(result: Result) -> Card:
    files = {name: Path(result.evidence) / f"{name}.png" for name in PICTURES} if result.evidence else {}
    return Card(result, {name: _data_uri(file) for name, file in files.items() if file.is_file()})


def _data_uri(file: Path) -> str:
    return "data:image/png;base64," + base64.b64encode(file.read_bytes()).decode("ascii")


def counted(results: Iterable[Result]) -> dict[Outcome, int]:
    """How many results have each outcome."""
    outcomes = [result.outcome for result in results]
    return {outcome: outcomes.count(outcome) for outcome in OUTCOMES}


def headline(document: ImagesDocument, counts: Mapping[Outcome, int]) -> str:
    """A run in one sentence: what is wrong with it, or what it did."""
    images = {outcome: f"{count} image{'s' * (count != 1)}" for outcome, count in counts.items()}
    compared = counts["failed"] + counts["passed"] + counts["warned"]
    parts = [f"{counts['failed']} of {compared} {_wrong(document.results)}"] if counts["failed"] else []
    stale = len(document.stale)
    parts += [f"{stale} reference{'s' * (stale != 1)} without a test"] if stale else []
    if not parts and counts["passed"] + counts["warned"]:
        passed = counts["passed"] + counts["warned"]
        parts = [f"{passed} image{'s' * (passed != 1)} as their references show them"]
    parts += [f"{images['generated']} generated"] if counts["generated"] else []
    return ", ".join(parts) or "No image was compared"


def _wrong(results: Iterable[Result]) -> str:
    differ = all(result.differs for result in results if result.outcome == "failed")
    return "differ from their references by more than render noise" if differ else "failed"


def _table(results: Sequence[Result]) -> Table:
    rows = tuple(Row(one.name, _cells(one), one.test, strong=one.outcome == "failed") for one in results)
    columns = ("outcome", "p", "level", "largest deviation", "renders")
    return Table("Every image, failures first", "image", columns, rows)


def _cells(result: Result) -> tuple[Cell, ...]:
    outcome, found = Cell(OUTCOMES[result.outcome]), result.comparison
    # Of the reference where one was written.
    made = result.written or found
    renders = Cell(str(made.renders) if made else "–")
    if found is None:
        return outcome, Cell("–"), Cell("–"), Cell("–"), renders
    worst = Cell(f"{abs(found.place.deviations):.1f} standard errors", f"blocks of {found.place.side} px")
    return outcome, Cell(f"{found.probability:.2g}"), Cell(f"{result.level:g}"), worst, renders
