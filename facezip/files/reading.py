"""What all readers share: no error of the system or of memory leaves them as anything but a ``FaceZipError``."""

import hashlib
import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TypeVar

from facezip.errors import ErrorCode, FaceZipError

# Flat images shrink a thousandfold and are no attack: what an image unfolds to counts from here on only ...
SPARE = 2**28
# ... and where it is a larger multiple of its file. Albedo and difference maps stay below fifty.
MOST_EXPANSION = 200

# Of a folder that writers replace all the time: a reading takes longer than the renames between which it fails.
ATTEMPTS = 50
# What a clone holds in place of a large file, until Git LFS fetches that.
_POINTER = b"version https://git-lfs.github.com/spec/"

Found = TypeVar("Found")


@contextmanager
def reading(path: Path) -> Iterator[None]:
    """Turn what the system refuses while ``path`` is read into one line.

    Raises
    ------
    FaceZipError
        ``CANNOT_READ``, or ``TOO_LARGE`` where memory does not suffice. Of a file that is refused for any reason, but
        stands for one that Git LFS has not fetched, that is the reason.
    """
    try:
        yield
    except FaceZipError:
        if is_pointer(path):
            reason = "stands for a file that Git LFS has not fetched; run 'git lfs pull'"
            raise FaceZipError(ErrorCode.CANNOT_READ, f"{path}: {reason}") from None
        raise
    except OSError as error:
        raise FaceZipError(
            ErrorCode.CANNOT_READ, f"{path}: cannot be read ({error.strerror or error}); check its rights and its disk"
        ) from None
    except MemoryError:
        raise FaceZipError(
            ErrorCode.TOO_LARGE, f"{path}: does not fit into memory; make it smaller or use a larger machine"
        ) from None


def is_pointer(path: Path) -> bool:
    """Whether a file is what Git LFS leaves in the place of another."""
    try:
        # A pipe would be waited for.
        if not path.is_file():
            return False
        with open(path, "rb") as file:
            return file.read(len(_POINTER)) == _POINTER
    except OSError:
        return False


def digest(path: Path) -> str:
    """The sha256 of a file's bytes."""
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def undisturbed(folder: Path, read: Callable[[], Found]) -> Found:
    """What ``read`` makes of a folder; again if another folder took its place meanwhile, so that it is never of both.

    Raises
    ------
    FaceZipError
        What ``read`` raises of a folder that stays; ``CANNOT_READ``: none stays for long enough.
    """
    for attempt in range(ATTEMPTS):
        with _held(folder) as stays:
            try:
                found = read()
            except FaceZipError:
                if stays():
                    raise
            else:
                if stays():
                    return found
        time.sleep(attempt / 1000)
    raise FaceZipError(
        ErrorCode.CANNOT_READ, f"{folder}: another program replaces it again and again; read it when that is done"
    )


@contextmanager
def _held(folder: Path) -> Iterator[Callable[[], bool]]:
    """Whether the path still stands for what it stands for now: which is open, so that nothing else has its number."""
    try:
        # Not waiting: where a folder should be there may be a pipe.
        descriptor = os.open(folder, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0))
    except FileNotFoundError:
        yield lambda: not os.path.lexists(folder)
        return
    except OSError:
        # Windows opens no folders, and does not rename what is open.
        yield lambda: True
        return
    try:
        yield lambda: _is(descriptor, folder)
    finally:
        os.close(descriptor)


def _is(descriptor: int, path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(descriptor), path.stat())
    except OSError:
        return False


def check_expansion(what: Path, decoded: int, stored: int, spare: int = SPARE) -> None:
    """Refuse what would unfold out of proportion, before memory is asked for.

    Parameters
    ----------
    what : the file or folder, for the message.
    decoded : bytes that it claims to hold.
    stored : bytes that it has on disk.
    spare : bytes that are no attack, whatever they are stored in.

    Raises
    ------
    FaceZipError
        ``TOO_LARGE``.
    """
    if decoded > max(spare, MOST_EXPANSION * stored):
        raise FaceZipError(
            ErrorCode.TOO_LARGE,
            f"{what}: claims {decoded} bytes of texels in {stored} bytes of file; that is damage or an attack",
        )
