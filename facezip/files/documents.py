"""Documents from their files: of the version that this program knows, or refused with a code."""

from dataclasses import fields
from pathlib import Path
from typing import TypeVar

from facezip.documents.document import Document, from_json
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.reading import reading

D = TypeVar("D", bound=Document)


def read_document(path: Path, kind: type[D]) -> D:
    """The document of a kind that a file holds.

    Raises
    ------
    FaceZipError
        ``CANNOT_READ``, and what :func:`parsed` raises.
    """
    with reading(path):
        content = path.read_bytes()
    return parsed(content, kind, path)


def parsed(content: bytes, kind: type[D], path: Path) -> D:
    """The document of a kind that the content of a file is; fields that it does not know are ignored.

    Raises
    ------
    FaceZipError
        ``OTHER_FORMAT`` for another version of it; ``BAD_VALUE`` for what is no such document.
    """
    known = next(str(field.default) for field in fields(kind) if field.name == "format")
    try:
        stated = from_json(content, Document).format
        if stated == known:
            return from_json(content, kind)
    except (ValueError, RecursionError) as error:
        raise FaceZipError(
            ErrorCode.BAD_VALUE, f"{path}: is no document of format {known} ({error}); have it written again"
        ) from None
    raise FaceZipError(
        ErrorCode.OTHER_FORMAT,
        f"{path}: its format is '{stated}', this program reads '{known}'; update facezip, or have it written again",
    )
