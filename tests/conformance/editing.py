"""A pack changed after it was written: its manifest signed anew, or any of its bytes."""

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from facezip.files.packs import MANIFEST
from tests.conformance.signing import manifest_of, signed

Change = Callable[[Path], Any]
Edit = Callable[[dict[str, Any]], Any]
BAD, DAMAGED, OTHER = "bad-pack", "damaged-pack", "other-format"
NEUTRAL, DIFFERENCE, WEIGHTS, HEAD = (
    "albedo.1001.neutral.png", "albedo.1001.difference_0.png", "weights.1001.png", "head.glb"
)  # fmt: skip
SMALL = {"size": (4, 4), "slots": 1, "weights": (2, 2)}


def edited(pack: Path, edit: Edit) -> None:
    """Change the manifest, and sign it."""
    document = manifest_of(pack)
    edit(document)
    # Through JSON: what occurs twice becomes two.
    text = json.dumps({**document, "sha256": "0" * 64}, indent=1, ensure_ascii=True)
    signed(pack, text.encode() + b"\n")


def edited_text(pack: Path, change: Callable[[bytes], bytes]) -> None:
    """Change the manifest as text, and sign it."""
    blank = (pack / MANIFEST).read_bytes().replace(manifest_of(pack)["sha256"].encode(), b"0" * 64)
    signed(pack, change(blank))


def edited_bytes(pack: Path, name: str, change: Callable[[bytes], bytes]) -> None:
    """Change a file, whose checksum stays."""
    (pack / name).write_bytes(change((pack / name).read_bytes()))


def linked(pack: Path, name: str) -> None:
    """The same file, beside the pack."""
    (pack / name).rename(pack.parent / "elsewhere")
    os.symlink("../elsewhere", pack / name)


def renamed(document: dict[str, Any], name: str) -> None:
    document["tiles"][0]["textures"][0]["neutral"] = name
    document["files"][name] = document["files"].pop(NEUTRAL)
