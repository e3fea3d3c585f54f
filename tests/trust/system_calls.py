"""System calls of a forked child, seen and refused by strace: what it asked of the disk, and what if that says no."""

import os
import re
import shutil
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tests.trust.children import start_child

STRACE = shutil.which("strace")
MISSING = "strace is not installed, or may not look at processes here"
# Whatever changes a file or a folder; calls of this kind that the replay does not know end it.
CHANGES = (
    *("open", "openat", "creat", "write", "pwrite64", "writev", "pwritev", "ftruncate", "truncate", "fallocate"),
    *("fsync", "fdatasync", "rename", "renameat", "renameat2", "link", "linkat", "symlink", "symlinkat"),
    *("unlink", "unlinkat", "rmdir", "mkdir", "mkdirat", "copy_file_range", "sendfile", "lseek"),
)
# What readers ask.
READS = ("open", "openat", "read", "pread64", "stat", "lstat", "fstat", "newfstatat", "statx", "getdents64", "lseek")

_LINE = re.compile(
    r"(?P<thread>\d+) +(?P<name>\w+)\((?P<arguments>.*)\) += (?P<result>-?\d+|0x[0-9a-f]+|\?)(?P<more>.*)"
)
_UNFINISHED = re.compile(r"(?P<thread>\d+) +(?P<begin>\w+\(.*) <unfinished \.\.\.>")
_RESUMED = re.compile(r"(?P<thread>\d+) +<\.\.\. \w+ resumed>(?P<end>.*)")


@dataclass(frozen=True)
class Call:
    """One system call.

    Attributes
    ----------
    thread : who called.
    name, arguments : as strace writes them; strings in hexadecimal, descriptors with their paths.
    result : what came back; below zero for errors.
    """

    thread: int
    name: str
    arguments: tuple[str, ...]
    result: int

    @property
    def descriptor(self) -> int:
        """The first argument, a descriptor."""
        return int(self.arguments[0].partition("<")[0])

    def path(self, place: int) -> Path | None:
        """An argument as a path: of a descriptor, or of a name, which may follow that of its folder."""
        text = self.arguments[place]
        if text.startswith('"'):
            name = Path(os.fsdecode(string(text)))
            return name if name.is_absolute() or place == 0 else (self.path(place - 1) or Path()) / name
        found = re.search(r"<((?:\\x[0-9a-f]{2})+)>", text)
        return Path(os.fsdecode(_bytes(found[1]))) if found else None


def string(argument: str) -> bytes:
    """The bytes of a string argument."""
    return _bytes(argument.strip('"').removesuffix('"...'))


def _bytes(text: str) -> bytes:
    return bytes.fromhex(text.replace("\\x", ""))


def may_trace() -> bool:
    """Whether strace is there and allowed to work."""
    return STRACE is not None and subprocess.run([STRACE, "-o", os.devnull, "true"], check=False).returncode == 0


def traced(work: Callable[[], Any], log: Path, calls: tuple[str, ...], *options: str) -> int:
    """Call ``work`` in a forked child under strace; its exit code.

    Parameters
    ----------
    work : what is done.
    log : where strace writes its lines.
    calls : those that are looked at.
    options : of strace, such as those that refuse a call.
    """

    def when_looked_at() -> Any:
        os.kill(os.getpid(), signal.SIGSTOP)
        return work()

    child = start_child(when_looked_at)
    os.waitpid(child, os.WUNTRACED)
    known = ",".join(f"?{name}" for name in calls)
    tracer = subprocess.Popen(
        [
            str(STRACE),
            "-f",
            "-y",
            "-xx",
            "-s",
            str(2**24),
            "-o",
            log,
            "-e",
            f"trace={known}",
            *options,
            "-p",
            str(child),
        ],
        stderr=subprocess.DEVNULL,
    )
    while _tracer_of(child) == 0:
        time.sleep(0.001)
    os.kill(child, signal.SIGCONT)
    _, status = os.waitpid(child, 0)
    tracer.wait()
    return os.waitstatus_to_exitcode(status)


def _tracer_of(process: int) -> int:
    lines = Path(f"/proc/{process}/status").read_text(encoding="ascii").splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("TracerPid"))


def calls_in(log: Path) -> Iterator[Call]:
    """The calls of a log, in the order in which they ended."""
    begun: dict[str, str] = {}
    for line in log.read_text(encoding="ascii").splitlines():
        if unfinished := _UNFINISHED.fullmatch(line):
            begun[unfinished["thread"]] = unfinished["begin"]
            continue
        if resumed := _RESUMED.fullmatch(line):
            line = f"{resumed['thread']} {begun.pop(resumed['thread'])}{resumed['end']}"
        if match := _LINE.fullmatch(line):
            result = -1 if match["result"] == "?" else int(match["result"], 0)
            yield Call(int(match["thread"]), match["name"], tuple(match["arguments"].split(", ")), result)
