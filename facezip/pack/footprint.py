"""What a character costs at run time: bytes of GPU memory and fetches per pixel.

Bytes of textures are counted in two ways. At 8 bits a channel, as the paper's Table 1 does: three bytes a texel of an
RGB texture. And in the blocks that engines hold, neutral, differences and every rival texture as BC7, 16 bytes for
4 x 4 texels, and the weight maps as RGBA of 8 bits, as exports have them (docs/engines.md). Neither counts mip-maps, a
third more of textures and nothing of weight maps, nor the target that weight maps are blended into, 8 bytes a texel of
one of them for every head on the screen. Geometry is counted beside them: the bytes of the mesh and its morph targets.
"""

from collections.abc import Iterator
from dataclasses import dataclass

SLOTS_PER_LAYER = 4
BLOCK_SIDE, BLOCK_BYTES = 4, 16
# How many times smaller than textures a fit makes weight maps.
WEIGHT_SCALES = (4, 8, 16, 32)


@dataclass(frozen=True)
class Texture:
    """The size of a texture: rows, columns and channels."""

    height: int
    width: int
    channels: int

    @property
    def plain(self) -> int:
        """Bytes at 8 bits a channel."""
        return self.height * self.width * self.channels

    @property
    def blocks(self) -> int:
        """Bytes as BC7, whatever the channels: 16·⌈H/4⌉·⌈W/4⌉."""
        return -(-self.height // BLOCK_SIDE) * -(-self.width // BLOCK_SIDE) * BLOCK_BYTES


@dataclass(frozen=True)
class Footprint:
    """The sizes of a character's textures, from which its cost follows.

    Attributes
    ----------
    tiles : for each tile, the size of a texture of each map, albedo first.
    weight_sizes : for each tile, rows and columns of a weight map, which its maps share; ``(1, 1)`` for uniform
        weights, which are shader constants.
    differences : number R of difference textures a map; 0 for textures that are not compressed.
    expressions : number N of expressions.
    geometry : bytes of the mesh and its morph targets, as a pack holds them; 0 without.
    masks : number K of masks that stand in place of the expressions' weight maps; 0 where those are stored.
    """

    tiles: tuple[tuple[Texture, ...], ...]
    weight_sizes: tuple[tuple[int, ...], ...]
    differences: int
    expressions: int
    geometry: int = 0
    masks: int = 0

    @property
    def layers(self) -> int:
        """RGBA layers that the R slots of a weight map fill; 0 where weights are uniform."""
        uniform = all(size == (1, 1) for size in self.weight_sizes)
        return 0 if uniform else -(-self.differences // SLOTS_PER_LAYER)

    @property
    def weight_scale(self) -> int | None:
        """How many times smaller weight maps are than textures, of :data:`WEIGHT_SCALES`: s of h = ⌈H/s⌉, w = ⌈W/s⌉.

        None where weights are uniform, or of a size that no fit makes.
        """
        firsts = [tile[0] for tile in self.tiles]
        fitting = (
            scale
            for scale in WEIGHT_SCALES
            if self.weight_sizes == tuple((-(-first.height // scale), -(-first.width // scale)) for first in firsts)
        )
        return next(fitting, None) if self.layers else None

    @property
    def fetches(self) -> int:
        """Texture fetches per pixel, which sees one tile: neutral and differences of each map, and the weights that
        were blended in a pre-pass.
        """
        return self.layers + len(self.tiles[0]) * (1 + self.differences)

    @property
    def bytes_on_gpu(self) -> int:
        """Bytes of all textures at 8 bits a channel: 15·R² + 4·N·(R/8)² in the paper's notation for size and N."""
        return (1 + self.differences) * sum(texture.plain for texture in self._textures) + self.weight_bytes

    @property
    def bytes_bc7(self) -> int:
        """Bytes with neutrals and differences as BC7: (1 + R) · B + 4·N·h·w·⌈R/4⌉."""
        return (1 + self.differences) * sum(texture.blocks for texture in self._textures) + self.weight_bytes

    @property
    def bits_per_value(self) -> float:
        """Bits of BC7 and weight maps per texel and channel of the N expressions that they stand for."""
        values = self.expressions * sum(texture.plain for texture in self._textures)
        return 8 * self.bytes_bc7 / values

    @property
    def weight_bytes(self) -> int:
        """Weight maps of h x w texels on every tile, RGBA of 8 bits: 4·N·h·w·⌈R/4⌉; of masks 4·h·w·⌈K/4⌉."""
        texels = sum(height * width for height, width in self.weight_sizes)
        images = -(-self.masks // SLOTS_PER_LAYER) if self.masks else self.expressions * self.layers
        return images * texels * SLOTS_PER_LAYER

    @property
    def bytes_raw(self) -> int:
        """Bytes of the neutral and every expression's textures, uncompressed at 8 bits a channel."""
        return (1 + self.expressions) * sum(texture.plain for texture in self._textures)

    @property
    def bytes_raw_bc7(self) -> int:
        """Bytes of the neutral and every expression's textures as BC7: (1 + N) · B."""
        return (1 + self.expressions) * sum(texture.blocks for texture in self._textures)

    @property
    def _textures(self) -> Iterator[Texture]:
        return (texture for tile in self.tiles for texture in tile)
