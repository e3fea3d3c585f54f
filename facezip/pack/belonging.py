"""Does a pack, or another character, belong to some scans: the same expressions, maps, tiles and sizes."""

from collections.abc import Mapping
from pathlib import Path

from facezip.character.maps import Key
from facezip.character.scans import Character
from facezip.errors import ErrorCode, FaceZipError
from facezip.pack.manifest import Manifest
from facezip.pack.model import CompressedTextures

Other = CompressedTextures | Manifest | Character


def check_belongs(character: Character, other: Other, path: Path) -> None:
    """Raise where something lacks an expression or a texture of a character, or has one of another size.

    Raises
    ------
    FaceZipError
        ``UNKNOWN_NAME`` or ``SIZE_MISMATCH``, naming ``path``.
    """
    missing = [name for name in character.expressions if name not in other.expressions]
    if missing:
        raise FaceZipError(
            ErrorCode.UNKNOWN_NAME,
            f"{path}: has no expression '{missing[0]}', which {character.name} has; give what was made from "
            f"{character.name}",
        )
    check_sizes(character, other, path)


def check_sizes(character: Character, other: Other, path: Path) -> None:
    """As :func:`check_belongs`, whatever the expressions."""
    theirs = _shapes(other)
    for (name, tile), shape in _shapes(character).items():
        found = theirs.get((name, tile))
        if found != shape:
            words = "is missing" if found is None else f"has {found[1]}x{found[0]} texels of {found[2]} channel(s)"
            raise FaceZipError(
                ErrorCode.SIZE_MISMATCH,
                f"{path}: its {name} on tile {tile} {words}, {character.name} has {shape[1]}x{shape[0]} of {shape[2]}; "
                "compress it again",
            )


def _shapes(whose: Other) -> Mapping[Key, tuple[int, ...]]:
    if isinstance(whose, Manifest):
        return {key: (*texture.size, entry.channels) for key, (entry, texture) in whose.entries().items()}
    parts = whose.stacks if isinstance(whose, Character) else whose.parts
    return {key: part.neutral.shape for key, part in parts.items()}
