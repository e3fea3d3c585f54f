"""``facezip doctor``: what is read from which file of a character, pack or export, and what to do about it."""

import sys
from collections.abc import Iterator
from pathlib import Path

import click
from rich.console import Console
from rich.table import Table
from rich.text import Text

from facezip.character.diagnosis import Diagnosis, Row
from facezip.character.notes import lines
from facezip.commands import options
from facezip.errors import ErrorCode, ExitCode, FaceZipError
from facezip.files.apart import apart
from facezip.machine.progress import left_alone, show_progress
from facezip.names import printable

TOML = "a character.toml for these files, to complete and to put beside them"
COLUMNS = ("what", "tile", "file", "encoding", "orientation", "size", "unit")


@click.command("doctor")
@click.argument("path", type=options.FOLDER)
@options.as_json
def command(path: Path, as_json: bool) -> int:
    """Say what is read from which file of PATH, what is unusual, and what to do.

    PATH is a character, a pack or an export. For a character: which file is which mesh, map and mask, how its numbers
    are stored, what is converted or left out; if it cannot be read, all reasons at once. For a pack: which files were
    changed. For an export: what would break the blend, such as a texture saved again with other numbers, or read as
    sRGB.

    The exit code is 3 if something has to be mended, and 7 if something is for you to decide.
    """
    with left_alone():
        found = apart(_examined, path)
    if sys.stdout.isatty() and not as_json:
        _show(found)
    else:
        options.answer(found, as_json, lambda: [*_lines(found)])
    if found.refusals:
        return ExitCode.BAD_INPUT
    return ExitCode.DIFFERENCE if found.asks else ExitCode.DONE


def _examined(path: Path) -> Diagnosis:
    """Of the process that reads: this one need not import what only that one uses."""
    from facezip.files.reading import undisturbed

    with show_progress():
        return undisturbed(path, lambda: _diagnosis(path))


def _diagnosis(path: Path) -> Diagnosis:
    from facezip.character.examination import examine_character
    from facezip.export.examination import examine_export
    from facezip.export.record import FILE_NAME as EXPORT
    from facezip.export.web import page_at
    from facezip.files.packs import MANIFEST
    from facezip.pack.examination import examine_pack

    if not path.exists():
        reason = "no such file or folder; give a character, a pack or an export"
        raise FaceZipError(ErrorCode.MISSING_FILE, f"{path}: {reason}")
    if (path / MANIFEST).is_file():
        return examine_pack(path)
    page = page_at(path)
    if page is not None:
        return Diagnosis("export", str(path), f"the viewer as one page, {page.name}, with all that it needs in it")
    return examine_export(path) if (path / EXPORT).is_file() else examine_character(path)


def _grouped(rows: tuple[Row, ...]) -> list[tuple[str, ...]]:
    """Rows of a short table: one for all files of which the same is said, with the first of them."""
    groups: dict[tuple[object, ...], list[Row]] = {}
    for row in rows:
        groups.setdefault((row.what, row.tile, row.encoding, row.orientation, row.size), []).append(row)
    return [_cells(group) for group in groups.values()]


def _cells(group: list[Row]) -> tuple[str, ...]:
    first, files = group[0], {row.file for row in group}
    more = f" and {len(files) - 1} more" if len(files) > 1 else ""
    tile = "" if first.tile is None else str(first.tile)
    return first.what, tile, f"{first.file}{more}", first.encoding, first.orientation, first.size, first.unit


def _sections(found: Diagnosis) -> Iterator[tuple[str, list[str]]]:
    """What to do, most urgent first."""
    yield "has to be mended", [refusal.words for refusal in found.refusals]
    yield "to decide", lines(note for note in found.notes if note.asks)
    yield "done or left out", lines(note for note in found.notes if not note.asks)
    yield TOML, found.character_toml.splitlines()


def _lines(found: Diagnosis) -> Iterator[str]:
    yield f"{found.path}: {found.kind}, {found.summary}"
    rows = _grouped(found.rows)
    widths = [max((len(row[column]) for row in rows), default=0) for column in range(len(COLUMNS))]
    for row in rows:
        cells = (f"{cell:{width}}" for cell, width in zip(row, widths, strict=True) if width)
        yield f"  {'  '.join(cells)}".rstrip()
    for heading, sentences in _sections(found):
        if sentences:
            yield f"{heading}:"
            yield from (f"  {sentence}" for sentence in sentences)
    if not found.refusals and not found.notes:
        yield "nothing unusual"


def _show(found: Diagnosis) -> None:
    """The same on a terminal."""
    console, rows = Console(), _grouped(found.rows)
    console.print(Text(printable(f"{found.path}: {found.kind}, {found.summary}"), style="bold"))
    if rows:
        table = Table(box=None, pad_edge=False, header_style="dim")
        used = [column for column in range(len(COLUMNS)) if any(row[column] for row in rows)]
        for column in used:
            table.add_column(COLUMNS[column], overflow="fold")
        for row in rows:
            table.add_row(*(Text(printable(row[column])) for column in used))
        console.print(table)
    for (heading, sentences), colour in zip(_sections(found), ("red", "yellow", "dim", "yellow"), strict=True):
        if sentences:
            console.print(Text(heading, style=f"bold {colour}"))
            for sentence in sentences:
                console.print(Text(f"  {printable(sentence)}"))
    if not found.refusals and not found.notes:
        console.print(Text("nothing unusual", style="green"))
