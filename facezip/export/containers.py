"""DDS and KTX2 files of one block-compressed texture with its levels; those of KTX2 are under Zstandard."""

import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facezip.blocks.supercompression import LEVEL, supercompress
from facezip.version import __version__

# The content of a file, piece by piece; ``(bytes,)`` of levels.
Pieces = Iterator[memoryview]
Levels = Sequence[NDArray[np.uint8]]

BLOCK_SIDE = 4

# DDS: Microsoft's programming guide, "DDS_HEADER" and "DDS_HEADER_DXT10".
_DDSD = 0x1 | 0x2 | 0x4 | 0x1000 | 0x20000 | 0x80000  # caps, height, width, pixel format, mip count, linear size
_DDSCAPS = 0x1000 | 0x400000 | 0x8  # texture, mip-map, complex

# KTX2: Khronos' specification 2.0; the data format descriptor is Khronos' basic block, version 1.3.
_KTX2 = b"\xabKTX 20\xbb\r\n\x1a\n"
_LINEAR, _SRGB = 1, 2
_ZSTANDARD = 2


@dataclass(frozen=True)
class Blocks:
    """What files call blocks of unsigned numbers from 0 to 1.

    Attributes
    ----------
    vulkan : the VkFormat in KTX2; 0 where a loader has to transcode.
    model : the colour model of KTX2's data format descriptor.
    samples : the parts of a block of 64 or 128 bits that hold a channel each, 1 where all are in one.
    bytes : of a block.
    dxgi : the DXGI_FORMAT in DDS; 0 for none.
    """

    vulkan: int
    model: int
    samples: int = 1
    bytes: int = 16
    dxgi: int = 0


BLOCKS = {
    "bc4": Blocks(139, 131, bytes=8, dxgi=80),
    "bc5": Blocks(141, 132, samples=2, dxgi=83),
    "bc7": Blocks(145, 134, dxgi=98),
    "uastc": Blocks(0, 166),
}


def dds(size: tuple[int, int], levels: Levels, blocks: Blocks) -> Pieces:
    """Levels, the largest first, as a DDS file with the DX10 header; ``size`` in rows and columns."""
    height, width = size
    pixel_format = struct.pack("<II4s20x", 32, 0x4, b"DX10")
    fields = struct.pack("<7I44x", 124, _DDSD, height, width, len(levels[0]), 0, len(levels))
    header = fields + pixel_format + struct.pack("<I16x", _DDSCAPS)
    yield memoryview(b"DDS " + header + struct.pack("<5I", blocks.dxgi, 3, 0, 1, 0))
    yield from (level.data for level in levels)


def ktx2(size: tuple[int, int], levels: Levels, blocks: Blocks, srgb: bool = False) -> Pieces:
    """Levels, the largest first, as a KTX2 file of one 2D texture; ``size`` in rows and columns.

    ``srgb`` says that a loader should make the values linear; those of maps that are blended are plain numbers.
    """
    height, width = size
    descriptor = _descriptor(blocks, srgb)
    values = _entry("KTXorientation", "rd") + _entry("KTXwriter", f"facezip {__version__}")
    values += _entry("KTXwriterScParams", f"--zstd {LEVEL}")
    begin = 80 + 24 * len(levels)
    header = struct.pack("<9I", blocks.vulkan, 1, width, height, 0, 0, 1, len(levels), _ZSTANDARD)
    header += struct.pack("<4I2Q", begin, len(descriptor), begin + len(descriptor), len(values), 0, 0)
    frames = [supercompress(level) for level in levels]
    # The smallest level lies first; frames need no alignment.
    start, index = begin + len(descriptor) + len(values), b""
    for number, (frame, level) in enumerate(zip(frames, levels, strict=True)):
        at = start + sum(map(len, frames[number + 1 :]))
        index += struct.pack("<3Q", at, len(frame), len(level))
    yield memoryview(_KTX2 + header + index + descriptor + values)
    yield from (frame.data for frame in reversed(frames))


def _descriptor(blocks: Blocks, srgb: bool) -> bytes:
    layout = (BLOCK_SIDE - 1, BLOCK_SIDE - 1, 0, 0, blocks.bytes, 0, 0, 0, 0, 0, 0, 0)
    basic = (
        struct.pack("<IHH", 0, 2, 24 + 16 * blocks.samples)  # vendor Khronos, basic; version 2, its length
        + bytes((blocks.model, 1, _SRGB if srgb else _LINEAR, 0))  # BT.709 primaries; straight alpha
        + bytes(layout)
        + b"".join(_sample(blocks, number) for number in range(blocks.samples))
    )
    return struct.pack("<I", 4 + len(basic)) + basic


def _sample(blocks: Blocks, number: int) -> bytes:
    """Where the bits of a channel are, and that they say numbers from 0 to 1."""
    bits = 8 * blocks.bytes // blocks.samples
    return struct.pack("<HBBIII", number * bits, bits - 1, number, 0, 0, 0xFFFFFFFF)


def _entry(key: str, value: str) -> bytes:
    content = key.encode() + b"\0" + value.encode() + b"\0"
    entry = struct.pack("<I", len(content)) + content
    return entry + bytes(-len(entry) % 4)
