"""The small chunks of a PNG that say what its numbers mean, which no image library hands on whole."""

import struct
import zlib
from collections.abc import Mapping
from pathlib import Path

from facezip.files.colour_space import (
    SRGB,
    SRGB_PRIMARIES,
    ColourFault,
    ColourSpace,
    of_code_points,
    of_gamma,
    of_primaries,
)
from facezip.files.icc import MAX_BYTES, profile_space

WANTED = (b"cICP", b"iCCP", b"sRGB", b"gAMA", b"cHRM", b"eXIf")
# Of a chunk: profiles of tables are larger, and Exif with a preview is, of which the front counts.
MOST = 2**20
UNSPECIFIED = b"\2\2"


def chunks(path: Path) -> dict[bytes, bytes]:
    """The start of the first chunk of each kind that states something; of those on colour, only before the pixels."""
    found: dict[bytes, bytes] = {}
    pixels = False
    # Pixels lie in thousands of chunks, of which a buffer would read more than is asked for.
    with open(path, "rb", buffering=0) as file:
        file.seek(8)
        while len(head := file.read(8) or b"") == 8:
            length, kind = struct.unpack(">I4s", head)
            pixels = pixels or kind == b"IDAT"
            if kind in WANTED and kind not in found and (kind == b"eXIf" or not pixels):
                found[kind] = file.read(min(length, MOST)) or b""
                length -= len(found[kind])
            file.seek(length + 4, 1)
    return found


def png_space(found: Mapping[bytes, bytes], channels: int) -> ColourSpace | None:
    """The colour space that chunks state, in the order in which they outrank each other (third edition, 4.3).

    Parameters
    ----------
    found : the chunks.
    channels : of the image, without alpha.

    Raises
    ------
    ColourFault
        It cannot be converted to sRGB.
    """
    if b"cICP" in found and found[b"cICP"][:2] != UNSPECIFIED:
        primaries, transfer, matrix, is_full = (*found[b"cICP"], 0, 0, 0, 0)[:4]
        if matrix or not is_full:
            raise ColourFault("of a video's range, or luminance and chroma (cICP)")
        return of_code_points(primaries, transfer)
    if b"iCCP" in found:
        return profile_space(_unpacked(found[b"iCCP"]), channels)
    if b"sRGB" in found:
        return SRGB
    return _plain(found.get(b"gAMA", b""), found.get(b"cHRM", b""))


def _unpacked(chunk: bytes) -> bytes:
    """The profile of an iCCP chunk, with a limit: libpng keeps some to itself, of colours for an image of grey."""
    name, _, packed = chunk.partition(b"\0")
    try:
        return zlib.decompressobj().decompress(packed[1:], MAX_BYTES)
    except zlib.error:
        raise ColourFault(f"of the ICC profile '{name.decode('latin-1')}', which is damaged") from None


def _plain(gamma: bytes, chromaticities: bytes) -> ColourSpace | None:
    if not gamma and not chromaticities:
        return None
    if len(gamma) not in (0, 4) or len(chromaticities) not in (0, 32):
        raise ColourFault("of chunks gAMA and cHRM, which are damaged")
    # White comes first.
    points = [x / 100000 for x in struct.unpack(">8I", chromaticities)] if chromaticities else []
    primaries = [*points[2:], *points[:2]] or SRGB_PRIMARIES
    exponent = 100000 / max(int.from_bytes(gamma, "big"), 1) if gamma else 2.2
    return of_primaries("the primaries and gamma that its chunks cHRM and gAMA state", primaries, of_gamma(exponent))
