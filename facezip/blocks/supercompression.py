"""Blocks under Zstandard: KTX2 files are so for the way over the wire, and loaders restore every byte (RFC 8878)."""

import numpy as np
from numpy.typing import NDArray
from zstandard import ZstdCompressor

from facezip.machine import memory

# The highest that any reader has memory for: those above have larger windows.
LEVEL = 19
# Bytes that are compressed at a time.
PIECE = 2**22


def supercompress(blocks: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """A frame of Zstandard, ``(bytes,)``, that holds ``(bytes,)`` of any codec."""
    compressor = ZstdCompressor(level=LEVEL).compressobj(size=len(blocks))
    # What cannot be made smaller takes a header, and three bytes for every 128 KB.
    frame: NDArray[np.uint8] = memory.empty((len(blocks) + len(blocks) // 1024 + 64,), np.uint8)
    end = 0
    for start in range(0, len(blocks), PIECE):
        end = _put(compressor.compress(blocks[start : start + PIECE].data), frame, end)
        memory.ease()
    return frame[: _put(compressor.flush(), frame, end)]


def _put(content: bytes, frame: NDArray[np.uint8], at: int) -> int:
    """Where the next bytes go."""
    frame[at : at + len(content)] = np.frombuffer(content, np.uint8)
    return at + len(content)
