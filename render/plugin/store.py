"""Where the images of references are kept when the tests' repository holds only their digests: a folder, or any URL.

A file is named after the sha256 of its content, so that it never changes, is fetched once, and cannot be another one.
"""

import hashlib
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from facezip.errors import ErrorCode, FaceZipError
from facezip.files.reading import reading
from facezip.files.writing import write_whole
from facezip.machine.caches import kept_folder


@dataclass(frozen=True)
class Store:
    """A folder, or a URL of fsspec (``s3://…``, ``gs://…``, ``https://…``, ``file://…``).

    Attributes
    ----------
    place : its path or URL.
    cache : folder for what was fetched from a URL; None for the user's.
    """

    place: str
    cache: Path | None = None

    def put(self, content: bytes) -> str:
        """Keep a file; returns its sha256.

        Raises
        ------
        FaceZipError
            ``CANNOT_WRITE``, or ``BAD_VALUE`` where fsspec or what it needs for the URL is not installed.
        """
        digest = hashlib.sha256(content).hexdigest()
        if not self._is_remote():
            folder = Path(self.place)
            target = folder / _name(digest)
            if not target.is_file():
                target.parent.mkdir(parents=True, exist_ok=True)
                write_whole(target, content)
            return digest
        system, path = self._remote(digest)
        try:
            system.makedirs(path.rpartition("/")[0], exist_ok=True)
            system.pipe_file(path, content)
        except Exception as error:
            raise FaceZipError(ErrorCode.CANNOT_WRITE, f"{self.place}: cannot write ({_reason(error)})") from None
        return digest

    def fetch(self, digest: str) -> Path:
        """The file of a sha256, on this machine.

        Raises
        ------
        FaceZipError
            ``CANNOT_READ``: it is not there, or another file is.
        """
        if not self._is_remote():
            return _checked(Path(self.place) / _name(digest), digest)
        folder = self.cache or kept_folder("references")
        if folder is None:
            raise FaceZipError(ErrorCode.CANNOT_WRITE, f"{self.place}: no folder for a cache; set XDG_CACHE_HOME")
        kept = folder / _name(digest)
        with suppress(FaceZipError):
            return _checked(kept, digest)
        kept.parent.mkdir(parents=True, exist_ok=True)
        write_whole(kept, self._downloaded(digest))
        return kept

    def _downloaded(self, digest: str) -> bytes:
        system, path = self._remote(digest)
        try:
            content = bytes(system.cat_file(path))
        except Exception as error:
            reason = f"{self.place}: no reference {digest[:12]}… ({_reason(error)})"
            raise FaceZipError(ErrorCode.CANNOT_READ, f"{reason}; check the store, or generate it again") from None
        if hashlib.sha256(content).hexdigest() != digest:
            raise _another(f"{self.place}/{_name(digest)}")
        return content

    def _is_remote(self) -> bool:
        return "://" in self.place

    def _remote(self, digest: str) -> tuple[Any, str]:
        """The file system of fsspec, and the path of a file in it."""
        try:
            from fsspec.core import url_to_fs

            system, path = url_to_fs(self.place)
        except (ImportError, ValueError) as error:
            hint = "install facezip[store] and what fsspec needs for it"
            reason = f"{self.place}: cannot be opened ({_reason(error)}); {hint}"
            raise FaceZipError(ErrorCode.BAD_VALUE, reason) from None
        return system, f"{path.rstrip('/')}/{_name(digest)}"


def _name(digest: str) -> str:
    # Few file systems like a folder of very many files.
    return f"{digest[:2]}/{digest}.exr"


def _checked(path: Path, digest: str) -> Path:
    if not path.is_file():
        reason = f"{path}: no such reference in the store"
        raise FaceZipError(ErrorCode.CANNOT_READ, f"{reason}; check the store, or generate it again")
    with reading(path):
        found = hashlib.sha256(path.read_bytes()).hexdigest()
    if found != digest:
        raise _another(str(path))
    return path


def _another(place: str) -> FaceZipError:
    reason = f"{place}: not the reference that the tests were made with: its sha256 is another"
    return FaceZipError(ErrorCode.CANNOT_READ, f"{reason}; restore the file, or generate it again")


def _reason(error: Exception) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0]
