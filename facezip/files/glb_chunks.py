"""The chunks that a binary glTF is made of, behind its header."""

import struct

from facezip.files.accessors import GlbFault

MAGIC, VERSION = b"glTF", 2
# Of the file and of its first chunk.
HEADER = 20
JSON_CHUNK, BINARY_CHUNK = b"JSON", b"BIN\0"


def check_header(header: bytes, size: int) -> None:
    """Raise ``GlbFault`` where the first bytes are not those of a binary file of ``size`` bytes."""
    if size < HEADER or header[:4] != MAGIC:
        raise GlbFault("it does not begin with 'glTF'; export it as a binary .glb")
    version, length = struct.unpack_from("<II", header, 4)
    if version != VERSION or length != size:
        raise GlbFault(f"version {version}, {size} bytes where it states {length}; copy or export it again")


def header(size: int) -> bytes:
    """The beginning of a file whose chunks have so many bytes."""
    return MAGIC + struct.pack("<II", VERSION, 12 + size)


def chunks_of(content: bytes) -> list[tuple[bytes, bytes]]:
    """Kind and content of each chunk, the last first; ``GlbFault`` where the file ends within one."""
    found, start = [], 12
    while start < len(content):
        if start + 8 > len(content):
            raise GlbFault("it ends within a chunk; copy or export it again")
        length, kind = struct.unpack_from("<I4s", content, start)
        if start + 8 + length > len(content):
            raise GlbFault("it ends within a chunk; copy or export it again")
        found.append((kind, content[start + 8 : start + 8 + length]))
        start += 8 + length
    # The first of a kind counts.
    return found[::-1]


def chunk(kind: bytes, content: bytes, padding: bytes) -> list[bytes]:
    """The pieces of a chunk, filled up to four bytes."""
    past = padding * (-len(content) % 4)
    return [struct.pack("<I4s", len(content) + len(past), kind), content, past]
