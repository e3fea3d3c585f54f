"""Block codecs of GPUs, each as the round trip that a texture makes: 8-bit texels in, what a sampler sees out.

Encoders and decoders are kept libraries: astcenc for ASTC, etcpak for BC1 and BC7, texture2ddecoder for decoding all of
them; all store the alpha of an RGB texture as opaque. BC4 and BC5 are coded here (:mod:`facezip.blocks.bc4`).
"""

from collections.abc import Callable, Iterator
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

from facezip.blocks import bc4 as one_channel
from facezip.files.images import Texels
from facezip.machine import memory

EFFORTS = {
    "fast": ASTCQualityPreset.FAST,
    "medium": ASTCQualityPreset.MEDIUM,
    "thorough": ASTCQualityPreset.THOROUGH,
}
ASTC_BLOCKS = ((4, 4), (5, 5), (6, 5), (6, 6), (8, 6), (8, 8), (10, 8), (10, 10), (12, 10), (12, 12))

# Texels ``(H, W, C)`` of whole blocks to bytes, and bytes and rows and columns to what a sampler sees.
Encode = Callable[[NDArray[np.uint8]], bytes]
Decode = Callable[[bytes, int, int], Texels]
# Of libraries: RGBA texels, width and height to blocks; blocks, width and height to BGRA texels.
LibraryCall = Callable[[bytes, int, int], bytes]
# Rows of texels that are coded at a time, or a little fewer.
BAND = 32


@dataclass(frozen=True)
class Codec:
    """A way in which a texture lies in GPU memory.

    Attributes
    ----------
    name : ``"raw"``, ``"bc1"``, ``"bc7"``, ``"astc_6x6"`` ...
    block : width and height of a block in texels.
    block_bytes : bytes of a block.
    encode, decode : of whole blocks; None for raw.
    channels : how many it keeps, the first of a texture.
    sampled : the type of what a sampler sees; uint16 where it interpolates more finely than 8 bits.
    band : rows that are coded at a time; 0 for whole textures.
    """

    name: str
    block: tuple[int, int]
    block_bytes: int
    encode: Encode | None = None
    decode: Decode | None = None
    channels: int = 3
    sampled: type[np.uint8] | type[np.uint16] = np.uint8
    band: int = BAND

    def bytes_of(self, height: int, width: int) -> int:
        """Bytes of one texture."""
        return -(-width // self.block[0]) * -(-height // self.block[1]) * self.block_bytes

    def round_trip(self, texels: NDArray[np.uint8]) -> Texels:
        """What the GPU gives back of ``(H, W, C)`` texels, C ≤ 4, of the channels that are kept."""
        return texels if self.encode is None else self.load(self.store(texels), texels.shape)

    def store(self, texels: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """The bytes of ``(H, W, C)`` texels, C ≤ 4, blocks row by row; one channel is grey; raw texels stay as is."""
        if self.encode is None:
            return np.ascontiguousarray(texels).reshape(-1)
        stored: NDArray[np.uint8] = memory.empty((self.bytes_of(*texels.shape[:2]),), np.uint8)
        across, down = self.block
        for rows, place in self._bands(*texels.shape[:2]):
            band = texels[rows]
            # Blocks at the border hold more of the same rather than black.
            past = (0, -len(band) % down), (0, -band.shape[1] % across), (0, 0)
            stored[place] = np.frombuffer(self.encode(np.pad(band, past, mode="edge")), np.uint8)
            memory.ease()
        return stored

    def load(self, stored: NDArray[np.uint8], shape: tuple[int, ...]) -> Texels:
        """The ``(H, W, C)`` texels of such bytes, of the channels that are kept."""
        if self.decode is None:
            return stored.reshape(shape)
        height, width, channels = shape
        texels: Texels = memory.empty((height, width, min(channels, self.channels)), self.sampled)
        for rows, place in self._bands(height, width):
            band = self.decode(stored[place].tobytes(), rows.stop - rows.start, width)
            texels[rows] = band[..., : texels.shape[2]]
            memory.ease()
        return texels

    def _bands(self, height: int, width: int) -> Iterator[tuple[slice, slice]]:
        """Rows of texels, and where their blocks are."""
        step = self.band // self.block[1] * self.block[1] or height
        for top in range(0, height, step):
            bottom = min(top + step, height)
            start = self.bytes_of(top, width)
            yield slice(top, bottom), slice(start, start + self.bytes_of(bottom - top, width))


def raw(channels: int) -> Codec:
    """8 bits a channel, as they are."""
    return Codec("raw", (1, 1), channels, channels=channels)


def bc1() -> Codec:
    """BC1: half a byte a texel, on every desktop."""
    return of_library("bc1", (4, 4), 8, etcpak.compress_bc1, texture2ddecoder.decode_bc1)


def bc4() -> Codec:
    """BC4: half a byte a texel of one channel, on every desktop."""
    return _interpolated("bc4", 1)


def bc5() -> Codec:
    """BC5: one byte a texel of two channels that are independent of each other, on every desktop."""
    return _interpolated("bc5", 2)


def bc7(channels: int = 3) -> Codec:
    """BC7: one byte a texel of three channels or four, on every desktop."""
    parameters = etcpak.BC7CompressBlockParams()
    parameters.init_linear_weights()
    # The highest: 5 % less error in 1.4 to 2 times the time.
    parameters.m_uber_level = 4

    def encode(texels: bytes, width: int, height: int) -> bytes:
        return etcpak.compress_bc7(texels, width, height, parameters)

    return of_library("bc7", (4, 4), 16, encode, texture2ddecoder.decode_bc7, channels=channels)


def astc(block: tuple[int, int], effort: str = "medium", channels: int = 3) -> Codec:
    """ASTC: 16 bytes a block of any of ``ASTC_BLOCKS``, on every phone; ``effort`` one of ``EFFORTS``; RGB or RGBA."""

    def encode(texels: bytes, width: int, height: int) -> bytes:
        image = ASTCImage(ASTCType.U8, width, height, 1, texels)
        return _astc_context(block, effort).compress(image, ASTCSwizzle())

    def decode(stored: bytes, width: int, height: int) -> bytes:
        return texture2ddecoder.decode_astc(stored, width, height, *block)

    return of_library(f"astc_{block[0]}x{block[1]}", block, 16, encode, decode, channels=channels)


@cache
def _astc_context(block: tuple[int, int], effort: str) -> ASTCContext:
    # One thread: with more the encoder's blocks are the same, but it is hardly faster.
    return ASTCContext(ASTCConfig(ASTCProfile.LDR, *block, 1, EFFORTS[effort], ASTCConfigFlags(0)))


def of_library(
    name: str,
    block: tuple[int, int],
    block_bytes: int,
    encode: LibraryCall,
    decode: LibraryCall,
    band: int = BAND,
    channels: int = 3,
) -> Codec:
    """A codec whose encoder takes RGBA texels and whose decoder gives BGRA texels, both of whole blocks."""
    across, down = block
    order = slice(2, None, -1) if channels == 3 else [2, 1, 0, 3][:channels]

    def blocks(texels: NDArray[np.uint8]) -> bytes:
        height, width, kept = texels.shape
        rgba = np.full((height, width, 4), 255, np.uint8)
        # One channel is grey.
        rgba[..., : 3 if kept == 1 else kept] = texels
        return encode(rgba.tobytes(), width, height)

    def texels(stored: bytes, height: int, width: int) -> NDArray[np.uint8]:
        rows, columns = -(-height // down) * down, -(-width // across) * across
        bgra = np.frombuffer(decode(stored, columns, rows), np.uint8).reshape(rows, columns, 4)
        return bgra[:height, :width, order]

    return Codec(name, block, block_bytes, blocks, texels, channels, band=band)


def _interpolated(name: str, channels: int) -> Codec:
    """BC4, or as many blocks of it beside each other as there are channels."""

    def blocks(texels: NDArray[np.uint8]) -> bytes:
        values = texels[..., :channels].astype(np.float32) / np.float32(255)
        return np.stack([one_channel.encode(values[..., k]) for k in range(channels)], axis=1).tobytes()

    def texels(stored: bytes, height: int, width: int) -> NDArray[np.uint16]:
        many = np.frombuffer(stored, "<u8").reshape(-1, channels)
        seen = [one_channel.decode(many[:, k], height, width) for k in range(channels)]
        return np.rint(np.stack(seen, axis=2) * np.float32(65535)).astype(np.uint16)

    return Codec(name, (4, 4), 8 * channels, blocks, texels, channels=channels, sampled=np.uint16)
