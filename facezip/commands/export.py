"""``facezip export``: a pack in the form that an engine or a browser takes."""

from collections.abc import Mapping, Sequence
from inspect import signature
from pathlib import Path
from statistics import fmean
from typing import Any

import click

from facezip.character.loading import load_character
from facezip.commands import options
from facezip.commands.words import megabytes
from facezip.documents.document import Data, plain
from facezip.export import TARGETS
from facezip.export.regions import UDIM
from facezip.export.source import APART, TOGETHER
from facezip.machine.memory import beside, limited

MIPS = {
    "plain": "as engines make them of PNGs",
    "averaged": "the same, in blocks",
    "fitted": "in blocks and fitted, as written here",
}


def _named_files(context: click.Context, option: click.Parameter, values: tuple[str, ...]) -> dict[str, Path]:
    """Each ``NAME=FILE``, at the first ``=``."""
    found: dict[str, Path] = {}
    for value in values:
        name, _, file = value.partition("=")
        if not (name and file):
            raise click.BadParameter(f"'{value}' is no NAME=FILE")
        if name in found:
            raise click.BadParameter(f"two regions are called '{name}': give each a name of its own")
        found[name] = Path(file)
    return found


@click.command("export")
@click.argument("pack", type=options.FOLDER)
@click.option("--to", "target", type=click.Choice(list(TARGETS)), required=True, help="Where it goes.")
@click.option(
    "-o", "--output", type=options.FOLDER, required=True, metavar="DIR", help="Folder to write; for web also FILE.html."
)
@click.option(
    "--textures",
    type=click.Choice(["png", "dds", "ktx2"]),
    help="How to store neutrals and differences: png (default), or blocks with fitted mip-maps (BC7; UASTC for gltf).",
)
@click.option("--character", type=options.FOLDER, metavar="FOLDER", help="Scans to compare with on the page (web).")
@click.option(
    "--maps",
    type=click.Choice([TOGETHER, APART]),
    help="together: maps share textures, for the fewest fetches (default). apart: each has its own, with smaller "
    "errors in blocks (normals BC5, single numbers BC4).",
)
@click.option(
    "--animation",
    type=options.FOLDER,
    metavar="FRAMES.csv",
    help="Weights by frame; the first row names expressions (usd).  [default: every expression in turn]",
)
@click.option(
    "--region",
    callback=_named_files,
    multiple=True,
    metavar="NAME=FILE",
    help="A region of the face that can be turned down after export: white in an image over the texture. May be "
    f"repeated. With several tiles, write {UDIM} for the number of the tile.",
)
@options.memory
@options.overwrite
@options.as_json
def command(
    pack: Path,
    target: str,
    output: Path,
    textures: str | None,
    character: Path | None,
    maps: str | None,
    animation: Path | None,
    region: dict[str, Path],
    memory: int | None,
    overwrite: bool,
    as_json: bool,
) -> None:
    """Export PACK to an engine: textures, mesh, shader, script, and a page that explains them, GUIDE.md.

    All maps are written; several UDIM tiles go into folders of their numbers. DIR/facezip.json names every file and
    holds the numbers that turn texels into values (docs/engines.md). For three, DIR is a module with an example page.
    For web it is the viewer as one HTML file that opens from disk.
    For metahuman and o3de there are layers as those engines mix them, of one tile, under masks.
    """
    given: dict[str, Any] = {"textures": textures, "character": character, "maps": maps, "animation": animation}
    given = {name: value for name, value in {**given, "region": region}.items() if value}
    for name in given.keys() - signature(TARGETS[target]).parameters.keys():
        raise click.UsageError(f"--{name} says nothing to --to {target}: leave it out")
    if memory and target == "web":
        raise click.UsageError("--memory says nothing to --to web, which is one page: leave it out")
    if character:
        given["character"] = load_character(character)
    with limited(memory, beside(output)):
        document: Data = plain(TARGETS[target](pack, output, overwrite=overwrite, **given))
    options.answer(document, as_json, lambda: _lines(document))


def _lines(document: Data) -> list[str]:
    """What was measured, of each map; means over tiles where there are several."""
    lines = [f"{document['output']}: {megabytes(document['bytes'])}"]
    tiles = [*document.get("tiles", {"": document}).values()]
    for name, first in tiles[0].get("maps", {}).items():
        if "layers" in first:
            lines += _layer_lines(name, first)
        else:
            lines += _map_lines(name, [tile["maps"][name] for tile in tiles])
    return [*lines, *(f"  {note}" for note in document.get("notes", []))]


def _layer_lines(name: str, found: Mapping[str, Any]) -> list[str]:
    """How far layers that an engine mixes are from the pack; nothing of a map that it does not."""
    if not found["layers"]:
        return []
    measure, unit = _measure(found)
    mean, mixed = found[measure], found[f"{measure}_blends"]
    words = f"the engine's mixing adds {mean:.2f} {unit} to the expressions ({mixed:.2f} to blends of two)"
    return [f"  {name}: {words}; {100 * found['beyond']:.2f} % of its layers' values lie beyond 8 bits"]


def _measure(found: Mapping[str, Any]) -> tuple[str, str]:
    return ("angular_error", "degrees") if found["encoding"] == "normal" else ("rmse", "of 255")


def _map_lines(name: str, tiles: Sequence[Mapping[str, Any]]) -> list[str]:
    measure, unit = _measure(tiles[0])
    lines = []
    if "codec" in tiles[0]:
        adds, without = (fmean(tile["codec"][key] for tile in tiles) for key in (measure, f"{measure}_without_fit"))
        lines.append(
            f"  {name}: {tiles[0]['codec']['name']} adds {adds:.2f} {unit} to the expressions "
            f"({without:.2f} without fitting each texture to what was lost of the others)"
        )
    levels = list(zip(*(tile["mips"][1:5] for tile in tiles), strict=False))
    if levels:
        sides = ", ".join(f"1/{2 ** (number + 1)}" for number in range(len(levels)))
        lines.append(f"  {name}: mip-maps of {sides} of the side: errors ({unit}) of expressions seen from afar")
        lines += [f"    {_errors(levels, kind)} {words}" for kind, words in MIPS.items() if kind in levels[0][0]]
    return lines


def _errors(levels: Sequence[Sequence[Mapping[str, Any]]], kind: str) -> str:
    return ", ".join(f"{fmean(tile[kind] for tile in level):.2f}" for level in levels)
