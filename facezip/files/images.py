"""Reading and writing textures: PNG, TIFF, JPEG, OpenEXR and more, 8 and 16 bit and float.

Integer files hold encoded (sRGB) values and come through unchanged. Float files hold scene-linear values and are
encoded here, so that everything downstream sees one kind of number. Files that state something else are converted
(:mod:`facezip.files.colours`).
"""

import errno
import os
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio
from numpy.typing import NDArray

from facezip.errors import ErrorCode, FaceZipError
from facezip.files.arrival import has_arrived
from facezip.files.bands import BAND, filled
from facezip.files.colours import colour_bands
from facezip.files.decoding import decode
from facezip.files.muting import muted_stderr
from facezip.files.opening import reason, unreadable
from facezip.files.srgb import decode_srgb
from facezip.machine import memory
from facezip.machine.rows import by_rows

# Bytes that a disk may have left although it has refused some.
FULL = 2**16
TIFF, EPOCH = (".tif", ".tiff"), "1970:01:01 00:00:00"
# Of PNG. Skin has no matches but runs; what seems to be one takes more bits than its texels. Files are 5 % smaller so,
# and written four times as fast. Of the filters, libpng's number of "up".
RUNS, UP = "rle", 32

Texels = NDArray[np.uint8] | NDArray[np.uint16] | NDArray[np.float32]


def to_float(texels: Texels) -> NDArray[np.float32]:
    """Stored texels of any supported type as float32 in [0, 1], of the same shape."""
    if texels.dtype == np.float32:
        return texels  # type: ignore[return-value]
    unit = np.float32(1.0 / (255 if texels.dtype == np.uint8 else 65535))
    return by_rows(lambda rows: np.multiply(texels[rows], unit, dtype=np.float32), texels.shape, np.float32)


def as_texels(values: NDArray[np.float32], dtype: np.dtype[Any]) -> Texels:
    """Inverse of :func:`to_float`: values in [0, 1] as texels of a type, rounded where those are whole numbers."""
    if dtype.kind == "f":
        return values
    most = np.float32(np.iinfo(str(dtype)).max)
    return by_rows(lambda rows: np.rint(values[rows] * most).astype(dtype), values.shape, dtype)


def read_texture(path: Path) -> Texels:
    """Read a texture as ``(H, W, C)`` of encoded sRGB values, row 0 at the top; an alpha channel is dropped.

    Returns uint8 or uint16 as stored, or float32 in [0, 1] of float files, which are linear unless they say otherwise.

    Raises
    ------
    FaceZipError
        ``MISSING_FILE``, ``CANNOT_READ``, ``UNREADABLE_IMAGE`` (truncated, damaged, another format, colours that cannot
        be converted), ``TOO_LARGE``, or ``BAD_TEXELS`` (NaN, infinite, outside [0, 1] or outside of sRGB).
    """
    return filled(colour_bands(path))


def read_texture_exactly(path: Path, shape: tuple[int, ...] | None = None, into: Texels | None = None) -> Texels:
    """Read an integer image as it is stored, alpha included; where given, ``(H, W, C)`` must be ``shape``.

    ``into`` is filled and returned where it has the image's shape and type.

    Raises
    ------
    FaceZipError
        ``MISSING_FILE``, ``CANNOT_READ``, ``TOO_LARGE``, or ``UNREADABLE_IMAGE`` where it is damaged, of another size,
        or not of integers.
    """
    texels = decode(path, shape, into)
    if texels.dtype.kind != "u":
        raise unreadable(path, f"holds {texels.dtype}, not integers")
    return texels


def write_texture(path: Path, texels: Texels, compression: int = 3) -> None:
    """Write ``(H, W, C)`` texels in the format that the suffix names.

    Integer texels are stored as they are. Float texels (encoded values in [0, 1]) are stored linear in OpenEXR and
    rounded to 8 bits elsewhere.

    Raises
    ------
    FaceZipError
        ``CANNOT_WRITE``, naming the file and the reason.
    """
    if texels.dtype.kind == "u":
        _encode_file(path, texels, compression)
    elif path.suffix.lower() == ".exr":
        _encode_file(path, texels, compression, np.dtype(np.float32), decode_srgb)
    else:
        _encode_file(path, texels, compression, np.dtype(np.uint8), _rounded)


def _rounded(values: NDArray[np.float32]) -> NDArray[np.uint8]:
    return np.rint(np.clip(values, 0, 1) * 255).astype(np.uint8)


def png(texels: Texels) -> bytes:
    """The bytes of a PNG file of ``(H, W, C)`` texels, of 16 bits where they are floats in [0, 1]."""
    if texels.dtype.kind == "f":
        texels = np.rint(np.clip(texels, 0, 1) * 65535).astype(np.uint16)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "image.png"
        write_texture(file, texels)
        return file.read_bytes()


def write_values(path: Path, values: NDArray[np.float32]) -> None:
    """Write ``(H, W)`` or ``(H, W, C)`` floats that are no colour as an OpenEXR file, as they are.

    Raises
    ------
    FaceZipError
        ``CANNOT_WRITE``, naming the file and the reason.
    """
    _encode_file(path, values.reshape(*values.shape[:2], -1), 0)


def _encode_file(
    path: Path,
    texels: Texels,
    compression: int,
    stored: np.dtype[Any] | None = None,
    convert: Callable[[Any], Texels] = np.ascontiguousarray,
) -> None:
    """Write texels a band at a time, each as ``convert`` makes it, of the type ``stored``."""
    height, width, channels = texels.shape
    spec = oiio.ImageSpec(width, height, channels, str(stored or texels.dtype).replace("float32", "float"))
    spec.attribute("oiio:UnassociatedAlpha", 1)
    spec.attribute("png:compressionLevel", compression)
    if path.suffix.lower() == ".png":
        spec.attribute("compression", RUNS)
        spec.attribute("png:filter", UP)
    if path.suffix.lower() in TIFF:
        # Otherwise that of writing, and the same texels would be other bytes.
        spec.attribute("DateTime", EPOCH)
    output = oiio.ImageOutput.create(str(path))
    if output is None:
        raise FaceZipError(ErrorCode.CANNOT_WRITE, f"{path}: {reason(oiio)}; use .png, .tif or .exr")

    def band(top: int, bottom: int) -> NDArray[Any]:
        return np.ascontiguousarray(convert(texels[top:bottom]))

    with muted_stderr:
        written = output.open(str(path), spec)
        for top in range(0, height, BAND):
            bottom = min(top + BAND, height)
            written = written and output.write_scanlines(top, bottom, 0, band(top, bottom))
            memory.ease()
        why = reason(output)
        written = output.close() and written
    if written and not has_arrived(path, band):
        full = shutil.disk_usage(path.parent).free < FULL
        written, why = False, os.strerror(errno.ENOSPC) if full else "the disk refused a part of it"
    if not written:
        raise FaceZipError(ErrorCode.CANNOT_WRITE, f"{path}: cannot write the image ({why}); check space and rights")
