"""A process that makes calls for this one, whose death is told apart from what a call raises."""

import os
import signal
import traceback
from collections import Counter
from multiprocessing import get_context
from multiprocessing.connection import Connection
from threading import Lock
from typing import Any

from facezip.errors import ErrorCode, FaceZipError
from facezip.machine import telling
from facezip.machine.telling import Told

# Ends of a process by its own fault; the system ends one for memory by SIGKILL.
CRASHES = (signal.SIGSEGV, signal.SIGABRT, signal.SIGILL, signal.SIGFPE, signal.SIGBUS)
# Between two looks at a process that says nothing.
SECOND = 1.0


class Died(Exception):
    """A process is gone; in words, what became of it.

    Parameters
    ----------
    code : its exit code, or minus the signal that ended it.
    files : at which it was.
    silent : for how many seconds it had told nothing when it was ended therefore; 0 where it was not.
    """

    def __init__(self, code: int | None, files: list[str], silent: int = 0) -> None:
        super().__init__(f"did not go on for {silent} s" if silent else _ending(code))
        self.files = files
        self.for_memory = not silent and code == -signal.SIGKILL


def _ending(code: int | None) -> str:
    if code is None or code >= 0:
        return f"ended with code {code}"
    name = signal.Signals(-code).name
    if -code in CRASHES:
        return f"crashed ({name})"
    return f"was ended ({name}){', most likely for memory' if -code == signal.SIGKILL else ''}"


class Worker:
    """One fresh process that makes calls, one at a time. Functions, arguments, results and exceptions are pickled."""

    def __init__(self) -> None:
        context = get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs,), daemon=True)
        try:
            self._process.start()
        except OSError as error:
            raise MemoryError(f"no other process can be started: {error}") from None
        # Only where the process holds the sole other end does its death close the pipe.
        theirs.close()
        self._files = Counter[str]()

    def call(self, call: Any, patience: int | None = None) -> Any:
        """What a function, its arguments and its keywords return; raises what it raises.

        Parameters
        ----------
        call : the three.
        patience : seconds for which it may tell nothing while it is at a file; None for any time.

        Raises
        ------
        Died
            The process has ended.
        """
        try:
            self._pipe.send(call)
            value, error = self._answer(patience)
        except (EOFError, OSError):
            raise Died(self.end(), self._at()) from None
        if error is not None:
            raise error
        return value

    def kill(self) -> None:
        """End the process in the middle of a call."""
        self._process.kill()

    def end(self) -> int | None:
        """End the process where it still runs; its exit code, or minus the signal that ended it."""
        self._process.kill()
        self._process.join()
        self._pipe.close()
        return self._process.exitcode

    def _answer(self, patience: int | None) -> tuple[Any, Exception | None]:
        self._files.clear()
        silent = 0
        while True:
            # Looks are counted, not seconds: a machine that sleeps, or a run that is stopped, looks no more.
            if not self._pipe.poll(None if patience is None else SECOND):
                silent = silent + 1 if self._at() else 0
                if patience is not None and silent >= patience:
                    raise Died(self.end(), self._at(), silent)
                continue
            said = self._pipe.recv()
            if not isinstance(said, Told):
                answer: tuple[Any, Exception | None] = said
                return answer
            silent = 0
            self._files[said.file] += said.begun

    def _at(self) -> list[str]:
        return sorted(file for file, times in self._files.items() if times > 0)


def worker_lost(died: Died | None = None, times: str = "") -> FaceZipError:
    """The error for a task that ends the process which does it.

    Parameters
    ----------
    died : how the last one ended; None where that is not known, as of another machine.
    times : how often it was tried, in words that follow a word.
    """
    what = "was ended, most likely for memory" if died is None else str(died)
    if died is None or died.for_memory:
        return FaceZipError(ErrorCode.WORKER_LOST, f"its process{times} {what}; use fewer workers or smaller textures")
    at = f"at {' or '.join(died.files)}" if died.files else "most likely in a library that decodes its images"
    remedy = "export its images anew, and please report it with them"
    return FaceZipError(ErrorCode.WORKER_LOST, f"its process{times} {what}, {at}; {remedy}")


def _serve(pipe: Connection) -> None:
    """Answer calls until the other side is gone."""
    # Ctrl-C in a terminal reaches all processes; the one that started this has something to say about it.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    lock = Lock()

    def send(what: Any) -> None:
        with lock:
            try:
                pipe.send(what)
            except OSError:
                # Whoever asked is gone.
                os._exit(1)

    telling.tell_by(send)
    while True:
        try:
            function, args, kwargs = pipe.recv()
        except EOFError:
            return
        answer: tuple[Any, Exception | None]
        try:
            answer = function(*args, **kwargs), None
        except FaceZipError as error:
            answer = None, error
        except MemoryError as error:
            answer = None, MemoryError(str(error))
        except Exception as error:
            # Whatever it is, it can be pickled now; where it came from would be lost.
            told = RuntimeError(f"{type(error).__name__}: {error}")
            told.add_note("".join(traceback.format_exception(error)))
            answer = None, told
        send(answer)
