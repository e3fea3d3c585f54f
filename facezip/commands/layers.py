"""``facezip layers``: a page of what every layer, mask and activation of a pack does."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from facezip.commands import options
from facezip.commands.words import call
from facezip.files.reading import undisturbed
from facezip.files.writing import whole_folder
from facezip.pack.facts import pack_facts
from facezip.pack.parsing import read_manifest
from facezip.pack.read import read_pack

if TYPE_CHECKING:
    from reports.layers.documents import LayersDocument


@click.command("layers")
@click.argument("pack", type=options.FOLDER)
@click.option("-o", "--output", type=options.FOLDER, required=True, metavar="DIR", help="Folder for the page.")
@options.overwrite
@options.as_json
def command(pack: Path, output: Path, overwrite: bool, as_json: bool) -> None:
    """Make a page that shows what every layer, weight map, mask and activation of PACK does.

    Layers are sorted by how much they change, and named by the parts of the face that they change most. Expressions
    stand beside the layer that they use most. DIR/index.html is one file; DIR/layers.json has its numbers.
    """
    from reports.layers.report import DATA, describe_and_write

    model, facts = undisturbed(pack, lambda: (read_pack(pack), pack_facts(pack, read_manifest(pack))))
    command = call("layers", pack, "-o", output)
    with whole_folder(output, overwrite, lambda folder: (folder / DATA).is_file()) as folder:
        document = describe_and_write(model, facts, command, folder)
    options.answer(document, as_json, lambda: _lines(document, output))


def _lines(document: "LayersDocument", output: Path) -> list[str]:
    lines = []
    for layer in document.layers:
        uses = ", ".join(f"{use.name} {use.level:.2f}" for use in layer.expressions[:3])
        lines.append(f"layer {layer.layer}: {layer.name}; most in {uses} (levels of 255)")
    masks = [mask.name for mask in document.masks[:3]]
    return [*lines, *([f"masks that do most: {', '.join(masks)}"] if masks else []), f"{output / 'index.html'}"]
