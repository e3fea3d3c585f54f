"""The workers of a dask cluster, once its scheduler has answered."""

import asyncio
import logging
from collections.abc import Iterator, Mapping
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any

from facezip.errors import ErrorCode, FaceZipError

# Seconds in which a scheduler has to be reached, and to answer.
REACH, PATIENCE = 10, 15

_log = logging.getLogger("facezip")


@contextmanager
def cluster(address: str) -> Iterator[Executor]:
    """Where calls go to the workers of the scheduler at ``address``, ``tcp://host:8786``.

    Raises
    ------
    FaceZipError
        ``NO_SCHEDULER``: dask is not installed, or at the address is no scheduler, or nothing, or something silent.
    """
    try:
        from distributed import Client
    except ImportError:
        raise FaceZipError(
            ErrorCode.NO_SCHEDULER, f"{address}: dask is not installed; pip install 'facezip[cluster]'"
        ) from None
    _check_answer(address)
    with Client(address, timeout=PATIENCE, set_as_default=False) as client:
        executor: Executor = client.get_executor(pure=False)
        try:
            yield executor
        except BaseException:
            executor.shutdown(wait=False)
            raise


def _check_answer(address: str) -> None:
    """Ask who is there: a client would wait for ever for the greeting of what is no scheduler."""
    try:
        # In a thread of its own: notebooks have a loop that runs already.
        with ThreadPoolExecutor(1) as asking:
            answer = asking.submit(lambda: asyncio.run(_identity(address))).result()
    except TimeoutError:
        raise _refusal(address, f"nothing there has answered as a dask scheduler in {PATIENCE} s") from None
    except MemoryError:
        # The first bytes of a greeting in another language, taken for a length.
        raise _refusal(address, "what answers is no dask scheduler") from None
    except Exception as error:
        raise _refusal(address, f"no dask scheduler answers ({_cause(error)})") from None
    if "workers" not in answer:
        raise _refusal(address, f"a dask {answer.get('type', 'process')} answers, no scheduler")
    if not answer["workers"]:
        _log.warning("%s: the scheduler has no workers yet; waiting for some", address)


async def _identity(address: str) -> Mapping[str, Any]:
    from distributed.core import rpc
    from distributed.security import Security

    asked = rpc(address, timeout=REACH, connection_args=Security().get_connection_args("client"))
    async with asyncio.timeout(PATIENCE), asked as there:
        answer: Mapping[str, Any] = await there.identity()
    return answer


def _cause(error: BaseException) -> str:
    while error.__cause__ is not None:
        error = error.__cause__
    return " ".join(str(error).split()) or type(error).__name__


def _refusal(address: str, reason: str) -> FaceZipError:
    remedy = "give the address that 'dask scheduler' prints, as tcp://host:8786; its dashboard has another port"
    return FaceZipError(ErrorCode.NO_SCHEDULER, f"{address or '--scheduler'}: {reason}; {remedy}")
