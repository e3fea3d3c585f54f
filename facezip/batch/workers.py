"""Who does the tasks: processes of this machine or a dask cluster, behind one ``concurrent.futures.Executor``."""

import traceback
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor, as_completed
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, TypeVar

from facezip.batch.cluster import cluster
from facezip.batch.processes import ProcessWorkers
from facezip.errors import ErrorCode, FaceZipError
from facezip.machine.cores import cores, use_cores
from facezip.machine.progress import task
from facezip.machine.worker import worker_lost

Result = TypeVar("Result")


@dataclass(frozen=True)
class Crew:
    """Workers at hand.

    Attributes
    ----------
    executor : where calls go.
    threads : that a task may use. Together, the tasks of a machine use each of its cores once.
    """

    executor: Executor
    threads: int

    def outcomes(
        self, work: Callable[..., Result], tasks: Mapping[str, tuple[Any, ...]], description: str
    ) -> dict[str, Result | FaceZipError]:
        """``work(*tasks[name])`` for every name, each with its result or the error that ended it, in their order.

        ``work`` is a function that workers can import. A task that fails, or whose worker dies, stops no other.
        """
        with task(description, len(tasks)) as advance:
            calls = {
                name: self.executor.submit(call_with_cores, self.threads, work, *given) for name, given in tasks.items()
            }
            for _ in as_completed(calls.values()):
                advance()
        outcomes: dict[str, Result | FaceZipError] = {}
        for name, call in calls.items():
            error = call.exception()
            outcomes[name] = call.result() if error is None else _as_ours(error)
        return outcomes


@contextmanager
def crew(workers: int | None, scheduler: str | None, tasks: int) -> Iterator[Crew]:
    """Workers for ``tasks`` tasks until the end of the block; an error in the block ends what they are at.

    Parameters
    ----------
    workers : processes on this machine; None for one a core, and never more than tasks.
    scheduler : address of a dask scheduler, ``tcp://host:8786``, whose workers are taken instead. Each of their
        threads counts as one core, as dask has it.

    Raises
    ------
    FaceZipError
        ``NO_SCHEDULER``: dask is not installed, or no scheduler answers at the address.
    """
    if scheduler is not None:
        with cluster(scheduler) as executor:
            yield Crew(executor, threads=1)
        return
    available = cores()
    count = max(min(workers or available, tasks), 1)
    pool = ProcessWorkers(count)
    try:
        yield Crew(pool, threads=max(available // count, 1))
    except BaseException:
        pool.shutdown(cancel_futures=True)
        raise
    pool.shutdown()


def call_with_cores(threads: int, work: Callable[..., Result], *given: Any) -> Result:
    """What a worker is asked for: ``work(*given)`` in that many threads."""
    use_cores(threads)
    return work(*given)


def _as_ours(error: BaseException) -> FaceZipError:
    if isinstance(error, FaceZipError):
        return error
    if type(error).__name__ == "KilledWorker":
        return worker_lost()
    # A fault of ours: whoever reports it needs where it was.
    traceback.print_exception(error)
    return FaceZipError(ErrorCode.BAD_VALUE, f"unexpected {type(error).__name__}: {error}; please report it")
