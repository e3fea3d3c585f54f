"""Block codecs of GPUs, each as the round trip that a texture makes: 8-bit texels in, what a sampler sees out.

Encoders and decoders are kept libraries: astcenc for ASTC, etcpak for BC1 and BC7, texture2ddecoder for decoding all of
them. All store the alpha of an RGB texture as opaque.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import etcpak
import numpy as np
import texture2ddecoder
from astc_encoder import (
    ASTCConfig,
    ASTCConfigFlags,
    ASTCContext,
    ASTCImage,
    ASTCProfile,
    ASTCQualityPreset,
    ASTCSwizzle,
    ASTCType,
)
from numpy.typing import NDArray

EFFORTS = {
    "fast": ASTCQualityPreset.FAST,
    "medium": ASTCQualityPreset.MEDIUM,
    "thorough": ASTCQualityPreset.THOROUGH,
}
ASTC_BLOCKS = ((4, 4), (5, 5), (6, 6), (8, 6), (8, 8), (10, 8), (10, 10), (12, 10), (12, 12))

Bytes = Callable[[bytes, int, int], bytes]


@dataclass(frozen=True)
class Codec:
    """A way in which a texture lies in GPU memory.

    Attributes
    ----------
    name : ``"raw"``, ``"bc1"``, ``"bc7"``, ``"astc_6x6"`` ...
    block : width and height of a block in texels.
    block_bytes : bytes of a block.
    encode, decode : RGBA texels, width and height to blocks; blocks, width and height to BGRA texels. None for raw.
    """

    name: str
    block: tuple[int, int]
    block_bytes: int
    encode: Bytes | None = None
    decode: Bytes | None = None

    def bytes_of(self, height: int, width: int) -> int:
        """Bytes of one texture."""
        return -(-width // self.block[0]) * -(-height // self.block[1]) * self.block_bytes

    def round_trip(self, texels: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """What the GPU gives back of ``(H, W, C)`` texels, C ≤ 3; one channel is coded as grey."""
        return texels if self.encode is None else self.load(self.store(texels), texels.shape)

    def store(self, texels: NDArray[np.uint8]) -> bytes:
        """The blocks of ``(H, W, C)`` texels, C ≤ 3, row by row; raw texels as they lie."""
        if self.encode is None:
            return np.ascontiguousarray(texels).tobytes()
        height, width, _ = texels.shape
        padded = np.empty((self._whole(height, 1), self._whole(width, 0), 4), np.uint8)
        padded[:height, :width, :3] = texels
        # Blocks at the border hold more of the same rather than black.
        padded[height:, :width, :3] = texels[-1]
        padded[:, width:, :3] = padded[:, width - 1 : width, :3]
        padded[..., 3] = 255
        return self.encode(padded.tobytes(), padded.shape[1], padded.shape[0])

    def load(self, stored: bytes, shape: tuple[int, ...]) -> NDArray[np.uint8]:
        """The ``(H, W, C)`` texels of such blocks."""
        height, width, channels = shape
        if self.decode is None:
            return np.frombuffer(stored, np.uint8).reshape(shape)
        rows, columns = self._whole(height, 1), self._whole(width, 0)
        decoded = np.frombuffer(self.decode(stored, columns, rows), np.uint8).reshape(rows, columns, 4)
        rgb: NDArray[np.uint8] = decoded[:height, :width, 2::-1][..., :channels]
        return rgb

    def _whole(self, size: int, axis: int) -> int:
        return -(-size // self.block[axis]) * self.block[axis]


def raw(channels: int) -> Codec:
    """8 bits a channel, as they are."""
    return Codec("raw", (1, 1), channels)


def bc1() -> Codec:
    """BC1: half a byte a texel, on every desktop."""
    return Codec("bc1", (4, 4), 8, etcpak.compress_bc1, texture2ddecoder.decode_bc1)


def bc7() -> Codec:
    """BC7: one byte a texel, on every desktop."""
    parameters = etcpak.BC7CompressBlockParams()
    parameters.init_linear_weights()

    def encode(texels: bytes, width: int, height: int) -> bytes:
        return etcpak.compress_bc7(texels, width, height, parameters)

    return Codec("bc7", (4, 4), 16, encode, texture2ddecoder.decode_bc7)


def astc(block: tuple[int, int], effort: str = "medium") -> Codec:
    """ASTC: 16 bytes a block of any of ``ASTC_BLOCKS``, on every phone; ``effort`` one of ``EFFORTS``."""

    def encode(texels: bytes, width: int, height: int) -> bytes:
        image = ASTCImage(ASTCType.U8, width, height, 1, texels)
        return _astc_context(block, effort).compress(image, ASTCSwizzle())

    def decode(stored: bytes, width: int, height: int) -> bytes:
        return texture2ddecoder.decode_astc(stored, width, height, *block)

    return Codec(f"astc_{block[0]}x{block[1]}", block, 16, encode, decode)


@cache
def _astc_context(block: tuple[int, int], effort: str) -> ASTCContext:
    # One thread: with more the encoder's blocks are the same, but it is hardly faster.
    return ASTCContext(ASTCConfig(ASTCProfile.LDR, *block, 1, EFFORTS[effort], ASTCConfigFlags(0)))
