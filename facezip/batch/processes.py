"""A pool of processes in which the death of one costs the call that it was at, and that call is made again.

The standard library's ``ProcessPoolExecutor`` gives up every call that is waiting when one process dies.
"""

import signal
import threading
import traceback
from collections.abc import Callable
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from multiprocessing import get_context
from multiprocessing.connection import Connection
from typing import Any, ParamSpec, TypeVar

from facezip.errors import ErrorCode, FaceZipError

Result = TypeVar("Result")
Arguments = ParamSpec("Arguments")

# As many as dask's scheduler makes by default.
ATTEMPTS = 4
# Ends of a process by its own fault; the system ends one for memory by SIGKILL.
CRASHES = (signal.SIGSEGV, signal.SIGABRT, signal.SIGILL, signal.SIGFPE)


class ProcessWorkers(Executor):
    """Calls in ``count`` fresh processes, each at one call at a time.

    A call whose process dies is made again in a new one, ``ATTEMPTS`` times in all; then its future raises
    ``WORKER_LOST``. Functions, arguments, results and exceptions are pickled.
    """

    def __init__(self, count: int) -> None:
        self._threads = ThreadPoolExecutor(count)
        self._mine = threading.local()
        self._workers: set[_Worker] = set()
        self._lock, self._closed = threading.Lock(), False

    def submit(
        self, fn: Callable[Arguments, Result], /, *args: Arguments.args, **kwargs: Arguments.kwargs
    ) -> Future[Result]:
        """Call ``fn`` in the next process that is free."""
        return self._threads.submit(self._call, fn, args, kwargs)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the processes once all calls are made; with ``cancel_futures`` at once, in the middle of a call."""
        if cancel_futures:
            with self._lock:
                self._closed = True
                for worker in self._workers:
                    worker.kill()
        self._threads.shutdown(wait, cancel_futures=cancel_futures)
        with self._lock:
            for worker in self._workers:
                worker.end()
            self._workers.clear()

    def _call(self, *call: Any) -> Any:
        code = None
        for _ in range(ATTEMPTS):
            worker = self._worker()
            try:
                return worker.call(call)
            except _Died:
                code = self._forget(worker)
        raise worker_lost(code)

    def _worker(self) -> "_Worker":
        """The process of this thread."""
        worker: _Worker | None = getattr(self._mine, "worker", None)
        if worker is None:
            with self._lock:
                if self._closed:
                    raise RuntimeError("the pool is closed")
                worker = self._mine.worker = _Worker()
                self._workers.add(worker)
        return worker

    def _forget(self, worker: "_Worker") -> int | None:
        """How the process of this thread ended, as ``multiprocessing.Process.exitcode`` has it."""
        self._mine.worker = None
        with self._lock:
            self._workers.discard(worker)
        return worker.end()


def worker_lost(code: int | None = None) -> FaceZipError:
    """The error for a task that ends every process that begins it, with ``code`` where that is known."""
    if code is not None and -code in CRASHES:
        return FaceZipError(
            ErrorCode.WORKER_LOST,
            f"its process crashed in the middle, {ATTEMPTS} times ({signal.Signals(-code).name}), most likely in a "
            "library that decodes its images; export them anew, and please report it with the image",
        )
    return FaceZipError(
        ErrorCode.WORKER_LOST,
        f"its process was ended in the middle, {ATTEMPTS} times, most likely for memory; use fewer workers or smaller "
        "textures",
    )


class _Died(Exception):
    """The process is gone."""


class _Worker:
    """One process that makes calls."""

    def __init__(self) -> None:
        context = get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs,), daemon=True)
        self._process.start()
        # Only where the process holds the sole other end does its death close the pipe.
        theirs.close()

    def call(self, call: Any) -> Any:
        try:
            self._pipe.send(call)
            value, error = self._pipe.recv()
        except (EOFError, OSError):
            raise _Died from None
        if error is not None:
            raise error
        return value

    def kill(self) -> None:
        self._process.kill()

    def end(self) -> int | None:
        """End the process where it still runs; its exit code, or minus the signal that ended it."""
        self._process.kill()
        self._process.join()
        self._pipe.close()
        return self._process.exitcode


def _serve(pipe: Connection) -> None:
    """Answer calls until the other side is gone."""
    # Ctrl-C in a terminal reaches all processes; the one that started this has something to say about it.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
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
        except Exception as error:
            # Whatever it is, it can be pickled now; where it came from would be lost.
            told = RuntimeError(f"{type(error).__name__}: {error}")
            told.add_note("".join(traceback.format_exception(error)))
            answer = None, told
        pipe.send(answer)
