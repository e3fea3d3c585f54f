"""``facezip check``: is every expression registered to the neutral, before time is spent on compressing it."""

import json
from collections.abc import Mapping
from pathlib import Path
from time import perf_counter
from typing import Any

import click

from facezip.character.alignment import (
    THRESHOLD,
    Alignment,
    Alignments,
    alignments,
    misregistered,
    undecided,
    worst_of,
    worst_tile,
)
from facezip.character.loading import load_character, save_character
from facezip.character.registration import register
from facezip.character.scans import Character
from facezip.commands import options
from facezip.errors import ExitCode
from facezip.files.writing import whole_folder

FORMAT = "facezip-alignment/1"
FILE_NAME, SHEET = "alignment.json", "alignment.png"


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

    The displacement is found on the albedo. --register moves all maps by it.
    """
    begin = perf_counter()
    scans = load_character(character)
    found = alignments(scans)
    document = {"format": FORMAT, "character": scans.facts, **_numbers(found)}
    if corrected is not None:
        document["register"] = _register(scans, found, corrected)
    document["seconds"] = round(perf_counter() - begin, 3)
    if output is not None:
        _write(output, overwrite, document, scans, found)
        document["picture"] = str(output / SHEET)
    options.answer(document, as_json, lambda: _lines(document))
    left = document["register"]["left"] if corrected is not None else document["misregistered"]
    return ExitCode.DIFFERENCE if left or document["unknown"] else ExitCode.DONE


def _numbers(found: Alignments) -> dict[str, Any]:
    """Of every expression the numbers of its worst tile, and those of each, in the texels of that tile."""
    first = next(iter(found.values()))
    return {
        "threshold": _threshold(first[min(first)]),
        "expressions": {
            name: {
                "tile": worst_tile(tiles),
                **_number(worst_of(tiles)),
                "tiles": {str(tile): _number(alignment) for tile, alignment in tiles.items()},
            }
            for name, tiles in found.items()
        },
        "misregistered": list(misregistered(found)),
        "unknown": undecided(found),
    }


def _number(alignment: Alignment) -> dict[str, Any]:
    texels, u, v = alignment.worst
    return {
        "rms": round(alignment.rms, 3),
        "worst": round(texels, 3),
        "worst_uv": [round(u, 3), round(v, 3)],
        "known": round(alignment.known, 3),
        "state": alignment.state,
        "why": alignment.why,
        "threshold": _threshold(alignment),
    }


def _threshold(alignment: Alignment) -> float:
    return THRESHOLD * alignment.unit


def _register(scans: Character, found: Alignments, folder: Path) -> dict[str, Any]:
    moved_scans, moved = register(scans, found)
    save_character(moved_scans, folder)
    after = alignments(moved_scans, moved) if moved else {}
    rms = {name: round(worst_of(tiles).rms, 3) for name, tiles in after.items()}
    left = list(misregistered({name: after.get(name, tiles) for name, tiles in found.items()}))
    return {"output": str(folder), "moved": list(moved), "rms": rms, "left": left}


def _write(output: Path, overwrite: bool, document: Mapping[str, Any], scans: Character, found: Alignments) -> None:
    from reports.alignment import write_contact_sheet

    with whole_folder(output, overwrite, lambda folder: (folder / FILE_NAME).is_file()) as folder:
        write_contact_sheet(folder / SHEET, scans, found)
        (folder / FILE_NAME).write_text(json.dumps(document, indent=1, allow_nan=False))


def _lines(document: Mapping[str, Any]) -> list[str]:
    found, wrong, unknown = document["expressions"], document["misregistered"], document["unknown"]
    width, several = max(map(len, found)), len(document["character"]["tiles"]) > 1
    heading = "at u, v on tile" if several else "at u, v"
    lines = [f"{'texels off the neutral':{max(width + 2, 22)}}     rms   worst   {heading}"]
    for name, one in sorted(found.items(), key=lambda pair: -pair[1]["rms"] / pair[1]["threshold"]):
        after = document.get("register", {}).get("rms", {}).get(name)
        moved = "" if after is None else f"  registered: {after:.2f}"
        # Where the whole is off, features are too.
        why = f": {one['why']}" if one["rms"] <= one["threshold"] else ""
        mark = f"  <-- misregistered{why}" if name in wrong else ""
        place = ", ".join(f"{value:.2f}" for value in one["worst_uv"]) + (f" on {one['tile']}" if several else "")
        numbers = f"{one['rms']:6.2f}  {one['worst']:6.2f}   {place}"
        numbers = "too little in common to tell" if name in unknown else numbers
        lines.append(f"  {name:{max(width, 20)}}  {numbers}{moved}{mark}")
    said = ", ".join(
        f"{len(names)} of {len(found)} {what}"
        for names, what in ((wrong, "misregistered"), (unknown, "cannot be told"))
        if names
    )
    lines.append(f"{document['character']['name']}: {said or 'all registered'}, {document['seconds']:.1f} s")
    lines += _register_lines(document["register"]) if "register" in document else []
    return [*lines, *([f"  open {document['picture']}"] if "picture" in document else [])]


def _register_lines(register: Mapping[str, Any]) -> list[str]:
    left = f"; still misregistered: {', '.join(register['left'])}" if register["left"] else ""
    return [f"  {register['output']}: corrected{left}"]
