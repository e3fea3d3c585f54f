"""``facezip batch``: many characters on the processes of this machine or on a cluster."""

import sys
from collections import Counter
from collections.abc import Container, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter
from typing import Any, Literal

import click

from facezip.batch import finished
from facezip.batch.jobs import Job, find_jobs
from facezip.batch.workers import crew
from facezip.commands import options
from facezip.commands.fit_options import DEFAULTS, check_together, fit_options, request_of
from facezip.commands.words import megabytes
from facezip.documents.document import Document, to_json
from facezip.documents.error import Fault
from facezip.errors import ErrorCode, ExitCode, FaceZipError
from facezip.files.writing import alone, write_whole
from facezip.fit.documents import CompressDocument
from facezip.fit.pipeline import compress_into, registration_warning
from facezip.machine.memory import beside, limited

FILE_NAME = "batch.json"


Status = Literal["made", "kept", "earlier"]


@dataclass(frozen=True)
class Outcome:
    """What one task says of its pack, and whether that was made now or kept."""

    status: Status
    document: CompressDocument


@dataclass(frozen=True, kw_only=True)
class Finished(CompressDocument):
    """A character whose pack is there.

    Attributes
    ----------
    name : what the batch calls it.
    status : whether the pack was made now, kept since nothing has changed, or made by an earlier run.
    character : its scans.
    """

    status: Status
    character: str


@dataclass(frozen=True, kw_only=True)
class Failed:
    """A character without a pack.

    Attributes
    ----------
    name, character : what the batch calls it, and its scans.
    status : ``failed``.
    error : why.
    """

    name: str
    character: str
    status: Literal["failed"] = "failed"
    error: Fault


@dataclass(frozen=True, kw_only=True)
class BatchDocument(Document):
    """What ``facezip batch`` has done, as it stands in ``batch.json``.

    Attributes
    ----------
    output : the folder of the packs; "" until the first run is over.
    characters : one entry each; those of earlier runs last.
    made, kept, earlier : how many.
    failed : the names of those that did.
    seconds : of this run.
    """

    format: Literal["facezip-batch/1"] = "facezip-batch/1"
    output: str = ""
    characters: Sequence[Finished | Failed] = ()
    made: int = 0
    kept: int = 0
    earlier: int = 0
    failed: Sequence[str] = ()
    seconds: float = 0.0


@click.command("batch")
@click.argument("characters", type=options.FOLDER, nargs=-1, required=True, metavar="CHARACTER...")
@click.option("-o", "--output", type=options.FOLDER, required=True, metavar="DIR", help="Folder for the packs.")
@fit_options
@options.worker_options
@options.memory_of_each
@options.overwrite
@options.as_json
@click.pass_context
def command(
    context: click.Context,
    /,
    characters: tuple[Path, ...],
    output: Path,
    workers: int | None,
    scheduler: str | None,
    memory: int | None,
    overwrite: bool,
    as_json: bool,
    **settings: Any,
) -> int:
    """Compress every CHARACTER into DIR/NAME.facezip, with the bytes that `facezip compress` writes.

    A CHARACTER is a folder of scans, a .glb or .gltf, a folder of such, or a list in TOML with settings of their own.
    Started again, it makes only what is missing or out of date. It leaves packs alone that another character or command
    made, unless you say --overwrite. A character that fails stops no other, and is named at the end. By default there
    is one worker for each core.
    """
    begin = perf_counter()
    jobs = [_resolved(context, job, settings) for job in find_jobs(characters)]
    with crew(workers, scheduler, len(jobs)) as hands, _batch_folder(output):
        folder = output.absolute()
        tasks = {
            job.name: (job.character.absolute(), folder, job.name, job.settings, overwrite, memory) for job in jobs
        }
        outcomes = hands.outcomes(compress_unless_finished, tasks, "Compressing characters")
        entries = [_entry(job, output, outcomes[job.name]) for job in jobs]
        warnings = [
            registration_warning(one.character, one.misregistered, one.unknown)
            for one in entries
            if isinstance(one, Finished) and (one.misregistered or one.unknown)
        ]
        document = _document(output, [*entries, *_earlier(output, tasks)], round(perf_counter() - begin, 3))
        write_whole(output / FILE_NAME, to_json(document).encode())
    errors = {name: outcome for name, outcome in outcomes.items() if isinstance(outcome, FaceZipError)}
    options.answer(document, as_json, lambda: _lines(document))
    for line in (*warnings, *(f"facezip: {name}: {error}" for name, error in errors.items())):
        print(line, file=sys.stderr)
    return max((error.exit_code for error in errors.values()), default=ExitCode.DONE)


def compress_unless_finished(
    character: Path,
    folder: Path,
    name: str,
    settings: Mapping[str, Any],
    overwrite: bool = False,
    memory: int | None = None,
) -> Outcome:
    """One task: a character's pack is there afterwards.

    Where arrays wait changes no byte: ``memory`` is no part of what a pack was made with.
    """
    pack = folder / f"{name}.facezip"
    digest = finished.digest_of(character, settings)
    document = finished.find(pack, digest)
    if document is not None:
        return Outcome("kept", document)
    with finished.claimed(pack, character, digest, overwrite), limited(memory, beside(pack)):
        document = compress_into(character, pack, request_of(settings), overwrite=True)
    finished.keep(pack, character, digest, document)
    return Outcome("made", document)


def _resolved(context: click.Context, job: Job, settings: Mapping[str, Any]) -> Job:
    """The job with a value for every setting: of the command line, else of its list, else the default."""
    known = {option.name: option for option in context.command.params if option.name in DEFAULTS}
    unknown = [name for name in job.settings if name not in known]
    if unknown:
        raise FaceZipError(
            ErrorCode.BAD_VALUE, f"{job.name}: '{unknown[0]}' is no setting; there are name, path, {', '.join(known)}"
        )
    listed = {name: known[name].type_cast_value(context, value) for name, value in job.settings.items()}
    given = options.on_line(context) & {*known, "memory"}
    whole = {**settings, **listed, **{name: settings[name] for name in given & {*known}}}
    check_together(given | {*listed}, whole)
    return replace(job, settings=whole)


def _batch_folder(output: Path) -> AbstractContextManager[None]:
    """Hold the folder of a batch against other runs; one that anything else has made is left alone."""
    if output.exists() and not (output / FILE_NAME).is_file() and not (output.is_dir() and not any(output.iterdir())):
        raise FaceZipError(
            ErrorCode.CANNOT_WRITE, f"{output}: exists and is not of a batch; choose another name or an empty folder"
        )
    if not (output / FILE_NAME).is_file():
        write_whole(output / FILE_NAME, to_json(BatchDocument()).encode())
    return alone(output, output)


def _entry(job: Job, output: Path, outcome: Outcome | FaceZipError) -> Finished | Failed:
    character = str(job.character)
    if isinstance(outcome, FaceZipError):
        return Failed(name=job.name, character=character, error=Fault.of(outcome))
    return _finished(job.name, output, outcome.status, character, outcome.document)


def _earlier(output: Path, names: Container[str]) -> list[Finished]:
    """The entries of what earlier runs have left in the folder."""
    found = finished.earlier(output, names)
    return [_finished(name, output, "earlier", *each) for name, each in found.items()]


def _finished(name: str, output: Path, status: Status, character: str, document: CompressDocument) -> Finished:
    about = {"name": name, "pack": str(output / f"{name}.facezip")}
    return Finished(**{**vars(document), **about}, status=status, character=character)


def _document(output: Path, entries: Sequence[Finished | Failed], seconds: float) -> BatchDocument:
    status = Counter(entry.status for entry in entries)
    return BatchDocument(
        output=str(output),
        characters=entries,
        made=status["made"],
        kept=status["kept"],
        earlier=status["earlier"],
        failed=[entry.name for entry in entries if entry.status == "failed"],
        seconds=seconds,
    )


def _lines(document: BatchDocument) -> list[str]:
    entries = [entry for entry in document.characters if entry.status != "earlier"]
    width = max(len(entry.name) for entry in entries)
    lines = [f"{'':{width}}  status    RMSE   seconds    on GPU"]
    for entry in entries:
        row = f"{entry.name:{width}}  {entry.status:6}"
        if isinstance(entry, Finished):
            row += f"  {entry.rmse:6.2f}  {entry.seconds:8.1f}  {megabytes(entry.bytes_on_gpu):>9}"
        lines.append(row)
    failed = f", {len(document.failed)} failed" if document.failed else ""
    others = f", {document.earlier} of earlier runs" if document.earlier else ""
    done = f"{document.made} made, {document.kept} kept{failed}{others}"
    return [*lines, f"{document.output}: {done}, {document.seconds:.1f} s"]
