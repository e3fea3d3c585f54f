"""Reading in a process of its own: what an image does to its decoder ends that process, and not this one.

Decoders are libraries in C and C++. Where one crashes, goes on for ever or takes all memory, the image is found by
which it does, and all is read again without it.
"""

import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

from facezip.errors import FaceZipError
from facezip.files.reading import digest
from facezip.machine.worker import Died, Worker, worker_lost

Result = TypeVar("Result")

# Seconds for what a decoder does at one go: 256 rows, or a whole image, of which the largest take ten of a processor.
PATIENCE = 120
# Bytes of addresses that libraries take and never touch.
UNTOUCHED = 2**30

# Linux's: on no other system are addresses limited.
_MEMINFO = Path("/proc/meminfo")


def apart(work: Callable[..., Result], *args: Any, patience: int = PATIENCE, room: int | None = None) -> Result:
    """``work(*args)``, made by a process of its own; raises what it raises.

    Images by which that process ends are refused as ``UNREADABLE_IMAGE`` when ``work`` comes to them again.

    Parameters
    ----------
    work : a function that can be imported.
    args : its arguments, which are pickled as its result is.
    patience : seconds in which a decoder may tell nothing.
    room : the most bytes of addresses that the process takes; None for the memory that the machine has left.

    Raises
    ------
    FaceZipError
        ``WORKER_LOST``: the process ended, and none of the images that it was at ends one alone.
    """
    with _scratch() as scratch:
        reading = _Reading(patience, _left() if room is None else room, scratch)
        while True:
            try:
                return reading.call(work, *args)
            except Died as died:
                if not reading.refuse_any(died.files):
                    raise worker_lost(died) from None


@dataclass
class _Reading:
    """Calls in processes with limits, and the images that they do not open any more: their sha256 → why."""

    patience: int
    room: int
    scratch: Path | None
    refused: dict[str, str] = field(default_factory=dict)

    def call(self, work: Callable[..., Result], *args: Any) -> Result:
        worker = Worker()
        try:
            return worker.call((_limited, (self.room, self.scratch, self.refused, work, args), {}), self.patience)
        finally:
            worker.end()

    def refuse_any(self, files: list[str]) -> bool:
        """Decode each of the files alone; whether there is one that ends a process, which is refused from now on."""
        found = False
        for file in map(Path, files):
            try:
                self.call(_decode, file)
            except Died as died:
                self.refused[digest(file)] = f"its decoder {died}"
                found = True
        return found


def _limited(
    room: int, scratch: Path | None, refused: Mapping[str, str], work: Callable[..., Result], args: tuple[Any, ...]
) -> Result:
    """``work(*args)`` under the limits of this process, which are for one call."""
    from facezip.files.opening import refuse

    if scratch is not None:
        tempfile.tempdir = str(scratch)
    if _MEMINFO.is_file():
        import resource

        soft, hard = resource.getrlimit(resource.RLIMIT_AS)
        resource.setrlimit(resource.RLIMIT_AS, (room if soft == resource.RLIM_INFINITY else min(room, soft), hard))
    refuse(refused)
    return work(*args)


def _decode(file: Path) -> None:
    """Whatever is read of an image."""
    from facezip.files.decoding import decoding

    # A fault that is told is none of the decoder.
    with suppress(FaceZipError), decoding(file) as (facts, bands):
        for _ in bands:
            pass
        facts.applied(as_colours=True)


@contextmanager
def _scratch() -> Iterator[Path | None]:
    """A folder for what a process that dies leaves behind; None where none can be made, which others will say."""
    try:
        folder = tempfile.mkdtemp()
    except OSError:
        yield None
        return
    try:
        yield Path(folder)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _left() -> int:
    """Bytes of addresses: of the memory that the machine has left, with that on disk, and of what takes none."""
    if not _MEMINFO.is_file():
        return sys.maxsize
    lines = (line.split() for line in _MEMINFO.read_text(encoding="ascii").splitlines())
    kilobytes = {words[0]: int(words[1]) for words in lines}
    return UNTOUCHED + 1024 * (kilobytes["MemAvailable:"] + kilobytes.get("SwapFree:", 0))
