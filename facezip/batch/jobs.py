"""What a batch is asked for: characters by their folders, by a folder of them, or by a list in TOML."""

import logging
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from facezip.character.sources import holds_scans, is_character, is_gltf_name, is_ours
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.reading import reading
from facezip.names import first_unusable, folded, printable

_log = logging.getLogger("facezip")


@dataclass(frozen=True)
class Job:
    """One character to compress.

    Attributes
    ----------
    name : of its pack, without ``.facezip``.
    character : its folder or glTF file.
    settings : what a list says of it: options of ``facezip compress`` by their names, ``-`` as ``_``.
    """

    name: str
    character: Path
    settings: Mapping[str, Any] = field(default_factory=dict)


def find_jobs(sources: Sequence[Path]) -> list[Job]:
    """The jobs of several sources, each a character, a folder of characters, or a list ``.toml``.

    A path that is none of these is taken for a character: it fails when its turn comes, and stops no other.

    Raises
    ------
    FaceZipError
        ``MISSING_FILE``, ``CANNOT_READ`` or ``BAD_VALUE`` for a list; ``BAD_VALUE`` where two characters share a name,
        or one has a name that no file can bear.
    """
    jobs = [job for source in sources for job in _jobs_of(source)]
    wrong = first_unusable(job.name for job in jobs)
    if wrong is not None:
        places = [str(job.character) for job in jobs if folded(job.name) == folded(wrong)]
        raise FaceZipError(
            ErrorCode.BAD_VALUE,
            f"{' and '.join(places)}: '{wrong}' is the name of two, or of no file; name each in a list (docs/batch.md)",
        )
    return jobs


def _jobs_of(source: Path) -> Iterator[Job]:
    if source.suffix.lower() == ".toml":
        yield from _listed(source)
        return
    with reading(source):
        inside = sorted(source.iterdir()) if source.is_dir() and not holds_scans(source) else []
        visible = [path for path in inside if not path.name.startswith(".")]
        found = [path for path in visible if is_character(path)]
        for path in visible if found else ():
            if path.is_dir() and path not in found and not _holds_ours(path):
                _log.warning("%s: no character, and left out; 'facezip doctor' on it says what is missing", path)
    yield from (Job(_name_of(path), path) for path in found or [source])


def _holds_ours(folder: Path) -> bool:
    """Whether a folder is a pack or an export, or one of them."""
    return is_ours(folder) or any(is_ours(path) for path in folder.iterdir() if path.is_dir())


def _name_of(path: Path) -> str:
    return printable(path.resolve().stem if is_gltf_name(path) else path.resolve().name)


def _listed(path: Path) -> Iterator[Job]:
    """The tables ``[[character]]`` of a file; what stands above them holds for all."""
    if not path.is_file():
        raise FaceZipError(ErrorCode.MISSING_FILE, f"{path}: no such list of characters; write it (docs/batch.md)")
    try:
        with reading(path):
            document = tomllib.loads(path.read_text(encoding="utf-8"))
    except (ValueError, RecursionError) as error:
        raise FaceZipError(ErrorCode.BAD_VALUE, f"{path}: not TOML ({error}); see docs/batch.md") from None
    tables = document.pop("character", [])
    if not isinstance(tables, list) or not tables or not all(_is_table(table) for table in tables):
        reason = "needs tables [[character]], each with a path; see docs/batch.md"
        raise FaceZipError(ErrorCode.BAD_VALUE, f"{path}: {reason}")
    for table in tables:
        character = path.parent / table.pop("path")
        yield Job(printable(str(table.pop("name", _name_of(character)))), character, document | table)


def _is_table(table: Any) -> bool:
    """A table with a path; an empty one would be the folder of the list."""
    return isinstance(table, dict) and isinstance(table.get("path"), str) and table["path"] != ""
