"""The tags of a TIFF that say what its numbers mean, by number; and of Exif, which is a TIFF without pixels."""

import struct
from collections.abc import Iterator, Mapping
from io import BytesIO
from pathlib import Path
from typing import BinaryIO

ORIENTATION, TRANSFER_FUNCTION, WHITE_POINT, PRIMARIES = 274, 301, 318, 319
# What struct calls the types, and how many of its numbers one value is.
_TYPES = {3: "H", 4: "I", 5: "II"}
# The most values of a tag that are read (of a table it matters that it is there), and the most tags.
MOST, MOST_TAGS = 8, 4096

Tags = Mapping[int, tuple[float, ...]]


def file_tags(path: Path) -> Tags:
    """Those tags of the first directory of a file; raises ``ValueError`` where it is damaged."""
    with open(path, "rb") as file:
        return _tags(file)


def exif_tags(content: bytes) -> Tags:
    """Those tags of Exif, with or without what stands before it in JPEG; raises as :func:`file_tags`."""
    return _tags(BytesIO(content.removeprefix(b"Exif\0\0")))


def _tags(file: BinaryIO) -> Tags:
    try:
        return dict(_first_directory(file))
    except (struct.error, OverflowError, OSError):
        raise ValueError("its tags are damaged") from None


def _first_directory(file: BinaryIO) -> Iterator[tuple[int, tuple[float, ...]]]:
    start = file.read(4)
    order, big = "<" if start[:2] == b"II" else ">", start[2:4] in (b"+\0", b"\0+")
    # BigTIFF counts in 8 bytes where others have 2 or 4, after 4 bytes more.
    count_type, place_type, room = ("Q", "Q", 8) if big else ("H", "I", 4)

    def read(kinds: str) -> tuple[int, ...]:
        return struct.unpack(order + kinds, file.read(struct.calcsize(order + kinds)))

    if big:
        read("I")
    file.seek(read(place_type)[0])
    (count,) = read(count_type)
    entry, count = 4 + 2 * room, min(count, MOST_TAGS)
    for place in range(file.tell(), file.tell() + count * entry, entry):
        file.seek(place)
        tag, kind, many = read("HH" + place_type)
        if tag not in (ORIENTATION, TRANSFER_FUNCTION, WHITE_POINT, PRIMARIES):
            continue
        kinds = _TYPES.get(kind, "") * min(many, MOST)
        if struct.calcsize(order + kinds) > room:
            file.seek(read(place_type)[0])
        values: tuple[float, ...] = read(kinds)
        if kind == 5:
            values = tuple(a / b if b else 0.0 for a, b in zip(values[::2], values[1::2], strict=True))
        yield tag, values
