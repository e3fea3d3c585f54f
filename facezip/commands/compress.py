"""``facezip compress``: a character in, a pack out, with the error of what was written."""

import sys
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from facezip.commands import options
from facezip.commands.fit_options import GOALS, check_together, fit_options, request_of
from facezip.commands.words import cleaning_words, error_words, masks_words, megabytes, memory_words
from facezip.fit.documents import CompressDocument
from facezip.fit.pipeline import compress_into
from facezip.machine.memory import beside, limited
from facezip.pack.facts import several


@click.command("compress")
@click.argument("character", type=options.FOLDER)
@click.option(
    "-o", "--output", type=options.FOLDER, required=True, metavar="PACK", help="Folder NAME.facezip to write."
)
@fit_options
@click.option(
    "--lock",
    "locks",
    multiple=True,
    metavar="LAYER=FILE",
    help="Keep a painted layer byte for byte and fit the rest around it: difference_0=wrinkles.png is of the albedo, "
    "normal.difference_0=… of another map; may be repeated (refined).",
)
@options.memory
@options.overwrite
@options.as_json
@click.pass_context
def command(
    context: click.Context,
    /,
    character: Path,
    output: Path,
    locks: tuple[str, ...],
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
    check_together(options.on_line(context), given)
    request = replace(request_of(given), locks=_locks(locks, given))
    with limited(memory, beside(output)):
        document = compress_into(character, output, request, overwrite, lambda line: print(line, file=sys.stderr))
    options.answer(document, as_json, lambda: _lines(document))


def _locks(pairs: Iterable[str], given: Mapping[str, Any]) -> dict[str, Path]:
    """``difference_0=FILE`` by name; refuses what cannot go together."""
    found: dict[str, Path] = {}
    for pair in pairs:
        name, _, file = pair.partition("=")
        if not file or name in found:
            raise click.UsageError(f"--lock '{pair}': write it as difference_0=FILE, each layer once")
        found[name] = Path(file)
    if found and (given["method"] != "refined" or given["given_masks"]):
        raise click.UsageError("--lock needs --method refined")
    if found and any(given[goal] is not None for goal in GOALS):
        raise click.UsageError("--target-rmse and --budget-mb choose the number of layers: leave --lock out")
    return found


def _lines(document: CompressDocument) -> list[str]:
    blocks, plain = memory_words(document)
    each = " each" * (len(document.maps) > 1)
    return [
        f"{document.pack}: {len(document.expressions)} expressions{several(document)} in "
        f"{document.differences} difference textures{each}, method {document.method}, "
        f"{document.seconds:.1f} s",
        *(f"  cleaned    {line}" for line in cleaning_words(document.cleaning)),
        *(f"  {name:<10} {error_words(found)} ({document.region})" for name, found in document.errors.items()),
        *([f"  masks      {masks_words(document.masks)}"] if document.masks else []),
        *([f"  chosen     {document.choice.reason}"] if document.choice else []),
        f"  GPU        {blocks}",
        f"             {plain}",
        f"  on disk    {megabytes(document.bytes_on_disk)}, geometry {megabytes(document.bytes_geometry)} of it",
    ]
