"""Work in forked children: whatever happens to them, the parent finds out, and nothing of it stays."""

import contextlib
import json
import os
import resource
import select
import signal
import sys
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import OpenImageIO as oiio

from facezip.cli import main
from facezip.commands import compress, decompress  # noqa: F401 - imported once, not in every child

FAILED = 99

# Threads do not survive a fork, and OpenImageIO waits for its own.
oiio.attribute("threads", 1)


@dataclass(frozen=True)
class Outcome:
    """How a child ended.

    Attributes
    ----------
    code : exit code, or minus the signal that ended it; minus SIGALRM where it hung.
    answer : what it returned, or its traceback.
    seconds : how long it took.
    """

    code: int
    answer: Any
    seconds: float


def in_child(work: Callable[[], Any], limit: float = 30) -> Outcome:
    """Call ``work`` in a forked child, which is killed after ``limit`` seconds; its answer must be JSON."""
    sys.stdout.flush()
    start = time.perf_counter()
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reader)
        _answer(work, writer)
    os.close(writer)
    content, hung = _read(reader, start + limit)
    if hung:
        os.kill(child, signal.SIGKILL)
    _, status = os.waitpid(child, 0)
    code = -signal.SIGALRM if hung else os.waitstatus_to_exitcode(status)
    answer = json.loads(content) if content and code in (0, FAILED) else None
    return Outcome(code, answer, time.perf_counter() - start)


def start_child(work: Callable[[], Any]) -> int:
    """Start ``work`` in a forked child that the caller waits for; the process id."""
    sys.stdout.flush()
    child = os.fork()
    if child == 0:
        _answer(work, os.open(os.devnull, os.O_WRONLY))
    return child


def command(arguments: list[Any], messages: Path) -> int:
    """Run the ``facezip`` command in this process, both streams into a file; its exit code."""
    with open(messages, "wb") as file:
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
        for descriptor in (1, 2):
            os.dup2(file.fileno(), descriptor)
    sys.argv = ["facezip", *map(str, arguments)]
    try:
        main()
    except SystemExit as end:
        return int(end.code or 0)
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
    return 0


def memory_above(work: Callable[[], Any]) -> tuple[Any, int]:
    """What ``work`` returns, and by how many bytes this process was larger meanwhile than before."""
    Path("/proc/self/clear_refs").write_text("5", encoding="ascii")
    before = _status("VmRSS")
    answer = work()
    return answer, _status("VmHWM") - before


def _status(field: str) -> int:
    lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    return next(int(line.split()[1]) * 1024 for line in lines if line.startswith(field))


def _answer(work: Callable[[], Any], writer: int) -> None:
    """Never returns: the child must not run the parent's code."""
    code = FAILED
    try:
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        answer = json.dumps(work())
        code = 0
    except BaseException:
        answer = json.dumps(traceback.format_exc())
    with contextlib.suppress(BaseException), os.fdopen(writer, "w") as pipe:
        pipe.write(answer)
    os._exit(code)


def _read(reader: int, deadline: float) -> tuple[bytes, bool]:
    content = b""
    with os.fdopen(reader, "rb", 0) as pipe:
        while True:
            ready, _, _ = select.select([pipe], [], [], max(0, deadline - time.perf_counter()))
            if not ready:
                return content, True
            part = pipe.read(2**16)
            if not part:
                return content, False
            content += part
