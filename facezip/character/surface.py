"""A surface: every map on every tile of one person's scans."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import ALBEDO, KNOWN, MapKind
from facezip.character.neutrals import neutral_bits
from facezip.character.scans import Character
from facezip.files.obj import Topology

# Without UDIM, everything lies in the first tile.
FIRST_TILE = 1001
LAST_TILE = 1999


@dataclass(frozen=True, eq=False)
class Surface:
    """The scans of one person, with every map.

    Attributes
    ----------
    topology : faces and UV layout of the meshes, over all tiles.
    maps : the kinds, albedo first.
    parts : by map and tile (UDIM number), in that order of tiles: a character with the same meshes, whose UV has the
        tile in the unit square, and whose textures are the fitted texels (:class:`facezip.character.maps.MapKind`).
    """

    topology: Topology
    maps: tuple[MapKind, ...]
    parts: Mapping[tuple[str, int], Character]

    @classmethod
    def of(cls, character: Character) -> "Surface":
        """An albedo on one tile."""
        return cls(character.topology, (KNOWN[ALBEDO],), {(ALBEDO, FIRST_TILE): character})

    @property
    def whole(self) -> Character:
        """Any part, for what all of them share: name, expressions, vertices."""
        return next(iter(self.parts.values()))

    @property
    def tiles(self) -> tuple[int, ...]:
        """UDIM numbers, ascending."""
        return tuple(sorted({tile for _, tile in self.parts}))

    @property
    def ordinary(self) -> bool:
        """Whether there is nothing but one albedo of values in [0, 1]."""
        return self.tiles == (FIRST_TILE,) and self.maps == (KNOWN[ALBEDO],)

    def on(self, tile: int) -> list[Character]:
        """The maps of a tile, in the order of ``maps``."""
        return [self.parts[kind.name, tile] for kind in self.maps]

    def of_map(self, name: str) -> list[Character]:
        """A map's tiles, in the order of ``tiles``."""
        return [self.parts[name, tile] for tile in self.tiles]

    @property
    def neutral_bits(self) -> dict[tuple[str, int], int]:
        """By map and tile, the bits a channel of a stored neutral that keep what its file held: 8 or 16."""
        normal = {kind.name: kind.is_normal for kind in self.maps}
        return {key: neutral_bits(part.neutral.dtype, normal[key[0]]) for key, part in self.parts.items()}

    def only(self, *names: str) -> "Surface":
        """The same scans with fewer maps."""
        kinds = tuple(kind for kind in self.maps if kind.name in names)
        return replace(self, maps=kinds, parts={key: part for key, part in self.parts.items() if key[0] in names})

    @property
    def facts(self) -> dict[str, Any]:
        """As those of a character, with maps and tiles."""
        maps = [{"name": kind.name, "encoding": kind.encoding} for kind in self.maps]
        return {**self.whole.facts, "maps": maps, "tiles": list(self.tiles)}


def shifted(topology: Topology, tile: int) -> Topology:
    """The UV layout moved so that a UDIM tile lies in the unit square."""
    column, row = (tile - FIRST_TILE) % 10, (tile - FIRST_TILE) // 10
    if column == row == 0:
        return topology
    offset: NDArray[np.float32] = np.array([column, row], np.float32)
    return replace(topology, uv=topology.uv - offset)


def charts(topology: Topology, tiles: Sequence[int]) -> list[Topology]:
    """The faces that lie on each UDIM tile, by the middle of their corners, with that tile in the unit square.

    Faces that lie on none of them go to the nearest, so that none is lost.
    """
    middles = topology.uv[topology.face_uv].mean(axis=1)
    nearest, least = np.zeros(len(middles), np.intp), np.full(len(middles), np.inf)
    for number, tile in enumerate(tiles):
        # In squares: a face on a tile is less than half a side from its middle, and from that of no other.
        row, column = divmod(tile - FIRST_TILE, 10)
        distance = np.abs(middles - (column + 0.5, row + 0.5)).max(axis=1)
        nearest[distance <= least] = number
        least = np.minimum(distance, least)
    found = []
    for number, tile in enumerate(tiles):
        own = nearest == number
        part = replace(topology, faces=topology.faces[own], face_uv=topology.face_uv[own])
        found.append(shifted(part, tile))
    return found
