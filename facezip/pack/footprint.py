"""What textures cost at run time: bytes of GPU memory and fetches per pixel.

Bytes are counted in two ways. At 8 bits a channel, as the paper's Table 1 does: three bytes a texel of an RGB texture.
And in the blocks that engines hold, neutral, differences and every rival texture as BC7, 16 bytes for 4 x 4 texels,
and the weight maps as RGBA of 8 bits, as exports have them (docs/engines.md). Neither counts mip-maps, a third more of
textures and nothing of weight maps, nor the target that weight maps are blended into, 8 bytes a texel of one of them
for every head on the screen.
"""

from dataclasses import dataclass

SLOTS_PER_LAYER = 4
BLOCK_SIDE, BLOCK_BYTES = 4, 16


@dataclass(frozen=True)
class Footprint:
    """The sizes of a compressed character, from which its cost follows.

    Attributes
    ----------
    size : rows and columns of the textures.
    channels : channels of a texture.
    differences : number R of difference textures.
    expressions : number N of expressions.
    weight_size : rows and columns of a weight map; ``(1, 1)`` for uniform weights, which are shader constants.
    """

    size: tuple[int, int]
    channels: int
    differences: int
    expressions: int
    weight_size: tuple[int, int]

    @property
    def layers(self) -> int:
        """RGBA layers that the R slots of a weight map fill; 0 where weights are uniform."""
        return 0 if self.weight_size == (1, 1) else -(-self.differences // SLOTS_PER_LAYER)

    @property
    def fetches(self) -> int:
        """Texture fetches per pixel of the shader: neutral, differences, and the weights blended in a pre-pass."""
        return 1 + self.differences + self.layers

    @property
    def bytes_on_gpu(self) -> int:
        """Bytes of all maps at 8 bits a channel: 15·R² + 4·N·(R/8)² in the paper's notation for size and N."""
        return (1 + self.differences) * self._texture + self.weight_bytes

    @property
    def bytes_bc7(self) -> int:
        """Bytes with neutral and differences as BC7: (1 + R) · B + 4·N·h·w·⌈R/4⌉, B = 16·⌈H/4⌉·⌈W/4⌉."""
        return (1 + self.differences) * self._blocks + self.weight_bytes

    @property
    def weight_bytes(self) -> int:
        """Weight maps of h x w texels, RGBA of 8 bits: 4·N·h·w·⌈R/4⌉."""
        return self.expressions * self.weight_size[0] * self.weight_size[1] * SLOTS_PER_LAYER * self.layers

    @property
    def bytes_raw(self) -> int:
        """Bytes of the neutral and every expression texture, uncompressed at 8 bits a channel."""
        return (1 + self.expressions) * self._texture

    @property
    def bytes_raw_bc7(self) -> int:
        """Bytes of the neutral and every expression texture as BC7: (1 + N) · B."""
        return (1 + self.expressions) * self._blocks

    @property
    def _texture(self) -> int:
        return self.size[0] * self.size[1] * self.channels

    @property
    def _blocks(self) -> int:
        height, width = self.size
        return -(-height // BLOCK_SIDE) * -(-width // BLOCK_SIDE) * BLOCK_BYTES
