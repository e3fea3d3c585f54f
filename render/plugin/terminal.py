"""What a run says at its end."""

from collections.abc import Mapping
from pathlib import Path

import pytest

from facezip.names import printable
from render.plugin.results import Change, Result, Written
from render.plugin.run import Run
from render.plugin.words import where

# A screen holds no more.
MOST_SHOWN = 4
# Of those that are no longer what they were.
CHANGES: Mapping[Change, str] = {"new": "new", "added": "added to those that are accepted", "changed": "changed"}


def report(terminal: pytest.TerminalReporter, run: Run) -> None:
    """Say what is wrong with the run, what was generated, and where evidence and summaries are."""
    settings = run.settings
    _show(terminal, run)
    for line in [*_generated(run), *_warned(run)]:
        terminal.write_line(line)
    colour = {"yellow": True} if settings.allow_stale else {"red": True}
    for line in [*_stale(run), *_idle(run)]:
        terminal.write_line(line, **colour)
    if any(result.evidence for result in run.results) or settings.summaries:
        terminal.write_line(f"facezip: results in {settings.results}")
    if settings.markdown:
        terminal.write_line(f"facezip: summary in {settings.markdown}")


def _show(terminal: pytest.TerminalReporter, run: Run) -> None:
    """The pictures of the first failures, where the terminal shows pictures."""
    failed = [(one.name, one.evidence) for one in run.results if one.outcome == "failed" and one.evidence]
    if not failed or run.settings.pictures == "none" or not (run.settings.pictures or terminal.isatty):
        return
    from render.plugin.pictures import kind_of, shown

    kind = run.settings.pictures or kind_of()
    for name, evidence in failed[:MOST_SHOWN] if kind else []:
        terminal.write_line(f"{name}: image, reference, error, p")
        terminal.write(shown(Path(evidence), kind))
        terminal.line("")


def _generated(run: Run) -> list[str]:
    made = [(one, one.written) for one in run.results if one.written]
    if not made:
        return []
    folder = f" to {run.settings.into}" if run.settings.into else ""
    changes = (line for one, written in made for line in _change(one, written))
    return [f"facezip: {len(made)} references written{folder}", *changes]


def _change(result: Result, written: Written) -> list[str]:
    """A reference that is not what it was, before and after."""
    if written.change not in CHANGES:
        return []
    lines = [f"  {result.name}: {CHANGES[written.change]}"]
    if written.before:
        lines[0] += f", sha256 {written.before[:12]}… before, {written.after[:12]}… after"
    if result.comparison:
        place = result.comparison.place
        values = f"{place.reference:.4g} before, {place.image:.4g} after"
        lines.append(f"    p = {result.comparison.probability:.1e}; most in {where(place)}: {values}")
    if result.evidence:
        lines.append(f"    both in {result.evidence}: reference is before, image after")
    return lines


def _warned(run: Run) -> list[str]:
    warned = [(one.name, one.comparison) for one in run.results if one.outcome == "warned" and one.comparison]
    lines = [f"  {name}: p = {found.probability:.1e}, {where(found.place)}" for name, found in warned]
    head = f"facezip: {len(warned)} images pass and are less likely than the level of warnings"
    return [head, *lines] if lines else []


def _stale(run: Run) -> list[str]:
    if not run.stale:
        return []
    lines = [
        f"  {printable(one.reference)}, made by {printable(one.test) or 'tests that shared it'}" for one in run.stale
    ]
    count = f"{len(run.stale)} references have no test" if len(run.stale) > 1 else "a reference has no test"
    return [f"facezip: {count}; remove what is not needed, or add --facezip-allow-stale", *lines]


def _idle(run: Run) -> list[str]:
    if not run.idle:
        return []
    asked = f"{run.idle} tests ask" if run.idle > 1 else "1 test asks"
    return [f"facezip: {asked} for facezip_image, and this run compared nothing; --facezip-allow-stale lets it pass"]
