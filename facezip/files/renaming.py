"""One folder in the place of another at a stroke, and what puts it right where the system has no such stroke.

Linux and macOS can exchange two names. Where a file system cannot, the old folder is moved aside first; a run that is
killed before the new one is in place leaves the old one there, and the next reader or writer moves it back.
"""

import ctypes
import errno
import os
import re
from collections.abc import Iterator
from pathlib import Path

_AT_CWD = -100
_EXCHANGE = 2
_FASTER = (errno.ENOENT, errno.EEXIST, errno.ENOTEMPTY)
_UNSUPPORTED = (errno.ENOSYS, errno.EINVAL, errno.ENOTSUP, errno.EPERM)


class Locked:
    """A file or folder, locked against other processes until the end of the block or of this process.

    Attributes
    ----------
    held : whether the lock was had; without ``wait`` it is not where a living process holds it.
    gone : whether the name stands for something else by now, or for nothing.
    """

    def __init__(self, path: Path, wait: bool = False) -> None:
        self._path, self._wait, self._descriptor = path, wait, -1
        self.held = self.gone = False

    def __enter__(self) -> "Locked":
        try:
            self._descriptor = os.open(self._path, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0))
        except OSError:
            self.gone = not os.path.lexists(self._path)
            return self
        self.held = _lock(self._descriptor, self._wait)
        self.gone = not self._is_same()
        return self

    def __exit__(self, *_: object) -> None:
        if self._descriptor >= 0:
            os.close(self._descriptor)

    def _is_same(self) -> bool:
        try:
            return os.path.samestat(os.fstat(self._descriptor), os.lstat(self._path))
        except OSError:
            return False


def _lock(descriptor: int, wait: bool) -> bool:
    """False where a living process holds it, and without locks: no leftover can then be told from work."""
    # Windows has none; packs are read there without.
    import fcntl

    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    except OSError:
        return False
    return True


def siblings(target: Path, kind: str = "tmp|old") -> Iterator[Path]:
    """What runs, living or killed, have made beside ``target``: ``.NAME.`` with 16 digits and ``.tmp`` or ``.old``."""
    mine = re.compile(rf"\.{re.escape(target.name)}\.[0-9a-f]{{16}}\.({kind})")
    if target.parent.is_dir():
        yield from [entry for entry in target.parent.iterdir() if mine.fullmatch(entry.name)]


def recover(target: Path) -> None:
    """Put back the old folder of a run that was killed between its two renames."""
    if os.path.lexists(target):
        return
    for aside in siblings(target, "old"):
        # A living run holds the lock and is about to put its new folder in place: wait for it.
        with Locked(aside, wait=True) as lock:
            if not lock.gone and not os.path.lexists(target):
                os.rename(aside, target)


def put_in_place(new: Path, target: Path) -> None:
    """Rename a folder to ``target``, in the place of an older one; that one is then ``new`` or is gone."""
    while True:
        try:
            if not os.path.lexists(target):
                os.rename(new, target)
                return
            if exchange(new, target) or _move_aside_first(new, target):
                return
        except OSError as error:
            # Another writer was faster, between a look and a rename; ours is still to be put there.
            if error.errno not in _FASTER or not os.path.lexists(new):
                raise


def exchange(a: Path, b: Path) -> bool:
    """Swap two names at one stroke; False where the system or the file system cannot."""
    libc = ctypes.CDLL(None, use_errno=True)
    names = os.fsencode(a), os.fsencode(b)
    if hasattr(libc, "renameat2"):
        failed = libc.renameat2(_AT_CWD, names[0], _AT_CWD, names[1], _EXCHANGE)
    elif hasattr(libc, "renamex_np"):
        failed = libc.renamex_np(*names, _EXCHANGE)
    else:
        return False
    number = ctypes.get_errno()
    if failed and number not in _UNSUPPORTED:
        raise OSError(number, os.strerror(number), str(b))
    return not failed


def _move_aside_first(new: Path, target: Path) -> bool:
    """False where another writer has put something else there meanwhile."""
    aside = target.with_name(f".{target.name}.{os.urandom(8).hex()}.old")
    with Locked(target, wait=True) as lock:
        if lock.gone:
            return False
        os.rename(target, aside)
        try:
            os.rename(new, target)
        except OSError:
            # Where another one is there by now, the old one is a leftover.
            if not os.path.lexists(target):
                os.rename(aside, target)
            raise
        os.rename(aside, new)
    return True
