"""Files and folders that appear whole or not at all.

What is made lies in a sibling with a name of its own until it is complete and synced; one rename puts it in place. The
sibling is locked as long as its process lives, so that the next run can tell the leftovers of a killed one and remove
them, however many runs write at the same time.
"""

import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from facezip.errors import ErrorCode, FaceZipError
from facezip.files.packs import check_outside_packs
from facezip.files.reading import undisturbed
from facezip.files.renaming import Locked, put_in_place, recover, siblings


@contextmanager
def whole_folder(path: Path, overwrite: bool, ours: Callable[[Path], bool] | None) -> Iterator[Path]:
    """Yield an empty sibling folder that becomes ``path`` when the block ends well, and vanishes when it does not.

    Parameters
    ----------
    path : the folder to make.
    overwrite : whether an existing ``path`` may be replaced.
    ours : tells whether what exists was made by this program, a folder or not; nothing else is ever replaced. None for
        what is never replaced, such as scans, which nothing tells from those of a capture.

    Raises
    ------
    FaceZipError
        ``CANNOT_WRITE``: the folder exists, holds something else, lies within a pack, or the disk refuses. What was
        there is untouched.
    """
    with _writing(path):
        target = Path(os.path.realpath(path))
        recover(target)
        check_target(path, overwrite, ours)
        target.parent.mkdir(parents=True, exist_ok=True)
        with _sibling(target, Path.mkdir) as temporary, _named(temporary, path):
            yield temporary
            _sync(*temporary.rglob("*"), temporary)
            # Hours may have passed.
            check_target(path, overwrite, ours)
            put_in_place(temporary, target)
            _sync(target.parent)


@contextmanager
def resumable_folder(path: Path, overwrite: bool, ours: Callable[[Path], bool]) -> Iterator[Path]:
    """As :func:`whole_folder`, but what a broken run leaves waits in ``.NAME.partial`` for the next one.

    Raises
    ------
    FaceZipError
        ``CANNOT_WRITE``: as there, or another process is at work on the same folder.
    """
    with _writing(path):
        target = Path(os.path.realpath(path))
        recover(target)
        check_target(path, overwrite, ours)
        _clear_leftovers(target)
        partial = target.with_name(f".{target.name}.partial")
        partial.mkdir(parents=True, exist_ok=True)
        with alone(partial, path), _named(partial, path):
            try:
                yield partial
                _sync(*partial.rglob("*"), partial)
                check_target(path, overwrite, ours)
                put_in_place(partial, target)
                _sync(target.parent)
                _remove_unheld(partial)
            finally:
                if partial.is_dir() and not any(partial.iterdir()):
                    partial.rmdir()


@contextmanager
def alone(folder: Path, path: Path) -> Iterator[None]:
    """Hold a folder against other processes; the system lets go of it when this one ends, however it ends.

    Raises
    ------
    FaceZipError
        ``CANNOT_WRITE``: another process holds it; the message names it as ``path``.
    """
    with Locked(folder) as lock:
        if lock.gone or not lock.held:
            raise FaceZipError(
                ErrorCode.CANNOT_WRITE,
                f"{path}: another facezip is writing there; wait for it or choose another name",
            )
        yield


def write_whole(path: Path, content: bytes) -> None:
    """Write one file, and the folders that lead to it, so that a reader sees the old content or the new, never a part.

    Raises
    ------
    FaceZipError
        ``CANNOT_WRITE``, naming the file and the reason.
    """
    check_outside_packs(path)
    target = Path(os.path.realpath(path))
    with _writing(path):
        target.parent.mkdir(parents=True, exist_ok=True)
        with _sibling(target, lambda new: new.touch(exist_ok=False)) as temporary:
            temporary.write_bytes(content)
            _sync(temporary)
            os.replace(temporary, target)
            _sync(target.parent)


@contextmanager
def _writing(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise FaceZipError(
            ErrorCode.CANNOT_WRITE, f"{path}: cannot write ({error.strerror or error}); check space and rights"
        ) from None


@contextmanager
def _named(temporary: Path, path: Path) -> Iterator[None]:
    """Errors name the place that was asked for, not the one that is about to vanish."""
    try:
        yield
    except FaceZipError as error:
        raise FaceZipError(error.code, str(error).replace(str(temporary), str(path))) from None


@contextmanager
def _sibling(target: Path, create: Callable[[Path], None]) -> Iterator[Path]:
    """A new, locked name beside ``target``, gone at the end; leftovers of killed runs go first."""
    _clear_leftovers(target)
    while True:
        temporary = target.with_name(f".{target.name}.{os.urandom(8).hex()}.tmp")
        try:
            create(temporary)
            with Locked(temporary, wait=True) as lock:
                # Another run may have taken it for a leftover before it was locked.
                if not lock.gone:
                    try:
                        yield temporary
                    finally:
                        _remove(temporary)
                    return
        except KeyboardInterrupt:
            # Between the two it is nobody's.
            _remove(temporary)
            raise


def _clear_leftovers(target: Path) -> None:
    for leftover in siblings(target):
        _remove_unheld(leftover)


def _remove_unheld(path: Path) -> None:
    """Remove what no living process is at work on."""
    with Locked(path) as lock:
        if lock.held:
            _remove(path)


def _remove(path: Path) -> None:
    """Ctrl-C waits for it."""
    try:
        _remove_at_once(path)
    except KeyboardInterrupt:
        _remove_at_once(path)
        raise


def _remove_at_once(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path, ignore_errors=True)
    else:
        path.unlink(missing_ok=True)


def check_target(path: Path, overwrite: bool, ours: Callable[[Path], bool] | None) -> None:
    """Refuse a file or folder that may not be written, before there is anything to put there.

    Parameters
    ----------
    path, overwrite, ours : as of :func:`whole_folder`.

    Raises
    ------
    FaceZipError
        ``CANNOT_WRITE``: it exists, and may not be replaced or holds something else; or it lies within a pack.
    """
    check_outside_packs(path)
    with _writing(path):
        # Another writer may be about to replace it, too.
        undisturbed(path, lambda: _check(path, overwrite, ours))


def _check(path: Path, overwrite: bool, ours: Callable[[Path], bool] | None) -> None:
    if not path.exists() or (path.is_dir() and not any(path.iterdir())):
        return
    if ours is None:
        raise FaceZipError(ErrorCode.CANNOT_WRITE, f"{path}: exists already; choose another name")
    if not ours(path):
        raise FaceZipError(
            ErrorCode.CANNOT_WRITE, f"{path}: was not made by facezip and will not be replaced; choose another name"
        )
    if not overwrite:
        raise FaceZipError(ErrorCode.CANNOT_WRITE, f"{path}: exists already; choose another name or add --overwrite")


def _sync(*paths: Path) -> None:
    for path in paths:
        descriptor = os.open(path, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
