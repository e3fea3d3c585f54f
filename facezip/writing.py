"""Files and folders that appear whole or not at all."""

import fcntl
import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from facezip.errors import ErrorCode, FaceZipError


@contextmanager
def whole_folder(path: Path, overwrite: bool, ours: Callable[[Path], bool]) -> Iterator[Path]:
    """Yield an empty sibling folder that becomes ``path`` when the block ends well, and vanishes when it does not.

    Parameters
    ----------
    path : the folder to make.
    overwrite : whether an existing ``path`` may be replaced.
    ours : tells whether an existing folder was made by this program; no other is ever replaced.

    Raises
    ------
    FaceZipError
        ``CANNOT_WRITE``: the folder exists, holds something else, or the disk refuses.
    """
    _check_target(path, overwrite, ours)
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        temporary.mkdir()
        yield temporary
        _sync(temporary)
        _replace(temporary, path)
    except OSError as error:
        raise FaceZipError(
            ErrorCode.CANNOT_WRITE, f"{path}: cannot write ({error.strerror}); check space and rights"
        ) from None
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


@contextmanager
def resumable_folder(path: Path, overwrite: bool, ours: Callable[[Path], bool]) -> Iterator[Path]:
    """As :func:`whole_folder`, but what a broken run leaves waits in ``.NAME.partial`` for the next one.

    Raises
    ------
    FaceZipError
        ``CANNOT_WRITE``: as there, or another process is at work on the same folder.
    """
    _check_target(path, overwrite, ours)
    partial = path.with_name(f".{path.name}.partial")
    try:
        partial.mkdir(parents=True, exist_ok=True)
        with _alone(partial):
            try:
                yield partial
                _sync(partial)
                _replace(partial, path)
            finally:
                if partial.is_dir() and not any(partial.iterdir()):
                    partial.rmdir()
    except OSError as error:
        raise FaceZipError(
            ErrorCode.CANNOT_WRITE, f"{path}: cannot write ({error.strerror}); check space and rights"
        ) from None


@contextmanager
def _alone(folder: Path) -> Iterator[None]:
    """Hold a folder against other processes; the system lets go of it when this one ends, however it ends."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        yield
    except BlockingIOError:
        reason = "another facezip is writing there; wait for it or choose another name"
        raise FaceZipError(ErrorCode.CANNOT_WRITE, f"{folder}: {reason}") from None
    finally:
        os.close(descriptor)


def write_whole(path: Path, content: bytes) -> None:
    """Write one file so that a reader sees the old content or the new, never a part.

    Raises
    ------
    FaceZipError
        ``CANNOT_WRITE``, naming the file and the reason.
    """
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        with open(temporary, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)
    except OSError as error:
        temporary.unlink(missing_ok=True)
        raise FaceZipError(
            ErrorCode.CANNOT_WRITE, f"{path}: cannot write ({error.strerror}); check space and rights"
        ) from None


def _check_target(path: Path, overwrite: bool, ours: Callable[[Path], bool]) -> None:
    if not path.exists() or (path.is_dir() and not any(path.iterdir())):
        return
    if not overwrite:
        raise FaceZipError(ErrorCode.CANNOT_WRITE, f"{path}: exists already; choose another name or add --overwrite")
    if not path.is_dir() or not ours(path):
        raise FaceZipError(
            ErrorCode.CANNOT_WRITE, f"{path}: was not made by facezip and will not be replaced; choose another name"
        )


def _sync(folder: Path) -> None:
    for path in (*folder.rglob("*"), folder):
        descriptor = os.open(path, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def _replace(temporary: Path, path: Path) -> None:
    """Move the old folder aside before the new one takes its name: a folder cannot be renamed over a full one."""
    aside = path.with_name(f".{path.name}.{os.getpid()}.old")
    if path.exists():
        os.rename(path, aside)
    try:
        os.rename(temporary, path)
    except OSError:
        if aside.exists():
            os.rename(aside, path)
        raise
    shutil.rmtree(aside, ignore_errors=True)
