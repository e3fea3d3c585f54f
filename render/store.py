"""Finished shots on disk, each under a digest of all that made it: a broken run goes on from them."""

import hashlib
import json
import os
import shutil
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from facezip.documents.document import from_json, from_plain, to_json
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.writing import write_whole
from render.documents.images import ImageMetrics, Taken
from render.exr import write_exr

RENDERS = "renders"
M = TypeVar("M", Taken, ImageMetrics)


@dataclass(frozen=True, kw_only=True)
class Record:
    """A finished shot: a digest of all that made it, the length of its image, if it has one, and what was measured."""

    digest: str
    exr_bytes: int | None
    measured: Any


class ShotStore:
    """The folder ``renders/`` of a report: ``NAME.exr`` and ``NAME.json`` a shot.

    A shot is finished when its JSON is there, which is written last and whole.

    Parameters
    ----------
    folder : of the report.
    earlier : a finished report whose shots are taken over where nothing that made them has changed.
    """

    def __init__(self, folder: Path, earlier: Path | None = None) -> None:
        self._folder = folder / RENDERS
        self._places = [self._folder, *([earlier / RENDERS] if earlier else [])]
        self._names: set[str] = set()

    def find(self, name: str, digest: str, kind: type[M]) -> M | None:
        """The measurements, of this kind, of a finished shot with this digest, or None."""
        for place in self._places:
            measured = _read(place, name, digest, kind)
            if measured is not None:
                self._take_over(place, name)
                return measured
        return None

    def keep(
        self,
        name: str,
        digest: str,
        measured: Taken | ImageMetrics,
        parts: Mapping[str, NDArray[np.float32]],
        conditions: Mapping[str, str],
    ) -> None:
        """Write a finished shot; an image without parts is none."""
        self._names.add(name)
        image, temporary = self._folder / f"{name}.exr", self._folder / f".{name}.exr"
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            image.with_suffix(".json").unlink(missing_ok=True)
            if parts:
                write_exr(temporary, parts, conditions)
                os.replace(temporary, image)
        except OSError as error:
            reason = f"cannot write ({error.strerror}); check space and rights"
            raise FaceZipError(ErrorCode.CANNOT_WRITE, f"{image}: {reason}") from None
        record = Record(digest=digest, exr_bytes=_size(image) if parts else None, measured=measured)
        write_whole(self._folder / f"{name}.json", to_json(record).encode())

    def prune(self) -> None:
        """Remove what belongs to no shot of this run."""
        for path in self._folder.iterdir() if self._folder.is_dir() else ():
            if path.stem not in self._names:
                path.unlink()

    def _take_over(self, place: Path, name: str) -> None:
        self._names.add(name)
        if place == self._folder:
            return
        self._folder.mkdir(parents=True, exist_ok=True)
        # The JSON last: it says that the shot is finished.
        for path in (place / f"{name}.exr", place / f"{name}.json"):
            if path.is_file():
                shutil.copyfile(path, self._folder / path.name)


def digest_of(conditions: Mapping[str, Any], arrays: Iterable[NDArray[Any]]) -> str:
    """SHA-256 over plain data and the shapes, types and bytes of arrays."""
    digest = hashlib.sha256(json.dumps(conditions, sort_keys=True).encode())
    for array in arrays:
        digest.update(f"{array.shape}{array.dtype}".encode())
        digest.update(np.ascontiguousarray(array).view(np.uint8).reshape(-1).data)
    return digest.hexdigest()


def _read(place: Path, name: str, digest: str, kind: type[M]) -> M | None:
    try:
        record = from_json((place / f"{name}.json").read_bytes(), Record)
        known = record.digest == digest and _size(place / f"{name}.exr") == record.exr_bytes
        return from_plain(record.measured, kind) if known else None
    except (OSError, ValueError):
        return None


def _size(path: Path) -> int | None:
    return path.stat().st_size if path.is_file() else None
