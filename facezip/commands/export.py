"""``facezip export``: a pack in the form that an engine or a browser takes."""

from collections.abc import Mapping, Sequence
from inspect import signature
from pathlib import Path
from typing import Any

import click

from facezip.character import load_character
from facezip.commands import options
from facezip.commands.options import megabytes
from facezip.export import TARGETS

MIPS = {
    "plain": "as engines make them of PNGs",
    "averaged": "the same, in blocks",
    "fitted": "in blocks and fitted, as written here",
}


@click.command("export")
@click.argument("pack", type=options.FOLDER)
@click.option("--to", "target", type=click.Choice(list(TARGETS)), required=True, help="What takes it.")
@click.option(
    "-o", "--output", type=options.FOLDER, required=True, metavar="DIR", help="Folder to write; for web also FILE.html."
)
@click.option(
    "--textures",
    type=click.Choice(["png", "dds", "ktx2"]),
    help="Of neutral and differences: png (default), or blocks with fitted mip-maps: BC7, in ktx2 for gltf UASTC.",
)
@click.option(
    "--character", type=options.FOLDER, metavar="FOLDER", help="Its originals come along, to compare with (web)."
)
@options.overwrite
@options.as_json
def command(
    pack: Path,
    target: str,
    output: Path,
    textures: str | None,
    character: Path | None,
    overwrite: bool,
    as_json: bool,
) -> None:
    """Write PACK with what an engine needs to show it: textures, mesh, shader, script and a page that explains them.

    DIR/facezip.json names every file and holds the numbers that turn texels into values; docs/engines.md explains it.
    For web it is the viewer as one HTML file that opens from disk.
    """
    given: dict[str, Any] = {"textures": textures, "character": character}
    given = {name: value for name, value in given.items() if value is not None}
    for name in given.keys() - signature(TARGETS[target]).parameters.keys():
        raise click.UsageError(f"--{name} says nothing to --to {target}: leave it out")
    if character:
        given["character"] = load_character(character)
    document = TARGETS[target](pack, output, overwrite=overwrite, **given)
    options.answer(document, as_json, lambda: _lines(document))


def _lines(document: Mapping[str, Any]) -> list[str]:
    lines = [f"{document['output']}: {megabytes(document['bytes'])}"]
    codec = document.get("codec", {})
    if "rmse" in codec:
        lines.append(
            f"  {codec['name']:8s} adds RMSE {codec['rmse']:.2f} of 255 to the expressions "
            f"({codec['rmse_without_fit']:.2f} without fitting each map to what was lost of the others)"
        )
    levels = document.get("mips", [])[1:5]
    if levels:
        sizes = ", ".join(str(level["size"][1]) for level in levels)
        lines.append(f"  mip-maps at {sizes} texels: RMSE to averaged light")
        lines += [f"    {_errors(levels, kind)} {words}" for kind, words in MIPS.items() if kind in levels[0]]
    return lines


def _errors(levels: Sequence[Mapping[str, Any]], kind: str) -> str:
    return ", ".join(f"{level[kind]:.2f}" for level in levels)
