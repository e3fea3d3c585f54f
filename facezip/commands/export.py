"""``facezip export``: a pack in the form that an engine or a browser takes."""

from pathlib import Path

import click

from facezip.character import load_character
from facezip.commands import options
from facezip.commands.options import megabytes
from facezip.export import TARGETS


@click.command("export")
@click.argument("pack", type=options.FOLDER)
@click.option("--to", "target", type=click.Choice(list(TARGETS)), required=True, help="What takes it.")
@click.option("-o", "--output", type=options.FOLDER, required=True, metavar="DIR", help="Folder, or FILE.html.")
@click.option("--character", type=options.FOLDER, metavar="FOLDER", help="Its originals come along, to compare with.")
@options.overwrite
@options.as_json
def command(pack: Path, target: str, output: Path, character: Path | None, overwrite: bool, as_json: bool) -> None:
    """Write PACK in another form: web is the viewer as one HTML file that opens from disk."""
    given = {"character": load_character(character)} if character else {}
    document = TARGETS[target](pack, output, overwrite=overwrite, **given)
    options.answer(document, as_json, lambda: [f"{document['output']}: {megabytes(document['bytes'])}"])
