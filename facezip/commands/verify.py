"""``facezip verify``: is every byte of a pack as it was written."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import click

from facezip.commands import options
from facezip.documents.document import Document
from facezip.files.reading import undisturbed
from facezip.pack.manifest import Manifest
from facezip.pack.read import read_stored
from facezip.pack.verification import verify_pack


@dataclass(frozen=True, kw_only=True)
class VerifyDocument(Document):
    """What ``facezip verify`` says of a pack that is as it was written; of any other there is an error.

    Attributes
    ----------
    pack : its folder.
    intact : true.
    files : how many.
    """

    format: Literal["facezip-verify/1"] = "facezip-verify/1"
    pack: str
    intact: Literal[True] = True
    files: int


@click.command("verify")
@click.argument("pack", type=options.FOLDER)
@options.as_json
def command(pack: Path, as_json: bool) -> None:
    """Check that PACK is complete, unchanged and readable. If not: one line, and exit code 3."""
    manifest = undisturbed(pack, lambda: _verified(pack))
    document = VerifyDocument(pack=str(pack), files=len(manifest.files) + 1)
    options.answer(document, as_json, lambda: [f"{pack}: intact, {document.files} files"])


def _verified(pack: Path) -> Manifest:
    manifest = verify_pack(pack)
    read_stored(pack, manifest)
    return manifest
