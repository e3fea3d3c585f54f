"""What tells a pack from any other folder, for those who write beside packs: the first bytes of its manifest."""

import os
import re
from pathlib import Path

from facezip.errors import ErrorCode, FaceZipError

MANIFEST = "manifest.json"
# As the manifest of any version of the format starts; the group is its own checksum.
START = re.compile(rb'\{\n "sha256": "([0-9a-f]{64})",\n "format": "facezip-pack/')


def is_pack(folder: Path) -> bool:
    """Whether a folder looks like a pack, intact or not: only such a folder may be overwritten by one."""
    manifest = folder / MANIFEST
    try:
        if manifest.is_symlink() or not manifest.is_file():
            return False
        with open(manifest, "rb") as file:
            return START.match(file.read(256)) is not None
    except OSError:
        return False


def check_outside_packs(path: Path) -> None:
    """Refuse a place in a folder that is a pack: whatever is added to a pack damages it.

    Raises
    ------
    FaceZipError
        ``CANNOT_WRITE``, naming the pack.
    """
    for folder in Path(os.path.realpath(path)).parents:
        if is_pack(folder):
            reason = f"lies within the pack {folder}, which it would damage; choose a place outside it"
            raise FaceZipError(ErrorCode.CANNOT_WRITE, f"{path}: {reason}")
