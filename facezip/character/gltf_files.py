"""The files beside a glTF that a character is read from: what it refers to, and what is called as its targets are."""

from pathlib import Path

from facezip.character.custom import texture_among
from facezip.character.filenames import MASK, visible_files
from facezip.character.gltf_parts import parts_of
from facezip.character.scans import NEUTRAL
from facezip.character.settings import SETTINGS
from facezip.errors import FaceZipError
from facezip.files.accessors import GlbFault
from facezip.files.glb import Glb
from facezip.names import is_safe_name


def files_beside(path: Path) -> list[Path]:
    """All files beside a glTF on which its character depends; none of one that cannot be read."""
    try:
        glb = Glb.read(path)
        entries = [entry for kind in ("buffers", "images") for entry in glb.document.get(kind, [])]
        linked = [_linked(glb, str(entry["uri"])) for entry in entries if "uri" in entry]
        names = {name for part in parts_of(glb) for name in part.names if is_safe_name(name)}
        beside = visible_files(path.parent)
        called = [texture_among(beside, name) for name in (NEUTRAL, MASK, *names)]
    except (FaceZipError, KeyError, TypeError, ValueError, AttributeError, OverflowError, IndexError):
        # Whoever loads it says why.
        return []
    files = {*filter(None, [*linked, *called]), path.parent / SETTINGS}
    return sorted(file for file in files if file.is_file())


def _linked(glb: Glb, uri: str) -> Path | None:
    try:
        return glb.links.file(uri)
    except GlbFault:
        # Nothing that the face needs, or that is said where it is loaded.
        return None
