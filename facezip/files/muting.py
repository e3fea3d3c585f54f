"""Keeping libraries from the terminal while they read and write images: libpng and libtiff speak for themselves."""

import os
from contextlib import suppress
from threading import Lock


class _MutedStderr:
    """The process's second descriptor, as a context in which nothing comes out of it: the error says it, once.

    It belongs to all threads: the first one redirects it, the last one restores it.
    """

    def __init__(self) -> None:
        self._lock, self._inside, self._kept = Lock(), 0, -1

    def __enter__(self) -> None:
        with self._lock:
            self._inside += 1
            if self._inside == 1:
                self._begin()

    def __exit__(self, *_: object) -> None:
        with self._lock:
            self._inside -= 1
            if self._inside == 0:
                self.end()

    def _begin(self) -> None:
        """Where no descriptor is left, what libraries say is seen."""
        with suppress(OSError), open(os.devnull, "wb") as nowhere:
            self._kept = os.dup(2)
            os.dup2(nowhere.fileno(), 2)

    def end(self) -> None:
        """Restore the descriptor whatever threads are at: for the last words, as Ctrl-C may come in between."""
        kept, self._kept = self._kept, -1
        if kept >= 0:
            os.dup2(kept, 2)
            os.close(kept)


muted_stderr = _MutedStderr()
