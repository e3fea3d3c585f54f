"""A pool of processes in which the death of one costs the call that it was at, and that call is made again.

The standard library's ``ProcessPoolExecutor`` gives up every call that is waiting when one process dies.
"""

import threading
from collections.abc import Callable
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from typing import Any, ParamSpec, TypeVar

from facezip.machine.worker import Died, Worker, worker_lost

Result = TypeVar("Result")
Arguments = ParamSpec("Arguments")

# As many as dask's scheduler makes by default.
ATTEMPTS = 4


class ProcessWorkers(Executor):
    """Calls in ``count`` fresh processes, each at one call at a time.

    A call whose process dies is made again in a new one, ``ATTEMPTS`` times in all; then its future raises
    ``WORKER_LOST``. Functions, arguments, results and exceptions are pickled.
    """

    def __init__(self, count: int) -> None:
        self._threads = ThreadPoolExecutor(count)
        self._mine = threading.local()
        self._workers: set[Worker] = set()
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
        lost = None
        for _ in range(ATTEMPTS):
            worker = self._worker()
            try:
                return worker.call(call)
            except Died as died:
                lost = died
                self._forget(worker)
        raise worker_lost(lost, f", tried {ATTEMPTS} times,")

    def _worker(self) -> Worker:
        """The process of this thread."""
        worker: Worker | None = getattr(self._mine, "worker", None)
        if worker is None:
            with self._lock:
                if self._closed:
                    raise RuntimeError("the pool is closed")
                worker = self._mine.worker = Worker()
                self._workers.add(worker)
        return worker

    def _forget(self, worker: Worker) -> None:
        """Take another process from here on."""
        self._mine.worker = None
        with self._lock:
            self._workers.discard(worker)
