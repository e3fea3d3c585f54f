"""Finished packs, each beside a record of all that made it: a batch that is started again does only what is missing."""

import hashlib
import json
from collections.abc import Container, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any, Literal

from facezip.character.filenames import files_below
from facezip.character.gltf_files import files_beside
from facezip.character.sources import is_gltf_name
from facezip.documents.document import Data, Document, from_json, from_plain, plain, to_json
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.packs import MANIFEST, is_pack
from facezip.files.reading import reading
from facezip.files.writing import write_whole
from facezip.fit.documents import CompressDocument
from facezip.pack.verification import stored, verify_pack


@dataclass(frozen=True, kw_only=True)
class RecordDocument(Document):
    """What a batch says of a pack, in NAME.facezip.json beside it; the first ones say no format.

    Attributes
    ----------
    character : which the pack is of.
    digest : SHA-256 over what it was made of: files, settings, and the version of the program.
    manifest : the checksum of the pack's manifest.
    document : what compress said when it was finished, in whichever version of the program.
    begun : whether a run has begun to write it since.
    """

    format: Literal["facezip-record/1"] = "facezip-record/1"
    character: str
    digest: str | None = None
    manifest: str | None = None
    document: Data | None = None
    begun: bool = False


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
        return {file.relative_to(path).as_posix(): stored(file).sha256 for file in files_below(path)}


def find(pack: Path, digest: str) -> CompressDocument | None:
    """What was said of a pack when it was made of just this; None where it was not, or is not intact."""
    record = _read(pack)
    known = record is not None and record.digest == digest and _as_recorded(pack, record)
    return _said(record) if record and known and _intact(pack) else None


def keep(pack: Path, character: Path, digest: str, document: CompressDocument) -> None:
    """Say that a pack is finished, what of, and what is known of it.

    Raises
    ------
    FaceZipError
        ``CANNOT_WRITE``.
    """
    owner, manifest = str(character.resolve()), _manifest_of(pack)
    _write(pack, RecordDocument(character=owner, digest=digest, manifest=manifest, document=plain(document)))


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
        if record is None or not (record.begun or _as_recorded(pack, record) or not _intact(pack)):
            raise _taken(pack, "was not made by a batch")
        if record.character != owner and record.digest != digest:
            raise _taken(pack, f"is of {record.character}")
    before = _manifest_of(pack)
    _write(pack, replace(record or RecordDocument(character=owner), character=owner, begun=True))
    try:
        yield
    except FaceZipError:
        if _manifest_of(pack) == before:
            _write(pack, record)
        raise


def earlier(folder: Path, names: Container[str]) -> dict[str, tuple[str, CompressDocument]]:
    """Of the finished packs in a folder, by name, ``names`` left out: which character each is of, and what was said."""
    found = {}
    for path in sorted(folder.glob("*.facezip.json")):
        pack = path.with_suffix("")
        record = None if pack.stem in names else _read(pack)
        document = _said(record) if record and _as_recorded(pack, record) else None
        if record and document:
            found[pack.stem] = record.character, document
    return found


def _said(record: RecordDocument) -> CompressDocument | None:
    """The document of a record; None where another version of the program has other ones."""
    try:
        return from_plain(record.document, CompressDocument)
    except ValueError:
        return None


def _taken(pack: Path, reason: str) -> FaceZipError:
    remedy = "give the character another name in a list (docs/batch.md), or add --overwrite"
    return FaceZipError(ErrorCode.CANNOT_WRITE, f"{pack}: {reason}, and is left as it is; {remedy}")


def _as_recorded(pack: Path, record: RecordDocument) -> bool:
    """Whether a pack was finished, and is the one that the record speaks of."""
    return record.document is not None and record.manifest is not None and record.manifest == _manifest_of(pack)


def _manifest_of(pack: Path) -> str | None:
    """The checksum of its manifest, which holds those of all other files; None where there is none."""
    try:
        return stored(pack / MANIFEST).sha256
    except OSError:
        return None


def _intact(pack: Path) -> bool:
    try:
        verify_pack(pack)
    except FaceZipError:
        return False
    return True


def _read(pack: Path) -> RecordDocument | None:
    """The record of a pack; None where there is none that can be understood: the pack is what counts."""
    try:
        return from_json(_record(pack).read_bytes(), RecordDocument)
    except (OSError, ValueError, RecursionError):
        return None


def _write(pack: Path, record: RecordDocument | None) -> None:
    """Replace the record of a pack; None leaves nothing."""
    if record:
        write_whole(_record(pack), to_json(record).encode())
    else:
        _record(pack).unlink(missing_ok=True)


def _record(pack: Path) -> Path:
    return pack.with_name(f"{pack.name}.json")
