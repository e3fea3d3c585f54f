"""What a run says at its end."""

from pathlib import Path
from typing import Any

import pytest

from facezip.names import printable
from render.plugin.run import Run
from render.plugin.words import place

# A screen holds no more.
MOST_SHOWN = 4
CHANGES = {"new": "new", "added": "added to those that are accepted", "changed": "changed", "same": "as it was"}


def report(terminal: pytest.TerminalReporter, run: Run) -> None:
    """Say what is wrong with the run, what was generated, and where evidence and summaries are."""
    settings = run.settings
    _show(terminal, run)
    for line in [*_generated(run), *_warned(run)]:
        terminal.write_line(line)
    colour = {"yellow": True} if settings.allow_stale else {"red": True}
    for line in [*_stale(run), *_idle(run)]:
        terminal.write_line(line, **colour)
    if any("evidence" in result for result in run.results) or settings.summaries:
        terminal.write_line(f"facezip: results in {settings.results}")
    if settings.markdown:
        terminal.write_line(f"facezip: summary in {settings.markdown}")


def _show(terminal: pytest.TerminalReporter, run: Run) -> None:
    """The pictures of the first failures, where the terminal shows pictures."""
    failed = [result for result in run.results if result["outcome"] == "failed" and "evidence" in result]
    if not failed or run.settings.pictures == "none" or not (run.settings.pictures or terminal.isatty):
        return
    from render.plugin.pictures import kind_of, shown

    kind = run.settings.pictures or kind_of()
    for result in failed[:MOST_SHOWN] if kind else []:
        terminal.write_line(f"{result['name']}: image, reference, error, p")
        terminal.write(shown(Path(result["evidence"]), kind))
        terminal.line("")


def _generated(run: Run) -> list[str]:
    made = [result for result in run.results if result["outcome"] == "generated"]
    if not made:
        return []
    where = f" to {run.settings.into}" if run.settings.into else ""
    return [f"facezip: {len(made)} references written{where}", *(line for result in made for line in _change(result))]


def _change(result: dict[str, Any]) -> list[str]:
    """A reference that is not what it was, before and after."""
    if result["change"] == "same":
        return []
    lines = [f"  {result['name']}: {CHANGES[result['change']]}"]
    if "before" in result:
        lines[0] += f", sha256 {result['before'][:12]}… before, {result['after'][:12]}… after"
    if "probability" in result:
        values = f"{result['reference_image']:.4g} before, {result['image']:.4g} after"
        lines.append(f"    p = {result['probability']:.1e}; most in {place(result)}: {values}")
    if "evidence" in result:
        lines.append(f"    both in {result['evidence']}: reference is before, image after")
    return lines


def _warned(run: Run) -> list[str]:
    warned = [result for result in run.results if result["outcome"] == "warned"]
    lines = [f"  {result['name']}: p = {result['probability']:.1e}, {place(result)}" for result in warned]
    head = f"facezip: {len(warned)} images pass and are less likely than the level of warnings"
    return [head, *lines] if lines else []


def _stale(run: Run) -> list[str]:
    if not run.stale:
        return []
    lines = [
        f"  {printable(one['reference'])}, made by {printable(one['test']) or 'tests that shared it'}"
        for one in run.stale
    ]
    count = f"{len(run.stale)} references have no test" if len(run.stale) > 1 else "a reference has no test"
    return [f"facezip: {count}; remove what is not needed, or add --facezip-allow-stale", *lines]


def _idle(run: Run) -> list[str]:
    if not run.idle:
        return []
    asked = f"{run.idle} tests ask" if run.idle > 1 else "1 test asks"
    return [f"facezip: {asked} for facezip_image, and this run compared nothing; --facezip-allow-stale lets it pass"]
