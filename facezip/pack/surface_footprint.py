"""What a surface costs at run time, counted as :mod:`facezip.pack.footprint` does, shared weight maps once."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from facezip.pack.footprint import Footprint

if TYPE_CHECKING:
    from facezip.character.surface import Surface


@dataclass(frozen=True)
class SurfaceFootprint:
    """What a surface costs at run time.

    Attributes
    ----------
    tiles : for each tile, the footprint that each map would have alone, albedo first.
    """

    tiles: tuple[tuple[Footprint, ...], ...]

    @classmethod
    def of_scans(cls, surface: "Surface") -> "SurfaceFootprint":
        """What the uncompressed maps would cost."""
        count = len(surface.whole.expressions)
        return cls(
            tuple(
                tuple(Footprint(part.resolution, part.neutral.shape[2], 0, count, (1, 1)) for part in surface.on(tile))
                for tile in surface.tiles
            )
        )

    @property
    def bytes_on_gpu(self) -> int:
        """Bytes of all maps at 8 bits a channel; the weight maps of a tile count once."""
        return sum(one.bytes_on_gpu for tile in self.tiles for one in tile) - self._counted_again

    @property
    def bytes_bc7(self) -> int:
        """Bytes with every map's neutral and differences as BC7, whatever its channels; weight maps as above."""
        return sum(one.bytes_bc7 for tile in self.tiles for one in tile) - self._counted_again

    @property
    def bytes_raw(self) -> int:
        """Bytes of the neutrals and every expression's maps, uncompressed at 8 bits a channel."""
        return sum(one.bytes_raw for tile in self.tiles for one in tile)

    @property
    def bytes_raw_bc7(self) -> int:
        """Bytes of the neutrals and every expression's maps as BC7."""
        return sum(one.bytes_raw_bc7 for tile in self.tiles for one in tile)

    @property
    def fetches(self) -> int:
        """Texture fetches per pixel: neutral and differences of each map, and the weights; a pixel sees one tile."""
        maps = self.tiles[0]
        return maps[0].layers + sum(one.fetches - one.layers for one in maps)

    @property
    def _counted_again(self) -> int:
        """Bytes of the weight maps in the footprints of a tile's other maps."""
        return sum(one.weight_bytes for tile in self.tiles for one in tile[1:])
