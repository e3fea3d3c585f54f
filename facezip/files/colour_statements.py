"""Where each kind of image file says of which colour space its numbers are."""

import struct
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from facezip.files.colour_space import (
    NEAR,
    SRGB,
    SRGB_PRIMARIES,
    ColourFault,
    ColourSpace,
    of_gamma,
    of_interop_id,
    of_primaries,
    of_rgb_space,
    power,
)
from facezip.files.icc import MAX_BYTES, profile_space
from facezip.files.png_statements import png_space
from facezip.files.tiff_tags import PRIMARIES, TRANSFER_FUNCTION, WHITE_POINT, file_tags

# Exif's colour spaces that are not sRGB, and what a camera that means Adobe RGB adds (DCF 2.0).
_NOT_SRGB, _INTEROPERABILITY, _ADOBE_RGB, _ADOBE_GAMMA = (2, 65535), 0xA005, "R03", 563 / 256
# Kinds of colour spaces of bitmaps, as their bytes stand in the file.
_CALIBRATED, _EMBEDDED, _LINKED = bytes(4), b"DEBM", b"KNIL"


def stated_space(path: Path, spec: Any, channels: int, found: Mapping[bytes, bytes]) -> ColourSpace | None:
    """The colour space that an image states; None where it states none.

    Parameters
    ----------
    path : the file.
    spec : what OpenImageIO says of it.
    channels : how many of its channels are colours.
    found : the chunks of a PNG.

    Raises
    ------
    ColourFault
        It cannot be converted to sRGB; the words name it.
    """
    suffix, profile = path.suffix.lower(), _profile(spec)
    if suffix == ".png":
        return png_space(found, channels)
    if suffix == ".exr":
        return _of_exr(spec, profile, channels)
    if suffix == ".bmp":
        return _of_bmp(path, channels)
    if suffix == ".tga":
        return _of_tga(spec)
    if profile:
        return profile_space(profile, channels)
    return (_of_tiff(path, spec) if suffix in (".tif", ".tiff") else None) or _of_exif(path, spec)


def _profile(spec: Any) -> bytes:
    found = spec.getattribute("ICCProfile")
    return b"" if found is None else np.asarray(found, np.uint8).tobytes()


def _of_exr(spec: Any, profile: bytes, channels: int) -> ColourSpace | None:
    identifier = str(spec.getattribute("colorInteropID") or "unknown")
    if identifier != "unknown":
        return of_interop_id(identifier)
    if profile and not profile_space(profile, channels).has_srgb_primaries:
        raise ColourFault("of an ICC profile, which OpenEXR does not have")
    points = spec.getattribute("chromaticities")
    if points is not None:
        return of_primaries("the chromaticities of its header", points, None)
    return of_rgb_space("ACES2065-1", None) if spec.getattribute("acesImageContainerFlag") else None


def _of_tiff(path: Path, spec: Any) -> ColourSpace | None:
    tags = file_tags(path)
    if TRANSFER_FUNCTION in tags:
        raise ColourFault("of a transfer function of its own (TIFF's tag 301)")
    white, primaries = (tags.get(tag) for tag in (WHITE_POINT, PRIMARIES))
    if primaries is None and (white is None or np.abs(np.subtract(white, SRGB_PRIMARIES[3])).max() <= NEAR):
        return None
    if primaries is None:
        raise ColourFault("of another white or other primaries (TIFF's tags 318 and 319), which are not whole")
    transfer = None if str(spec.format) in ("half", "float", "double") else of_gamma(2.2)
    points = [*primaries, *(white or SRGB_PRIMARIES[3])]
    return of_primaries("the white and primaries of TIFF's tags 318 and 319", points, transfer)


def _of_exif(path: Path, spec: Any) -> ColourSpace | None:
    """Of a camera without profiles; that it is not calibrated, and nothing else, states nothing."""
    if spec.getattribute("Exif:ColorSpace") not in _NOT_SRGB:
        return None
    # It takes a while to be imported, and few files need it.
    from PIL import Image

    mark = None
    # What of it is damaged states nothing, and Pillow has an exception for each kind of damage.
    with suppress(Exception), Image.open(path) as image:
        mark = image.getexif().get_ifd(_INTEROPERABILITY).get(1)
    return of_rgb_space("Adobe RGB (1998)", power(_ADOBE_GAMMA)) if mark == _ADOBE_RGB else None


def _of_tga(spec: Any) -> ColourSpace | None:
    stated = str(spec.getattribute("oiio:ColorSpace") or "")
    gamma = float(spec.getattribute("oiio:Gamma") or 1)
    if stated and abs(gamma - 2.2) > 0.05:
        # Its specification calls 1 uncorrected, and programs write it of pictures for the screen.
        raise ColourFault(f"of a gamma of {gamma:.3g}, which programs mean in several ways")
    return None


def _of_bmp(path: Path, channels: int) -> ColourSpace | None:
    with open(path, "rb") as file:
        header = file.read(138)
        (size,) = struct.unpack_from("<I", header, 14)
        kind = header[70:74] if size >= 108 else b""
        if kind == _EMBEDDED:
            start, length = struct.unpack_from("<II", header.ljust(138, b"\0"), 126)
            file.seek(14 + start)
            return profile_space(file.read(min(length, MAX_BYTES)), channels)
    if kind == _LINKED:
        raise ColourFault("of an ICC profile in another file")
    if kind == _CALIBRATED and any(header[74:122]):
        return _calibrated(header)
    return None


def _calibrated(header: bytes) -> ColourSpace:
    ends = np.reshape(struct.unpack_from("<9I", header, 74), (3, 3)).astype(float)
    gammas = np.array(struct.unpack_from("<3I", header, 110)) / 65536
    points = ends[:, :2] / np.maximum(ends.sum(axis=1, keepdims=True), 1)
    if np.abs(points - SRGB_PRIMARIES[:3]).max() > NEAR or np.abs(gammas - 2.2).max() > 0.05:
        # Neither does it state white, nor do programs agree which way its gamma goes.
        raise ColourFault("calibrated by numbers in the bitmap's header")
    return SRGB
