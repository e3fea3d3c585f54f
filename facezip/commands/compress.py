"""``facezip compress``: a character in, a pack out, with the error of what was written."""

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import click

from facezip.commands import options
from facezip.commands.fit_options import check_together, fit_options, on_line, request_of
from facezip.commands.words import error_words, masks_words, megabytes, memory_words
from facezip.fit.pipeline import compress_into
from facezip.machine.memory import beside, limited
from facezip.pack.facts import several


@click.command("compress")
@click.argument("character", type=options.FOLDER)
@click.option(
    "-o", "--output", type=options.FOLDER, required=True, metavar="PACK", help="Folder NAME.facezip to write."
)
@fit_options
@options.memory
@options.overwrite
@options.as_json
@click.pass_context
def command(
    context: click.Context,
    /,
    character: Path,
    output: Path,
    memory: int | None,
    overwrite: bool,
    as_json: bool,
    **given: Any,
) -> None:
    """Compress the expression textures of CHARACTER into a pack.

    CHARACTER is a folder with neutral.obj and neutral.png, and NAME.obj and NAME.png per expression (EXR, TIFF and
    16-bit PNG too), or a .glb or .gltf. A mask.png in it limits the face region and the error. NAME.normal.png,
    NAME.roughness.png, NAME.specular.png and NAME.cavity.png beside them share the weight maps; NAME.1001.png … are
    UDIM tiles.
    """
    check_together(on_line(context), given)
    request = request_of(given)
    with limited(memory, beside(output)):
        document = compress_into(character, output, request, overwrite, lambda line: print(line, file=sys.stderr))
    options.answer(document, as_json, lambda: _lines(document))


def _lines(document: Mapping[str, Any]) -> list[str]:
    blocks, plain = memory_words(document)
    each = " each" * (len(document["maps"]) > 1)
    return [
        f"{document['pack']}: {len(document['expressions'])} expressions{several(document)} in "
        f"{document['differences']} difference textures{each}, method {document['method']}, "
        f"{document['seconds']:.1f} s",
        *(f"  {name:<10} {error_words(found)} ({document['region']})" for name, found in document["errors"].items()),
        *([f"  masks      {masks_words(document['masks'])}"] if document["masks"] else []),
        *([f"  chosen     {document['choice']['reason']}"] if "choice" in document else []),
        f"  GPU        {blocks}",
        f"             {plain}",
        f"  on disk    {megabytes(document['bytes_on_disk'])}, geometry {megabytes(document['bytes_geometry'])} of it",
    ]
