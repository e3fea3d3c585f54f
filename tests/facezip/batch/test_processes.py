"""Calls in processes: what comes back, and what the death of a process costs."""

import ctypes
import os
import resource
import signal
import time
from pathlib import Path

import pytest

from facezip.batch.processes import ATTEMPTS, ProcessWorkers
from facezip.batch.workers import Crew
from facezip.errors import ErrorCode, FaceZipError
from facezip.machine import telling


def die_until(folder, times, value):
    """Ends its process in the first ``times`` calls, then returns ``value``."""
    before = len(list(folder.iterdir()))
    if before < times:
        (folder / str(before)).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return value


def decode(file):
    """Stands for a decoder that some image crashes, as memory that it must not touch does."""
    with telling.at(Path(file)):
        if "crashes" in file:
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
            ctypes.string_at(0)
    return file


def refuse(code):
    raise FaceZipError(code, "refused: for a reason")


def go_wrong():
    raise type("Local", (Exception,), {})("cannot be pickled")


@pytest.fixture
def pool():
    with ProcessWorkers(2) as pool:
        yield pool


def test_results_are_those_of_the_calls_and_come_from_other_processes(pool):
    futures = [pool.submit(pow, 2, k) for k in range(9)]
    assert [future.result() for future in futures] == [2**k for k in range(9)]
    assert pool.submit(os.getpid).result() != os.getpid()


def test_an_error_comes_through_with_its_code_and_message(pool):
    with pytest.raises(FaceZipError, match="refused: for a reason") as caught:
        pool.submit(refuse, ErrorCode.BAD_TEXELS).result()
    assert caught.value.code is ErrorCode.BAD_TEXELS
    with pytest.raises(RuntimeError, match="Local: cannot be pickled"):
        pool.submit(go_wrong).result()


def test_a_death_costs_its_own_call_only_and_that_is_made_again(pool, tmp_path):
    dying = pool.submit(die_until, tmp_path, ATTEMPTS - 1, "at last")
    others = [pool.submit(pow, 3, k) for k in range(20)]
    assert dying.result() == "at last"
    assert [future.result() for future in others] == [3**k for k in range(20)]
    assert len(list(tmp_path.iterdir())) == ATTEMPTS - 1


def test_a_call_that_ends_every_process_is_named_and_the_pool_goes_on(pool, tmp_path):
    with pytest.raises(FaceZipError) as caught:
        pool.submit(die_until, tmp_path, ATTEMPTS, None).result()
    assert caught.value.code is ErrorCode.WORKER_LOST
    assert pool.submit(pow, 2, 5).result() == 32


def test_a_decoder_that_crashes_fails_its_own_job_alone_and_is_said_to_have_crashed(pool):
    files = ("a.png", "crashes.png", "b.png", "c.png")
    outcomes = Crew(pool, threads=1).outcomes(decode, {file: (file,) for file in files}, "Decoding")
    lost = outcomes.pop("crashes.png")
    assert isinstance(lost, FaceZipError)
    assert lost.code is ErrorCode.WORKER_LOST
    assert "crashed" in str(lost)
    assert "SIGSEGV), at crashes.png;" in str(lost)
    assert outcomes == {file: file for file in files if file != "crashes.png"}


def test_calls_are_broken_off_when_futures_are_cancelled():
    pool = ProcessWorkers(1)
    running, waiting = pool.submit(time.sleep, 600), pool.submit(time.sleep, 600)
    while not running.running():
        time.sleep(0.01)
    begin = time.monotonic()
    pool.shutdown(cancel_futures=True)
    assert time.monotonic() - begin < 60
    assert waiting.cancelled()
    assert running.exception() is not None
