"""What textures cost at run time: bytes of GPU memory and fetches per pixel (the paper's Table 1)."""

from dataclasses import dataclass

SLOTS_PER_LAYER = 4


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
    def weight_bytes(self) -> int:
        """What of :attr:`bytes_on_gpu` is weight maps."""
        return self.expressions * self.weight_size[0] * self.weight_size[1] * SLOTS_PER_LAYER * self.layers

    @property
    def bytes_raw(self) -> int:
        """Bytes of the neutral and every expression texture, uncompressed at 8 bits a channel."""
        return (1 + self.expressions) * self._texture

    @property
    def _texture(self) -> int:
        return self.size[0] * self.size[1] * self.channels
