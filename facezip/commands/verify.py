"""``facezip verify``: is every byte of a pack as it was written."""

from pathlib import Path

import click

from facezip.commands import options
from facezip.pack.surface_manifest import read_any_manifest
from facezip.pack.version_2 import read_surface


@click.command("verify")
@click.argument("pack", type=options.FOLDER)
@options.as_json
def command(pack: Path, as_json: bool) -> None:
    """Check that PACK is complete, unchanged and readable; exit code 3 and one line where it is not."""
    read_surface(pack)
    manifest = read_any_manifest(pack)
    document = {"pack": str(pack), "intact": True, "files": len(manifest.files) + 1}
    options.answer(document, as_json, lambda: [f"{pack}: intact, {document['files']} files"])
