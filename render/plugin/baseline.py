"""The references of a folder: images, or digests of images that are kept elsewhere, as they are now or in a commit."""

import hashlib
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Literal

from facezip.documents.document import Document, to_json
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.documents import parsed
from facezip.files.reading import reading
from facezip.files.writing import write_whole
from render.plugin import commit as git
from render.plugin.store import Store

if TYPE_CHECKING:
    from render.plugin.reference import Reference

_IMAGE, _POINTER = ".exr", ".exr.json"


@dataclass(frozen=True, kw_only=True)
class PointerDocument(Document):
    """What stands for a reference whose image is kept elsewhere.

    Attributes
    ----------
    sha256 : of the image's file, under which it is kept.
    size : bytes of that.
    test : node id of the test that made it; empty where several share it.
    """

    format: Literal["facezip-pointer/1"] = "facezip-pointer/1"
    sha256: str
    size: int
    test: str


@dataclass(frozen=True)
class Baseline:
    """References by their names, which have no suffix.

    Attributes
    ----------
    folder : where they, or their digests, are.
    store : where the images are kept, or None where the folder holds them.
    commit : the full name of the one whose references count, or "" for those on disk.
    """

    folder: Path
    store: Store | None = None
    commit: str = ""

    def names(self) -> list[str]:
        """All that there are, sorted."""
        return sorted({_stripped(file) for file in self._files() if file.endswith((_IMAGE, _POINTER))})

    def path(self, name: str) -> Path:
        """The file that stands for a reference, or would.

        Raises
        ------
        FaceZipError
            ``BAD_VALUE``: it is there twice.
        """
        there = self._files()
        files = [file for file in (name + _IMAGE, name + _POINTER) if file in there]
        if len(files) > 1:
            reason = f"{self.folder}: both {files[0]} and {files[1]}"
            raise FaceZipError(ErrorCode.BAD_VALUE, f"{reason}; remove the one that is out of date")
        return self.folder / (files[0] if files else name + (_POINTER if self.store else _IMAGE))

    def digest(self, name: str) -> str:
        """The sha256 of the image."""
        path = self.path(name)
        if path.name.endswith(_POINTER):
            return self._pointer(path).sha256
        return hashlib.sha256(self._content(path)).hexdigest()

    def read(self, name: str) -> "Reference":
        """A reference.

        Raises
        ------
        FaceZipError
            What :meth:`render.plugin.reference.Reference.read`, the store and git raise.
        """
        from render.plugin.reference import Reference

        with self._local(name) as path:
            return Reference.read(path)

    def test_of(self, name: str) -> str | None:
        """The node id of the test that made it, or None of a file that is no reference."""
        from render.exr import read_conditions

        try:
            path = self.path(name)
            if path.name.endswith(_POINTER):
                return self._pointer(path).test
            told = read_conditions(path)
        except FaceZipError:
            return None
        return told.get("test") if "facezip" in told else None

    def write(self, name: str, reference: "Reference", test: str) -> Path:
        """Keep a reference and which test made it; raises ``FaceZipError`` (``CANNOT_WRITE``)."""
        content = reference.content({"test": test})
        image, pointer = (self.folder / f"{name}{suffix}" for suffix in (_IMAGE, _POINTER))
        self.folder.mkdir(parents=True, exist_ok=True)
        if self.store is None:
            write_whole(image, content)
            pointer.unlink(missing_ok=True)
            return image
        told = PointerDocument(sha256=self.store.put(content), size=len(content), test=test)
        write_whole(pointer, f"{to_json(told)}\n".encode())
        image.unlink(missing_ok=True)
        return pointer

    def _files(self) -> Sequence[str]:
        if self.commit:
            return git.file_names(self.commit, self.folder)
        return sorted(file.name for file in self.folder.iterdir()) if self.folder.is_dir() else []

    def _content(self, path: Path) -> bytes:
        if self.commit:
            return git.content(self.commit, path)
        with reading(path):
            return path.read_bytes()

    def _pointer(self, path: Path) -> PointerDocument:
        told = parsed(self._content(path), PointerDocument, path)
        if not re.fullmatch("[0-9a-f]{64}", told.sha256):
            raise FaceZipError(ErrorCode.BAD_VALUE, f"{path}: 'sha256' is no digest; generate the reference again")
        return told

    @contextmanager
    def _local(self, name: str) -> Iterator[Path]:
        path = self.path(name)
        if path.name.endswith(_POINTER):
            digest = self._pointer(path).sha256
            if self.store is None:
                reason = f"{path}: the image is kept elsewhere"
                raise FaceZipError(ErrorCode.MISSING_FILE, f"{reason}; say where with --facezip-store")
            yield self.store.fetch(digest)
        elif self.commit:
            with TemporaryDirectory() as place:
                copy = Path(place) / path.name
                copy.write_bytes(self._content(path))
                try:
                    yield copy
                except FaceZipError as error:
                    raise FaceZipError(error.code, str(error).replace(str(copy), str(path))) from None
        else:
            yield path


def _stripped(file: str) -> str:
    return file.removesuffix(_POINTER) if file.endswith(_POINTER) else file.removesuffix(_IMAGE)
