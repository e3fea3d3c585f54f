"""DDS and KTX2 files of one block-compressed texture with its levels."""

import struct
from collections.abc import Sequence
from dataclasses import dataclass

from facezip import __version__

BLOCK_BYTES, BLOCK_SIDE = 16, 4

# DDS: Microsoft's programming guide, "DDS_HEADER" and "DDS_HEADER_DXT10".
_DDSD = 0x1 | 0x2 | 0x4 | 0x1000 | 0x20000 | 0x80000  # caps, height, width, pixel format, mip count, linear size
_DDSCAPS = 0x1000 | 0x400000 | 0x8  # texture, mip-map, complex
_DXGI_BC7_UNORM = 98

# KTX2: Khronos' specification 2.0; the data format descriptor is Khronos' basic block, version 1.3.
_KTX2 = b"\xabKTX 20\xbb\r\n\x1a\n"
_LINEAR, _SRGB = 1, 2


@dataclass(frozen=True)
class Ktx2Format:
    """What a KTX2 file calls its blocks.

    Attributes
    ----------
    vulkan : the VkFormat; 0 where a loader has to transcode.
    model : the colour model of the data format descriptor.
    """

    vulkan: int
    model: int


BC7_UNORM = Ktx2Format(145, 134)
UASTC = Ktx2Format(0, 166)


def dds(size: tuple[int, int], levels: Sequence[bytes]) -> bytes:
    """BC7 levels, the largest first, as a DDS file with the DX10 header; ``size`` in rows and columns."""
    height, width = size
    pixel_format = struct.pack("<II4s20x", 32, 0x4, b"DX10")
    fields = struct.pack("<7I44x", 124, _DDSD, height, width, len(levels[0]), 0, len(levels))
    header = fields + pixel_format + struct.pack("<I16x", _DDSCAPS)
    return b"DDS " + header + struct.pack("<5I", _DXGI_BC7_UNORM, 3, 0, 1, 0) + b"".join(levels)


def ktx2(size: tuple[int, int], levels: Sequence[bytes], form: Ktx2Format, srgb: bool = False) -> bytes:
    """Levels, the largest first, as a KTX2 file of one 2D texture; ``size`` in rows and columns.

    ``srgb`` says that a loader should make the values linear; those of maps that are blended are plain numbers.
    """
    height, width = size
    descriptor = _descriptor(form, srgb)
    values = _entry("KTXorientation", "rd") + _entry("KTXwriter", f"facezip {__version__}")
    begin = 80 + 24 * len(levels)
    header = struct.pack("<9I", form.vulkan, 1, width, height, 0, 0, 1, len(levels), 0)
    header += struct.pack("<4I2Q", begin, len(descriptor), begin + len(descriptor), len(values), 0, 0)
    # The smallest level lies first, each aligned to a block.
    start = _aligned(begin + len(descriptor) + len(values))
    offsets, body = {}, bytearray()
    for number in reversed(range(len(levels))):
        offsets[number] = start + len(body)
        body += levels[number]
    index = b"".join(struct.pack("<3Q", offsets[n], len(level), len(level)) for n, level in enumerate(levels))
    before = _KTX2 + header + index + descriptor + values
    return before.ljust(start, b"\0") + bytes(body)


def _descriptor(form: Ktx2Format, srgb: bool) -> bytes:
    blocks = (BLOCK_SIDE - 1, BLOCK_SIDE - 1, 0, 0, BLOCK_BYTES, 0, 0, 0, 0, 0, 0, 0)
    basic = (
        struct.pack("<IHH", 0, 2, 40)  # vendor Khronos, basic; version 2, 40 bytes
        + bytes((form.model, 1, _SRGB if srgb else _LINEAR, 0))  # BT.709 primaries; straight alpha
        + bytes(blocks)
        + struct.pack("<HBBIII", 0, 127, 0, 0, 0, 0xFFFFFFFF)  # one sample of 128 bits
    )
    return struct.pack("<I", 4 + len(basic)) + basic


def _entry(key: str, value: str) -> bytes:
    content = key.encode() + b"\0" + value.encode() + b"\0"
    entry = struct.pack("<I", len(content)) + content
    return entry + bytes(-len(entry) % 4)


def _aligned(offset: int) -> int:
    return -(-offset // BLOCK_BYTES) * BLOCK_BYTES
