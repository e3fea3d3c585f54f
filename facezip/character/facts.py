"""What documents say of a character."""

from collections.abc import Sequence
from dataclasses import dataclass

from facezip.character.maps import Encoding


@dataclass(frozen=True, kw_only=True)
class MapName:
    """One map of a character.

    Attributes
    ----------
    name : ``albedo``, ``normal``, ``roughness``, ``specular``, ``cavity``, or what ``character.toml`` calls it.
    encoding : what its numbers stand for: sRGB-encoded colours, data as it is, or unit vectors.
    """

    name: str
    encoding: Encoding


@dataclass(frozen=True, kw_only=True)
class CharacterFacts:
    """Scans of one person.

    Attributes
    ----------
    name : of the character.
    expressions : names, without the neutral.
    resolution : rows and columns of the first map on the first tile.
    channels : of the first map.
    vertices, triangles : of the neutral's mesh.
    maps : albedo first.
    tiles : UDIM numbers, ascending.
    notes : what its files say that is not ordinary, and what was done about it, one sentence each.
    """

    name: str
    expressions: Sequence[str]
    resolution: tuple[int, int]
    channels: int
    vertices: int
    triangles: int
    maps: Sequence[MapName]
    tiles: Sequence[int]
    notes: Sequence[str]
