"""Arrays that a run may not hold in memory: mapped files without a name, whose pages are let go in time.

All code works on them as on any array; where they live changes no result. Pages that are let go stay in their file, so
what is resident is bounded whatever the arrays' sizes. The files have no name: a killed run leaves nothing.
"""

import mmap
import os
import tempfile
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from math import prod
from pathlib import Path
from threading import Lock
from typing import Any
from weakref import WeakSet, finalize

import numpy as np
from numpy.typing import DTypeLike, NDArray

from facezip.errors import ErrorCode, FaceZipError
from facezip.machine.cores import cores

# What Python, the libraries and compiled kernels take: 290 MB measured, and then some ...
LEAST = 400_000_000
# ... and for every core some rows of all textures: what a block of them is read from and worked on.
ROWS = 128
# Of the limit: an array that is larger goes to a file, and resident pages beyond that share are let go.
LARGE = 1 / 128
FULL = 3 / 4
# Files that wait for another array.
KEPT = 8

_STATM = Path("/proc/self/statm")


class _Limit:
    """How much may be resident, and the mapped arrays that are alive."""

    def __init__(self, memory: int, folder: Path | None) -> None:
        self.memory, self.folder = memory, folder
        self.lock, self.mappings, self.written = Lock(), WeakSet[mmap.mmap](), 0
        # Files whose arrays are gone: for the next arrays of their sizes, since old pages cost less than new ones.
        self.free = deque[mmap.mmap](maxlen=KEPT)

    def mapped(self, size: int) -> tuple[mmap.mmap, bool]:
        """A mapping of a nameless file, and whether that is new and all zeros."""
        for _ in range(KEPT):
            # Other threads, and arrays that end, are at it too.
            try:
                mapping = self.free.popleft()
            except IndexError:
                break
            if len(mapping) == size:
                return mapping, False
            self.free.append(mapping)
        # A new size: what waits is of no more use, and its memory is.
        self.free.clear()
        return self._new(size), True

    def _new(self, size: int) -> mmap.mmap:
        try:
            with tempfile.TemporaryFile(dir=self.folder) as file:
                _reserve(file.fileno(), size)
                mapping = mmap.mmap(file.fileno(), size)
        except OSError as error:
            raise FaceZipError(
                ErrorCode.CANNOT_WRITE,
                f"{self.folder or tempfile.gettempdir()}: no room for {size / 1e9:.1f} GB besides the "
                f"{self.written / 1e9:.1f} GB that --memory has put there ({error.strerror or error}); make room, name "
                "another disk in TMPDIR, or allow more memory",
            ) from None
        with self.lock:
            self.mappings.add(mapping)
            self.written = sum(map(len, self.mappings))
        return mapping

    def let_go(self) -> None:
        """Unmap the pages of all arrays; they stay in their files, and come back when they are touched."""
        with self.lock:
            for mapping in self.mappings if hasattr(mmap, "MADV_DONTNEED") else ():
                mapping.madvise(mmap.MADV_DONTNEED)


# Of the process, as memory is: threads that fill arrays have it too.
_limit: _Limit | None = None


@contextmanager
def limited(memory: int | None, folder: Path | None = None) -> Iterator[None]:
    """Keep the resident set within ``memory`` bytes, with arrays in ``folder``; None for no limit.

    Of work on pixels, those parts keep to it that take their arrays from here and go by rows
    (:func:`facezip.machine.rows.map_rows`).

    Parameters
    ----------
    memory : bytes; too few are refused where sizes are known (:func:`check`). None leaves an outer limit as it is.
    folder : where the files are; None for the system's temporary folder.
    """
    global _limit
    before, _limit = _limit, _limit if memory is None else _Limit(memory, folder)
    try:
        yield
    finally:
        _limit = before


def beside(output: Path) -> Path | None:
    """Where arrays wait: on the disk of an output, or where ``TMPDIR`` says; often the system's folder is memory."""
    return None if os.environ.get("TMPDIR") else next((p for p in output.absolute().parents if p.is_dir()), None)


def check(row_bytes: int, whole: int = 0) -> None:
    """Raise ``BAD_VALUE``, naming the least that works, where a limit is too small for textures of such rows.

    Parameters
    ----------
    row_bytes : bytes of one row of all textures together.
    whole : bytes that are held whole besides.
    """
    least = LEAST + cores() * ROWS * row_bytes + whole
    if _limit is not None and _limit.memory < least:
        reason = f"these textures and meshes need {-(-least // 10**6)}M at least; allow as much"
        raise FaceZipError(ErrorCode.BAD_VALUE, f"--memory {_limit.memory / 1e6:.0f}M: {reason}")


def empty(shape: tuple[int, ...], dtype: DTypeLike) -> NDArray[Any]:
    """An array of any content, in a file where a limit says so; raises ``CANNOT_WRITE`` where the disk refuses."""
    return np.empty(shape, dtype) if _fits(shape, dtype) else _mapped(shape, dtype)[0]


def zeros(shape: tuple[int, ...], dtype: DTypeLike) -> NDArray[Any]:
    """As :func:`empty`, of zeros."""
    if _fits(shape, dtype):
        return np.zeros(shape, dtype)
    array, is_new = _mapped(shape, dtype)
    for row in array if not is_new else ():
        row[...] = 0
        ease()
    return array


def _fits(shape: tuple[int, ...], dtype: DTypeLike) -> bool:
    return _limit is None or prod(shape) * np.dtype(dtype).itemsize <= _limit.memory * LARGE


def _mapped(shape: tuple[int, ...], dtype: DTypeLike) -> tuple[NDArray[Any], bool]:
    """An array in a file, and whether that is new and all zeros."""
    if _limit is None:
        raise RuntimeError("without a limit arrays live in memory")
    mapping, is_new = _limit.mapped(prod(shape) * np.dtype(dtype).itemsize)
    values = np.frombuffer(mapping, dtype)
    # Without a lock: it may be called at any time, even while one is held.
    finalize(values, _limit.free.append, mapping)
    return values.reshape(shape), is_new


def ease() -> None:
    """Let pages go where the limit is near; cheap, to be called after every few rows of work."""
    if _limit is not None and _resident() > _limit.memory * FULL:
        _limit.let_go()


def let_go() -> None:
    """Let all pages go now: before something takes memory that no limit sees, and after it has read arrays."""
    if _limit is not None:
        _limit.let_go()


def _resident() -> float:
    """Bytes of this process in memory; infinity where the system does not tell."""
    try:
        return int(_STATM.read_bytes().split()[1]) * mmap.PAGESIZE
    except OSError:
        return float("inf")


def _reserve(descriptor: int, size: int) -> None:
    """Take all of the disk's room now: a page that finds none later would end the process."""
    if hasattr(os, "posix_fallocate"):
        os.posix_fallocate(descriptor, 0, size)
    else:
        os.ftruncate(descriptor, size)
