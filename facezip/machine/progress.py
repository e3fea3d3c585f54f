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


@contextmanager
def show_progress() -> Iterator[None]:
    """Draw bars for every ``task`` and ``track`` inside; only when stderr is a terminal."""
    if not sys.stderr.isatty():
        yield
        return
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bars:
        token = _bars.set(bars)
        try:
            yield
        finally:
            _bars.reset(token)


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
