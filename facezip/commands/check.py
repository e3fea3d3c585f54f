"""``facezip check``: is every expression registered to the neutral, before time is spent on compressing it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter
from typing import Literal

import click

from facezip.character.alignment import (
    THRESHOLD,
    Alignment,
    Alignments,
    alignments,
    misregistered,
    severity,
    undecided,
    worst_of,
    worst_tile,
)
from facezip.character.facts import CharacterFacts
from facezip.character.loading import load_character, save_character
from facezip.character.registration import register
from facezip.character.scans import Character
from facezip.commands import options
from facezip.documents.document import Document, to_json
from facezip.errors import ExitCode
from facezip.files.writing import check_target, whole_folder

FILE_NAME, SHEET = "alignment.json", "alignment.png"


@dataclass(frozen=True, kw_only=True)
class AlignmentFacts:
    """How a texture lies on the neutral's.

    Attributes
    ----------
    rms : root mean square of what is known of the displacement, in texels.
    worst : the largest displacement, in texels.
    worst_uv : where that is.
    known : the share of the face on which the displacement is known.
    state : ``unknown`` where it has too little in common with the neutral to tell.
    why : what is wrong besides the displacement, or nothing.
    threshold : the ``rms`` up to which it counts as registered, in texels.
    """

    rms: float
    worst: float
    worst_uv: tuple[float, float]
    known: float
    state: Literal["registered", "misregistered", "unknown"]
    why: str
    threshold: float


@dataclass(frozen=True, kw_only=True)
class ExpressionAlignment(AlignmentFacts):
    """How an expression's textures lie on the neutral's: the numbers of the worst tile.

    Attributes
    ----------
    tile : which that is.
    tiles : by UDIM number, in the texels of each.
    """

    tile: int
    tiles: Mapping[str, AlignmentFacts]


@dataclass(frozen=True, kw_only=True)
class RegisterFacts:
    """Scans that were written with their textures moved.

    Attributes
    ----------
    output : their folder.
    moved : the expressions that were.
    rms : of each of those, what is left, in texels.
    left : those that are misregistered still.
    """

    output: str
    moved: Sequence[str]
    rms: Mapping[str, float]
    left: Sequence[str]


@dataclass(frozen=True, kw_only=True)
class CheckDocument(Document):
    """How well expressions are registered to the neutral.

    Attributes
    ----------
    character : the scans.
    threshold : the ``rms`` up to which an expression counts as registered, in texels of the first tile.
    expressions : by name.
    misregistered, unknown : names of those that are off, and of those of which nothing can be told.
    seconds : the whole job.
    register : what ``--register`` wrote, where it was given.
    picture : the contact sheet, where ``-o`` was given.
    """

    format: Literal["facezip-alignment/1"] = "facezip-alignment/1"
    character: CharacterFacts
    threshold: float
    expressions: Mapping[str, ExpressionAlignment]
    misregistered: Sequence[str]
    unknown: Sequence[str]
    seconds: float
    register: RegisterFacts | None = None
    picture: str | None = None


@click.command("check")
@click.argument("character", type=options.FOLDER)
@click.option("-o", "--output", type=options.FOLDER, metavar="DIR", help="Folder for the pictures and the numbers.")
@click.option(
    "--register", "corrected", type=options.FOLDER, metavar="FOLDER", help="Write CHARACTER with all its maps moved."
)
@options.overwrite
@options.as_json
def command(character: Path, output: Path | None, corrected: Path | None, overwrite: bool, as_json: bool) -> int:
    """Measure how far every expression's texture of CHARACTER lies off the neutral's, in texels.

    Prints one number for each expression, of the tile where it is worst. With -o it writes a contact sheet of heat
    maps, DIR/alignment.png. The exit code is 7 if an expression is off by more than a texel of a 512 x 512 texture, if
    a feature slipped or is lost, or if nothing can be told; unless --register moves it back.

    The displacement is found on the albedo. --register moves all maps by it. It never replaces scans: FOLDER has to
    be new.
    """
    begin = perf_counter()
    if output is not None:
        check_target(output, overwrite, _is_check)
    if corrected is not None:
        check_target(corrected, False, None)
    scans = load_character(character)
    found = alignments(scans)
    moved = None if corrected is None else _register(scans, found, corrected)
    document = _document(scans, found, moved, round(perf_counter() - begin, 3))
    if output is not None:
        _write(output, overwrite, document, scans, found)
        document = replace(document, picture=str(output / SHEET))
    options.answer(document, as_json, lambda: _lines(document))
    left = document.misregistered if moved is None else moved.left
    return ExitCode.DIFFERENCE if left or document.unknown else ExitCode.DONE


def _document(scans: Character, found: Alignments, moved: RegisterFacts | None, seconds: float) -> CheckDocument:
    first = next(iter(found.values()))
    return CheckDocument(
        character=scans.facts,
        threshold=_threshold(first[min(first)]),
        expressions={name: _expression(tiles) for name, tiles in found.items()},
        misregistered=list(misregistered(found)),
        unknown=undecided(found),
        seconds=seconds,
        register=moved,
    )


def _expression(tiles: Mapping[int, Alignment]) -> ExpressionAlignment:
    return ExpressionAlignment(
        **vars(_facts(worst_of(tiles))),
        tile=worst_tile(tiles),
        tiles={str(tile): _facts(alignment) for tile, alignment in tiles.items()},
    )


def _facts(alignment: Alignment) -> AlignmentFacts:
    texels, u, v = alignment.worst
    return AlignmentFacts(
        rms=round(alignment.rms, 3),
        worst=round(texels, 3),
        worst_uv=(round(u, 3), round(v, 3)),
        known=round(alignment.known, 3),
        state=alignment.state,
        why=alignment.why,
        threshold=_threshold(alignment),
    )


def _threshold(alignment: Alignment) -> float:
    return THRESHOLD * alignment.unit


def _register(scans: Character, found: Alignments, folder: Path) -> RegisterFacts:
    moved_scans, moved = register(scans, found)
    save_character(moved_scans, folder)
    after = alignments(moved_scans, moved) if moved else {}
    rms = {name: round(worst_of(tiles).rms, 3) for name, tiles in after.items()}
    left = list(misregistered({name: after.get(name, tiles) for name, tiles in found.items()}))
    return RegisterFacts(output=str(folder), moved=list(moved), rms=rms, left=left)


def _write(output: Path, overwrite: bool, document: CheckDocument, scans: Character, found: Alignments) -> None:
    from reports.alignment import write_contact_sheet

    with whole_folder(output, overwrite, _is_check) as folder:
        write_contact_sheet(folder / SHEET, scans, found)
        (folder / FILE_NAME).write_text(to_json(document))


def _is_check(folder: Path) -> bool:
    return (folder / FILE_NAME).is_file()


def _lines(document: CheckDocument) -> list[str]:
    found, wrong, unknown = document.expressions, document.misregistered, document.unknown
    width, several = max(map(len, found)), len(document.character.tiles) > 1
    heading = "at u, v on tile" if several else "at u, v"
    lines = [f"{'texels off the neutral':{max(width + 2, 22)}}     rms   worst   {heading}"]
    worst_first = sorted(
        found.items(), key=lambda pair: severity(pair[1].state, pair[1].rms / pair[1].threshold), reverse=True
    )
    for name, one in worst_first:
        after = document.register.rms.get(name) if document.register else None
        moved = "" if after is None else f"  registered: {after:.2f}"
        # Where the whole is off, features are too.
        why = f": {one.why}" if one.rms <= one.threshold else ""
        mark = f"  <-- misregistered{why}" if name in wrong else ""
        place = ", ".join(f"{value:.2f}" for value in one.worst_uv) + (f" on {one.tile}" if several else "")
        numbers = f"{one.rms:6.2f}  {one.worst:6.2f}   {place}"
        numbers = "too little in common to tell" if name in unknown else numbers
        lines.append(f"  {name:{max(width, 20)}}  {numbers}{moved}{mark}")
    said = ", ".join(
        f"{len(names)} of {len(found)} {what}"
        for names, what in ((wrong, "misregistered"), (unknown, "cannot be told"))
        if names
    )
    lines.append(f"{document.character.name}: {said or 'all registered'}, {document.seconds:.1f} s")
    lines += _register_lines(document.register) if document.register else []
    return [*lines, *([f"  open {document.picture}"] if document.picture else [])]


def _register_lines(register: RegisterFacts) -> list[str]:
    left = f"; still misregistered: {', '.join(register.left)}" if register.left else ""
    return [f"  {register.output}: corrected{left}"]
