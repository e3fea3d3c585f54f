"""Progress bars on standard error, silent unless the command line switches them on."""

import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TypeVar

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

Item = TypeVar("Item")
_bars: ContextVar[Progress | None] = ContextVar("bars", default=None)
# The same for threads that others started, and what they have said.
_shown: list[Progress] = []
_said: set[str] = set()


@contextmanager
def show_progress() -> Iterator[None]:
    """Draw bars for every ``task`` and ``track`` inside; only when stderr is a terminal."""
    if not sys.stderr.isatty():
        yield
        return
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bars:
        token = _bars.set(bars)
        _shown.append(bars)
        try:
            yield
        finally:
            _shown.pop()
            _bars.reset(token)


@contextmanager
def left_alone() -> Iterator[None]:
    """Draw no bars inside: another process draws its own on the terminal."""
    bars = _bars.get()
    if bars is None:
        yield
        return
    bars.stop()
    try:
        yield
    finally:
        # It shows the cursor again too, which a process that was killed has hidden.
        bars.start()


def say_once(words: str) -> None:
    """A line above the bars, from any thread, where bars are drawn and it has not been said."""
    if _shown and words not in _said:
        _said.add(words)
        _shown[-1].console.print(words)


@contextmanager
def task(description: str, total: int) -> Iterator[Callable[[], None]]:
    """Announce ``total`` steps of work; call the yielded function after each of them."""
    bars = _bars.get()
    if bars is None:
        yield lambda: None
        return
    bar = bars.add_task(description, total=total)
    try:
        yield lambda: bars.advance(bar)
    finally:
        bars.remove_task(bar)


def track(items: Iterable[Item], description: str, total: int) -> Iterator[Item]:
    """Iterate over ``items``, of which there are ``total``, behind a progress bar."""
    with task(description, total) as advance:
        for item in items:
            yield item
            advance()
