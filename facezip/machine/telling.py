"""What a process that works for another one tells it meanwhile: which file it is at, and that it goes on.

Should it die, or go on no more, the other one knows at which file. In a process of its own nothing is told.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Told:
    """One thing that is told.

    Attributes
    ----------
    file : which one; "" where work goes on at any.
    begun : 1 where the process comes to the file, -1 where it leaves it.
    """

    file: str = ""
    begun: int = 0


_send: Callable[[Told], None] | None = None


def tell_by(send: Callable[[Told], None]) -> None:
    """Tell everything by this call from now on; threads call it side by side."""
    global _send
    _send = send


@contextmanager
def at(file: Path) -> Iterator[None]:
    """Tell that what happens in the block happens at a file."""
    _tell(Told(str(file), 1))
    try:
        yield
    finally:
        _tell(Told(str(file), -1))


def go_on() -> None:
    """Tell that the work goes on."""
    _tell(Told())


def _tell(told: Told) -> None:
    if _send is not None:
        _send(told)
