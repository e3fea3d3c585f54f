"""Files as a commit of git has them, whatever lies in the working tree."""

import subprocess
from functools import cache
from pathlib import Path

from facezip.errors import ErrorCode, FaceZipError


def commit_id(revision: str, folder: Path) -> str:
    """The full name of a commit.

    Raises
    ------
    FaceZipError
        ``UNKNOWN_NAME``: there is no such commit, no repository or no git.
    """
    found = _git(folder, "rev-parse", "--verify", "--quiet", "--end-of-options", f"{revision}^{{commit}}")
    if not found:
        reason = f"{revision}: no such commit in the repository of {folder}"
        raise FaceZipError(ErrorCode.UNKNOWN_NAME, f"{reason}; a shallow clone may lack it: git fetch --unshallow")
    return found.decode().strip()


@cache
def file_names(commit: str, folder: Path) -> tuple[str, ...]:
    """The names of the files in a folder; none where the commit, by its full name, has no such folder."""
    tree = f"{commit}:{_inside(folder)}"
    listed = _git(_existing(folder), "ls-tree", "--full-tree", "-z", "--name-only", tree) or b""
    return tuple(name.decode(errors="surrogateescape") for name in listed.split(b"\0") if name)


def content(commit: str, path: Path) -> bytes:
    """The bytes of a file, what Git LFS keeps elsewhere included.

    Raises
    ------
    FaceZipError
        ``MISSING_FILE``.
    """
    found = _git(_existing(path.parent), "cat-file", "--filters", f"{commit}:{_inside(path)}")
    if found is None:
        raise FaceZipError(ErrorCode.MISSING_FILE, f"{path}: not in commit {commit[:12]}; generate it there")
    return found


def _inside(path: Path) -> str:
    """The path from the root of its repository."""
    root = _git(_existing(path), "rev-parse", "--show-toplevel") or b""
    return path.resolve().relative_to(Path(root.decode().rstrip("\n")).resolve()).as_posix()


def _existing(path: Path) -> Path:
    return next(parent for parent in (path, *path.parents) if parent.is_dir())


def _git(folder: Path, *arguments: str) -> bytes | None:
    """What git says, or None where it refuses."""
    try:
        done = subprocess.run(["git", "-C", str(folder), *arguments], capture_output=True, check=False)
    except OSError as error:
        reason = f"git cannot be run ({error.strerror or error}); install it"
        raise FaceZipError(ErrorCode.UNKNOWN_NAME, reason) from None
    return done.stdout if done.returncode == 0 else None
