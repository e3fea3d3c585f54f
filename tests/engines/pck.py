"""Godot's project archives: PCK files of format 3, as its editor exports them for 4.6."""

import hashlib
import struct
from collections.abc import Mapping

MAGIC, FORMAT, ENGINE = b"GDPC", 3, (4, 6, 0)
RELATIVE_TO_FILES = 2
HEADER = struct.Struct("<4s5I2Q64x")


def pck(files: Mapping[str, bytes]) -> bytes:
    """An archive of files by their paths, without ``res://``; the directory lies behind them."""
    body, directory = bytearray(), struct.pack("<I", len(files))
    for path, content in files.items():
        name = path.encode()
        name += bytes(-len(name) % 4)
        directory += struct.pack("<I", len(name)) + name + struct.pack("<2Q", len(body), len(content))
        directory += hashlib.md5(content, usedforsecurity=False).digest() + bytes(4)
        body += content + bytes(-len(content) % 16)
    header = HEADER.pack(MAGIC, FORMAT, *ENGINE, RELATIVE_TO_FILES, HEADER.size, HEADER.size + len(body))
    return header + bytes(body) + directory
