"""A command whose thread has no memory ends with its one line, wherever in the thread that happens."""

import json
import subprocess
import sys

import pytest

# What raises it: before a thread has begun, in its work, and where a pool hands over a result or an error.
PLACES = {
    "begin": "threading.Thread._set_tstate_lock = exhausted",
    "work": "threading.Thread.run = exhausted",
    "result": "Future.set_result = exhausted",
    "error": "Future.set_exception = exhausted",
}
RUN = """
import sys, threading
from concurrent.futures import Future, ThreadPoolExecutor
import click
from facezip import cli
def exhausted(*_):
    raise MemoryError
{place}
@click.command()
@click.option("--json", is_flag=True)
def verb(json):
    with ThreadPoolExecutor(1) as pool:
        pool.submit(int, "{number}").result()
cli.facezip.get_command = lambda *_: verb
sys.argv = ["facezip", "verb", "--json"]
cli.main()
"""


@pytest.mark.parametrize("place", PLACES)
def test_a_thread_without_memory_ends_the_command_with_its_line(place):
    run = RUN.format(place=PLACES[place], number="none" if place == "error" else "1")
    done = subprocess.run([sys.executable, "-c", run], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 3
    assert done.stderr == "facezip: not enough memory; use smaller textures or a larger machine\n"
    assert json.loads(done.stdout)["error"]["code"] == "out-of-memory"


def test_other_errors_of_threads_are_shown_as_ever():
    run = RUN.format(place="", number="none")
    done = subprocess.run([sys.executable, "-c", run], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 1
    assert "ValueError" in done.stderr
