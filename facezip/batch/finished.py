"""Finished packs, each beside a record of all that made it: a batch that is started again does only what is missing."""

import hashlib
import json
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

from facezip.errors import FaceZipError
from facezip.manifest import FILE_NAME
from facezip.reading import reading
from facezip.verification import stored, verify_pack
from facezip.writing import write_whole


def digest_of(character: Path, settings: Mapping[str, Any]) -> str:
    """SHA-256 over the names and bytes of a character's files, the settings, and the version of the program.

    Raises
    ------
    FaceZipError
        ``CANNOT_READ``.
    """
    with reading(character):
        files = sorted(path for path in character.rglob("*") if path.is_file() and not path.name.startswith("."))
        inputs = {path.relative_to(character).as_posix(): stored(path).sha256 for path in files}
        if character.is_file():
            inputs = {"": stored(character).sha256}
    whole = {"inputs": inputs, "settings": dict(settings), "facezip": version("facezip")}
    return hashlib.sha256(json.dumps(whole, sort_keys=True, default=str).encode()).hexdigest()


def find(pack: Path, digest: str) -> dict[str, Any] | None:
    """What was said of a pack when it was made of just this; None where it was not, or is not intact."""
    try:
        record = json.loads(_record(pack).read_bytes())
        verify_pack(pack)
        same = (record["digest"], record["manifest"]) == (digest, stored(pack / FILE_NAME).sha256)
        return dict(record["document"]) if same else None
    except (OSError, ValueError, KeyError, TypeError, FaceZipError):
        return None


def keep(pack: Path, digest: str, document: Mapping[str, Any]) -> None:
    """Say that a pack is finished, what of, and what is known of it.

    Raises
    ------
    FaceZipError
        ``CANNOT_WRITE``.
    """
    record = {"digest": digest, "manifest": stored(pack / FILE_NAME).sha256, "document": document}
    write_whole(_record(pack), json.dumps(record, indent=1, allow_nan=False).encode())


def _record(pack: Path) -> Path:
    return pack.with_name(f"{pack.name}.json")
