"""Whether an image lies on the disk as it was written: the image library does not say when a write was refused."""

import struct
import zlib
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.errors import FaceZipError
from facezip.files.bands import BAND
from facezip.files.opening import opened

SIGNATURE = b"\x89PNG\r\n\x1a\n"


def has_arrived(path: Path, band: Callable[[int, int], NDArray[Any]]) -> bool:
    """Whether a file is whole: a PNG by its own checksums, any other by its texels.

    Parameters
    ----------
    path : the file.
    band : gives the rows from the first number to the second one, as they are stored.
    """
    if path.suffix.lower() == ".png":
        with open(path, "rb") as file:
            return file.read(8) == SIGNATURE and _is_whole(iter(lambda: file.read(8), b""), file.read)
    try:
        with opened(path) as image:
            return all(
                _are_rows(image, top, band(top, min(top + BAND, image.spec().height)))
                for top in range(0, image.spec().height, BAND)
            )
    except FaceZipError:
        return False


def _are_rows(image: Any, top: int, expected: NDArray[Any]) -> bool:
    """Whether rows from ``top`` on are stored as these: channels as they are, whatever their names say of them."""
    height, width, channels = expected.shape
    kind = str(expected.dtype).replace("float32", "float")
    read = image.read_scanlines(top, top + height, 0, 0, channels, kind)
    return read is not None and np.array_equal(
        np.reshape(read, (height, width, channels)), expected, equal_nan=expected.dtype.kind == "f"
    )


def _is_whole(heads: Iterable[bytes], read: Callable[[int], bytes]) -> bool:
    """Whether chunks, of which ``heads`` are the first 8 bytes, have the checksums that they state, to the last one."""
    kind, pixels = b"", False
    for head in heads:
        if len(head) < 8 or kind == b"IEND":
            return False
        length, kind = struct.unpack(">I4s", head)
        content, checksum = read(length), read(4)
        if len(content) < length or int.from_bytes(checksum, "big") != zlib.crc32(content, zlib.crc32(kind)):
            return False
        pixels = pixels or kind == b"IDAT"
    return pixels and kind == b"IEND"
