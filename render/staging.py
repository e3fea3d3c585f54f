"""A character with any maps and tiles as renderers see it: one square of UV, and the skin of every expression."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import Key
from facezip.character.scans import Character
from facezip.character.tiles import Atlas
from facezip.files.images import Texels
from facezip.files.obj import Topology
from render.skins import RENDERED, SkinMaps

# Gives the texels of a map on a tile for an expression or ``neutral``.
Source = Callable[[str, Key], Texels]


def staged_topology(character: Character) -> Topology:
    """The UV layout with all tiles in one square."""
    return Atlas.of(character.tiles).topology(character.meshes.topology)


def rendered_maps(character: Character) -> list[str]:
    """The maps of a character that renderers know; others are compressed and measured."""
    return [kind.name for kind in character.maps if kind.name in RENDERED]


def staged_original(character: Character) -> Callable[[str], SkinMaps]:
    """What is rendered of the scans, by the name of an expression or ``neutral``."""
    return staged(character, character.texels)


def staged(character: Character, texels: Source) -> Callable[[str], SkinMaps]:
    """A skin of all the maps that renderers know, with the tiles of each in one texture."""

    def skin(name: str) -> SkinMaps:
        return SkinMaps(**{kind: staged_map(character, kind, name, texels) for kind in rendered_maps(character)})

    return skin


def staged_map(character: Character, map: str, name: str, texels: Source) -> NDArray[np.float32]:
    """Values of one map of an expression or ``neutral``, the tiles in one texture."""
    kind = character.kind(map)
    return Atlas.of(character.tiles).joined({tile: kind.decode(texels(name, (map, tile))) for tile in character.tiles})
