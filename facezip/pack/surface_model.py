"""A compressed surface: equation (1) for every map on every tile, with weight maps that the maps of a tile share."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import ALBEDO, KNOWN, MapKind
from facezip.character.surface import FIRST_TILE
from facezip.pack.model import CompressedTextures, Meshes
from facezip.pack.surface_footprint import SurfaceFootprint


@dataclass(frozen=True, eq=False)
class CompressedSurface:
    """Difference textures of every map, weight maps of every tile.

    Attributes
    ----------
    maps : the kinds, albedo first.
    parts : by map and tile; the parts of a tile have the same ``weights``, and none has ``meshes``.
    meshes : the geometry, whose UV spans all tiles, or None.
    """

    maps: tuple[MapKind, ...]
    parts: Mapping[tuple[str, int], CompressedTextures]
    meshes: Meshes | None = None

    @classmethod
    def of(cls, model: CompressedTextures) -> "CompressedSurface":
        """An albedo on one tile."""
        return cls((KNOWN[ALBEDO],), {(ALBEDO, FIRST_TILE): model}, model.meshes)

    @property
    def whole(self) -> CompressedTextures:
        """Any part, for what all of them share: expressions and method."""
        return next(iter(self.parts.values()))

    @property
    def expressions(self) -> tuple[str, ...]:
        """N names in the order of the weight maps."""
        return self.whole.expressions

    @property
    def method(self) -> str:
        """What fitted it."""
        return self.whole.method

    @property
    def tiles(self) -> tuple[int, ...]:
        """UDIM numbers, ascending."""
        return tuple(sorted({tile for _, tile in self.parts}))

    @property
    def ordinary(self) -> bool:
        """Whether there is nothing but one albedo of values in [0, 1]."""
        return self.tiles == (FIRST_TILE,) and self.maps == (KNOWN[ALBEDO],)

    @property
    def footprint(self) -> SurfaceFootprint:
        """Bytes and fetches at run time."""
        return SurfaceFootprint(
            tuple(tuple(self.parts[kind.name, tile].footprint for kind in self.maps) for tile in self.tiles)
        )

    def blend(self, kind: MapKind, tile: int, weights: Mapping[str, float]) -> NDArray[np.float32]:
        """Values ``(H, W, C)`` of a map on a tile for a blend β (equations 8 and 12); unit vectors of a normal map.

        Raises
        ------
        FaceZipError
            As :meth:`facezip.pack.model.CompressedTextures.blend`.
        """
        return kind.values(self.parts[kind.name, tile].blend(weights))
