"""How a pack is changed and signed anew, as whoever writes one by hand could."""

import json
import struct
import zlib
from collections.abc import Sequence
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from facezip.files.packs import MANIFEST
from tests.trust.claims import sign

SIGNATURE = b"\x89PNG\r\n\x1a\n"


def manifest_of(pack: Path) -> dict[str, Any]:
    return json.loads((pack / MANIFEST).read_bytes())


def signed(pack: Path, blank: bytes) -> None:
    """Write a manifest whose first 64 zeros are where its checksum belongs."""
    (pack / MANIFEST).write_bytes(blank.replace(b"0" * 64, sha256(blank).hexdigest().encode(), 1))


def with_content(pack: Path, name: str, content: bytes) -> None:
    """Replace a file, and have the manifest state what it is now."""
    (pack / name).write_bytes(content)
    files = manifest_of(pack)["files"] | {name: {"bytes": len(content), "sha256": sha256(content).hexdigest()}}
    sign(pack, {"files": dict(sorted(files.items()))})


def chunk(kind: bytes, body: bytes) -> bytes:
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def png(samples: np.ndarray, filters: Sequence[int] = (0,), rows: int | None = None) -> bytes:
    """Samples ``(H, W, C)`` of 8 or 16 bits; each row has the next of the filters, of which 5 is none that there is.
    ``rows`` are how many are there of those stated.

    Readers must take it as it is: pixels in two chunks, after one that asks for another gamma.
    """
    height, width, channels = samples.shape
    step = channels * samples.itemsize
    lines = np.frombuffer(samples.astype(samples.dtype.newbyteorder(">")).tobytes(), np.uint8).reshape(height, -1)
    colour = {1: 0, 2: 4, 3: 2, 4: 6}[channels]
    header = struct.pack(">IIBBBBB", width, height, 8 * samples.itemsize, colour, 0, 0, 0)
    above, packed = np.zeros_like(lines[0]), b""
    for row, line in enumerate(lines[:rows]):
        kind = filters[row % len(filters)]
        packed += bytes([kind]) + _filtered(kind, line.astype(int), above.astype(int), step).astype(np.uint8).tobytes()
        above = line
    data = zlib.compress(packed)
    gamma = (b"gAMA", struct.pack(">I", 100000))
    chunks = [(b"IHDR", header), gamma, (b"IDAT", data[:9]), (b"IDAT", data[9:]), (b"IEND", b"")]
    return SIGNATURE + b"".join(chunk(*each) for each in chunks)


def _filtered(kind: int, line: np.ndarray, above: np.ndarray, step: int) -> np.ndarray:
    left, corner = (np.r_[np.zeros(step, int), row[:-step]] for row in (line, above))
    guess = left + above - corner
    distances = np.abs(guess - np.stack([left, above, corner]))
    paeth = np.choose(np.argmin(distances, axis=0), [left, above, corner])
    return (line - [0 * line, left, above, (left + above) // 2, paeth][kind % 5]) & 255
