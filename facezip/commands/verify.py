"""``facezip verify``: is every byte of a pack as it was written."""

from pathlib import Path

import click

from facezip.commands import options
from facezip.files.reading import undisturbed
from facezip.pack.manifest import Manifest
from facezip.pack.read import read_stored
from facezip.pack.verification import verify_pack


@click.command("verify")
@click.argument("pack", type=options.FOLDER)
@options.as_json
def command(pack: Path, as_json: bool) -> None:
    """Check that PACK is complete, unchanged and readable. If not: one line, and exit code 3."""
    manifest = undisturbed(pack, lambda: _verified(pack))
    document = {"pack": str(pack), "intact": True, "files": len(manifest.files) + 1}
    options.answer(document, as_json, lambda: [f"{pack}: intact, {document['files']} files"])


def _verified(pack: Path) -> Manifest:
    manifest = verify_pack(pack)
    read_stored(pack, manifest)
    return manifest
