"""Finished packs, each beside a record of all that made it: a batch that is started again does only what is missing."""

import hashlib
import json
from collections.abc import Container, Iterator, Mapping
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path
from typing import Any

from facezip.character.filenames import is_litter
from facezip.character.gltf_files import files_beside
from facezip.character.sources import is_gltf_name
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.reading import reading
from facezip.files.writing import write_whole
from facezip.pack.manifest import FILE_NAME
from facezip.pack.verification import is_pack, stored, verify_pack


def digest_of(character: Path, settings: Mapping[str, Any]) -> str:
    """SHA-256 over the names and bytes of a character's files and of those that settings name, the settings, and the
    version of the program.

    Raises
    ------
    FaceZipError
        ``CANNOT_READ``.
    """
    named = {name: _inputs_of(path) for name, path in settings.items() if isinstance(path, Path)}
    whole = {"inputs": _inputs_of(character), "settings": dict(settings), "facezip": version("facezip")}
    whole |= {"named": named} if named else {}
    return hashlib.sha256(json.dumps(whole, sort_keys=True, default=str).encode()).hexdigest()


def _inputs_of(path: Path) -> dict[str, str]:
    """SHA-256 by name of every file of a folder, or of one file and those beside it that a glTF needs."""
    with reading(path):
        if path.is_file():
            beside = files_beside(path) if is_gltf_name(path) else []
            return {file.relative_to(path.parent).as_posix(): stored(file).sha256 for file in beside} | {
                "": stored(path).sha256
            }
        every = sorted(file for file in path.rglob("*") if file.is_file())
        files = [file for file in every if not is_litter(file.relative_to(path))]
        return {file.relative_to(path).as_posix(): stored(file).sha256 for file in files}


def find(pack: Path, digest: str) -> dict[str, Any] | None:
    """What was said of a pack when it was made of just this; None where it was not, or is not intact."""
    record = _read(pack)
    intact = record.get("digest") == digest and _as_recorded(pack, record) and _intact(pack)
    return dict(record["document"]) if intact else None


def keep(pack: Path, character: Path, digest: str, document: Mapping[str, Any]) -> None:
    """Say that a pack is finished, what of, and what is known of it.

    Raises
    ------
    FaceZipError
        ``CANNOT_WRITE``.
    """
    owner, manifest = str(character.resolve()), _manifest_of(pack)
    _write(pack, {"character": owner, "digest": digest, "manifest": manifest, "document": document})


@contextmanager
def claimed(pack: Path, character: Path, digest: str, overwrite: bool) -> Iterator[None]:
    """Say, before a pack is written in the block, which character it is of: a run that is killed leaves its own.

    Raises
    ------
    FaceZipError
        ``CANNOT_WRITE``: a batch has not made the pack that is there, or of another character, and it may not be
        replaced.
    """
    record, owner = _read(pack), str(character.resolve())
    if is_pack(pack) and not overwrite:
        if not (record.get("begun") or _as_recorded(pack, record) or (record and not _intact(pack))):
            raise _taken(pack, "was not made by a batch")
        if record["character"] != owner and record.get("digest") != digest:
            raise _taken(pack, f"is of {record['character']}")
    before = _manifest_of(pack)
    _write(pack, {**record, "character": owner, "begun": True})
    try:
        yield
    except FaceZipError:
        if _manifest_of(pack) == before:
            _write(pack, record)
        raise


def earlier(folder: Path, names: Container[str]) -> dict[str, dict[str, Any]]:
    """What was said of the finished packs in a folder, by name, ``names`` left out; with the ``character`` of each."""
    found = {}
    for path in sorted(folder.glob("*.facezip.json")):
        pack = path.with_suffix("")
        record = {} if pack.stem in names else _read(pack)
        if _as_recorded(pack, record):
            found[pack.stem] = {**record["document"], "character": record["character"]}
    return found


def _taken(pack: Path, reason: str) -> FaceZipError:
    remedy = "give the character another name in a list (docs/batch.md), or add --overwrite"
    return FaceZipError(ErrorCode.CANNOT_WRITE, f"{pack}: {reason}, and is left as it is; {remedy}")


def _as_recorded(pack: Path, record: Mapping[str, Any]) -> bool:
    """Whether a pack was finished, and is the one that the record speaks of."""
    return "document" in record and record.get("manifest", "") == _manifest_of(pack)


def _manifest_of(pack: Path) -> str | None:
    """The checksum of its manifest, which holds those of all other files; None where there is none."""
    try:
        return stored(pack / FILE_NAME).sha256
    except OSError:
        return None


def _intact(pack: Path) -> bool:
    try:
        verify_pack(pack)
    except FaceZipError:
        return False
    return True


def _read(pack: Path) -> dict[str, Any]:
    """The record of a pack; empty where there is none that can be understood: the pack is what counts."""
    try:
        record = json.loads(_record(pack).read_bytes())
    except (OSError, ValueError, RecursionError):
        return {}
    known = isinstance(record, dict) and isinstance(record.get("character"), str)
    return record if known and isinstance(record.get("document", {}), dict) else {}


def _write(pack: Path, record: Mapping[str, Any]) -> None:
    """Replace the record of a pack; an empty one vanishes."""
    if record:
        write_whole(_record(pack), json.dumps(record, indent=1, allow_nan=False).encode())
    else:
        _record(pack).unlink(missing_ok=True)


def _record(pack: Path) -> Path:
    return pack.with_name(f"{pack.name}.json")
