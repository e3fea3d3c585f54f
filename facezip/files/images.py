"""Reading and writing textures: PNG, TIFF, JPEG and OpenEXR, 8 and 16 bit and float.

Integer files hold encoded (sRGB) values and come through unchanged. Float files hold scene-linear values and are
encoded here, so that everything downstream sees one kind of number.
"""

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio
from numpy.typing import NDArray

from facezip.errors import ErrorCode, FaceZipError
from facezip.files.decoding import BAND, Bands, decode, decoded_bands, filled, reason, unreadable
from facezip.files.muting import muted_stderr
from facezip.machine import memory
from facezip.machine.rows import by_rows

TEXTURE_SUFFIXES = (".png", ".exr", ".tif", ".tiff", ".jpg", ".jpeg")

Texels = NDArray[np.uint8] | NDArray[np.uint16] | NDArray[np.float32]


def encode_srgb(linear: NDArray[np.float32]) -> NDArray[np.float32]:
    """sRGB opto-electronic transfer function (IEC 61966-2-1) on linear values in [0, 1]."""
    high = 1.055 * np.power(np.maximum(linear, 0.0031308), 1 / 2.4) - 0.055
    return np.where(linear <= 0.0031308, linear * 12.92, high).astype(np.float32)


def decode_srgb(encoded: NDArray[np.float32]) -> NDArray[np.float32]:
    """Inverse of :func:`encode_srgb`: encoded values in [0, 1] to linear ones."""
    high = np.power((np.maximum(encoded, 0.04045) + 0.055) / 1.055, 2.4)
    return np.where(encoded <= 0.04045, encoded / 12.92, high).astype(np.float32)


def to_float(texels: Texels) -> NDArray[np.float32]:
    """Stored texels of any supported type as float32 in [0, 1], of the same shape."""
    if texels.dtype == np.float32:
        return texels  # type: ignore[return-value]
    unit = np.float32(1.0 / (255 if texels.dtype == np.uint8 else 65535))
    return by_rows(lambda rows: np.multiply(texels[rows], unit, dtype=np.float32), texels.shape, np.float32)


def read_texture(path: Path, into: Texels | None = None) -> Texels:
    """Read a texture as ``(H, W, C)`` of encoded values, row 0 at the top; an alpha channel is dropped.

    Returns uint8 or uint16 as stored, or float32 in [0, 1] for float files, which are taken as linear and encoded:
    in ``into`` where that has the texture's shape and type, otherwise in a new array.

    Raises
    ------
    FaceZipError
        ``MISSING_FILE``, ``CANNOT_READ``, ``UNREADABLE_IMAGE`` (truncated, damaged, another format), ``TOO_LARGE``, or
        ``BAD_TEXELS`` (NaN, infinite, or outside [0, 1]).
    """
    return filled(_encoded_bands(path), into)


def _encoded_bands(path: Path) -> Bands:
    low, high = np.float32(np.inf), np.float32(-np.inf)
    for top, height, band in decoded_bands(path):
        texels = band[:, :, :-1] if band.shape[2] in (2, 4) else band
        if texels.dtype.kind == "u":
            yield top, height, texels if texels.itemsize <= 2 else (texels >> 16).astype(np.uint16)
            continue
        with np.errstate(over="ignore"):
            linear = texels.astype(np.float32)
        _check_finite(linear, top, path)
        low, high = min(low, linear.min()), max(high, linear.max())
        yield top, height, encode_srgb(np.clip(linear, 0, 1))
    if low < 0 or high > 1:
        raise FaceZipError(
            ErrorCode.BAD_TEXELS,
            f"{path}: values from {low:.3g} to {high:.3g}; an albedo lies within 0 and 1, rescale it",
        )


def read_texture_exactly(path: Path, shape: tuple[int, ...] | None = None, into: Texels | None = None) -> Texels:
    """Read an integer image as it is stored, alpha included; where given, ``(H, W, C)`` must be ``shape``.

    ``into`` is as in :func:`read_texture`.

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


def read_values(path: Path) -> NDArray[np.float32]:
    """The first channel ``(H, W)`` of an image that holds no colour: floats as stored, integers over their maximum.

    Raises
    ------
    FaceZipError
        What :func:`read_texture_exactly` raises; ``BAD_TEXELS`` for values that are negative or not finite.
    """
    values: NDArray[np.float32] = filled(_value_bands(path))
    return values


def _value_bands(path: Path) -> Bands:
    for top, height, band in decoded_bands(path):
        stored = band[:, :, 0]
        maximum = np.float32(1) if stored.dtype.kind == "f" else np.float32(np.iinfo(stored.dtype).max)
        values: NDArray[np.float32] = stored.astype(np.float32) / maximum
        if not np.isfinite(values).all() or values.min() < 0:
            raise FaceZipError(
                ErrorCode.BAD_TEXELS, f"{path}: negative or not finite values; paint or export them again"
            )
        yield top, height, values


def png(texels: Texels) -> bytes:
    """The bytes of a PNG file of ``(H, W, C)`` texels, of 16 bits where they are floats in [0, 1]."""
    if texels.dtype.kind == "f":
        texels = np.rint(np.clip(texels, 0, 1) * 65535).astype(np.uint16)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "image.png"
        write_texture(file, texels)
        return file.read_bytes()


def write_values(path: Path, values: NDArray[np.float32]) -> None:
    """Write ``(H, W)`` floats that are no colour as a single-channel OpenEXR file, as they are.

    Raises
    ------
    FaceZipError
        ``CANNOT_WRITE``, naming the file and the reason.
    """
    _encode_file(path, values[:, :, None], 0)


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
    output = oiio.ImageOutput.create(str(path))
    if output is None:
        raise FaceZipError(ErrorCode.CANNOT_WRITE, f"{path}: {reason(oiio)}; use .png, .tif or .exr")
    with muted_stderr:
        written = output.open(str(path), spec)
        for top in range(0, height, BAND):
            band = texels[top : top + BAND]
            written = written and output.write_scanlines(top, top + len(band), 0, np.ascontiguousarray(convert(band)))
            memory.ease()
        why = reason(output)
        written = output.close() and written
    if not written:
        raise FaceZipError(ErrorCode.CANNOT_WRITE, f"{path}: cannot write the image ({why}); check space and rights")


def _check_finite(linear: NDArray[np.float32], top: int, path: Path) -> None:
    finite = np.isfinite(linear)
    if not finite.all():
        row, column = np.argwhere(~finite.all(axis=2))[0]
        raise FaceZipError(
            ErrorCode.BAD_TEXELS,
            f"{path}: NaN or infinite value at column {column}, row {top + row}; repaint or export that texel again",
        )
