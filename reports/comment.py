"""The results of an image test as Markdown, short enough for the comment on a change."""

from collections.abc import Sequence
from pathlib import Path

from facezip.files.writing import write_whole
from facezip.names import printable
from render.plugin.results import ImagesDocument, Outcome, Result, Written
from reports.regression import CHANGES, OUTCOMES, counted, headline

# Hosts of code refuse comments beyond some 65,000 characters.
MOST_ROWS = 50


def write_comment(document: ImagesDocument, path: Path) -> Path:
    """Write :func:`comment` into a file, whole or not at all; raises ``FaceZipError`` (``CANNOT_WRITE``)."""
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, comment(document).encode(errors="backslashreplace"))
    return path


def comment(document: ImagesDocument) -> str:
    """What failed, what is close to it, what was changed before and after, and which references have no test."""
    results = document.results
    counts = counted(results)
    parts = [
        f"### FaceZip image tests: {headline(document, counts)}",
        ", ".join(f"{count} {OUTCOMES[outcome].lower()}" for outcome, count in counts.items() if count),
        _section("Failed", ("image", "p", "level", "worst place"), [_row(one) for one in _of(results, "failed")]),
        _section("Warned", ("image", "p", "level", "worst place"), [_row(one) for one in _of(results, "warned")]),
        _section(
            "References written",
            ("image", "change", "before", "after"),
            [_change(one, one.written) for one in results if one.written and one.written.change != "same"],
        ),
        _section(
            "References without a test",
            ("reference", "made by"),
            [(_code(one.reference), _code(one.test or "several tests")) for one in document.stale],
        ),
    ]
    if document.idle:
        parts.append(f"{document.idle} tests ask for images and none compared any.")
    return "\n\n".join(filter(None, parts)) + "\n"


def _of(results: Sequence[Result], outcome: Outcome) -> list[Result]:
    return [result for result in results if result.outcome == outcome]


def _row(result: Result) -> tuple[str, ...]:
    name = _code(result.name)
    if result.comparison is None:
        first = (result.message or "").partition("\n")[0]
        return name, "–", "–", _code(first.removeprefix(f"{result.name}: "))
    place = result.comparison.place
    where = f"row {place.row}, column {place.column}, {place.side} px"
    values = f"{place.image:.4g} instead of {place.reference:.4g}"
    words = "agrees, though it must differ" if result.must_differ else f"{where}: {values}"
    return name, f"{result.comparison.probability:.1e}", f"{result.level:g}", words


def _change(result: Result, written: Written) -> tuple[str, ...]:
    before, after = _code(written.before[:12]) if written.before else "–", _code(written.after[:12])
    if result.comparison:
        place = result.comparison.place
        before, after = f"{before} {place.reference:.4g}", f"{after} {place.image:.4g}"
    return _code(result.name), CHANGES[written.change], before, after


def _section(title: str, columns: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    if not rows:
        return ""
    lines = [f"**{title}**", "", _line(columns), _line(("---",) * len(columns)), *map(_line, rows[:MOST_ROWS])]
    more = len(rows) - MOST_ROWS
    return "\n".join([*lines, *(["", f"and {more} more"] if more > 0 else [])])


def _line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _code(text: str) -> str:
    """Text as it is: names are the users', and a host of code would follow their links and mentions."""
    shown = printable(text).replace("|", "\\|").replace("`", "ˋ")
    return f"`{shown}`"
