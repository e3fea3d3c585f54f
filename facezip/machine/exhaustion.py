"""Memory that ends in a thread: the thread cannot say so any more, and whoever waits for it would wait for ever."""

import logging
import os
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import NoReturn

# What CPython says where a thread ends before it has begun: Thread.start waits for it, without a limit.
UNBEGUN = "in thread started by"


@contextmanager
def ended_where_threads_cannot_go_on(status: int, message: bytes, answer: bytes = b"") -> Iterator[None]:
    """Inside, end the process where a thread has no memory to begin, to work, or to say what became of its work.

    What is being written is left behind, as by a killed process: the next run takes it away.

    Parameters
    ----------
    status : the exit code.
    message, answer : what standard error and standard output get then; made before, since then nothing can be.
    """

    def end() -> NoReturn:
        os.write(2, message)
        os.write(1, answer)
        os._exit(status)

    unbegun, failed = sys.unraisablehook, threading.excepthook

    def on_unbegun(ignored: "sys.UnraisableHookArgs") -> None:
        if UNBEGUN in (ignored.err_msg or "") and _of_memory(ignored.exc_value):
            end()
        unbegun(ignored)

    def on_failed(arguments: threading.ExceptHookArgs) -> None:
        if _of_memory(arguments.exc_value):
            end()
        failed(arguments)

    # A thread of a pool that cannot hand over a result logs it and ends; nobody else is told.
    pools, exhausted = logging.getLogger("concurrent.futures"), _Exhausted(end)
    sys.unraisablehook, threading.excepthook = on_unbegun, on_failed
    pools.addFilter(exhausted)
    try:
        yield
    finally:
        sys.unraisablehook, threading.excepthook = unbegun, failed
        pools.removeFilter(exhausted)


class _Exhausted(logging.Filter):
    def __init__(self, end: Callable[[], NoReturn]) -> None:
        super().__init__()
        self._end = end

    def filter(self, record: logging.LogRecord) -> bool:
        if record.exc_info and _of_memory(record.exc_info[1]):
            self._end()
        return True


def _of_memory(error: BaseException | None) -> bool:
    """Whether it is one of memory, or came up while one was handled, as in the end of a thread that has not begun."""
    while error is not None:
        if isinstance(error, MemoryError):
            return True
        error = error.__context__
    return False
