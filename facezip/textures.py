"""Reading and writing textures: PNG, TIFF, JPEG and OpenEXR, 8 and 16 bit and float.

Integer files hold encoded (sRGB) values and come through unchanged. Float files hold scene-linear values and are
encoded here, so that everything downstream sees one kind of number.
"""

import tempfile
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
from numpy.typing import NDArray

from facezip.decoding import decode, muted_stderr, reason, unreadable
from facezip.errors import ErrorCode, FaceZipError

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
    return np.multiply(texels, np.float32(1.0 / (255 if texels.dtype == np.uint8 else 65535)), dtype=np.float32)


def read_texture(path: Path) -> Texels:
    """Read a texture as ``(H, W, C)`` of encoded values, row 0 at the top; an alpha channel is dropped.

    Returns uint8 or uint16 as stored, or float32 in [0, 1] for float files, which are taken as linear and encoded.

    Raises
    ------
    FaceZipError
        ``MISSING_FILE``, ``CANNOT_READ``, ``UNREADABLE_IMAGE`` (truncated, damaged, another format), ``TOO_LARGE``, or
        ``BAD_TEXELS`` (NaN, infinite, or outside [0, 1]).
    """
    texels = decode(path)
    if texels.shape[2] in (2, 4):
        texels = texels[:, :, :-1]
    if texels.dtype.kind == "u":
        return np.ascontiguousarray(texels if texels.itemsize <= 2 else (texels >> 16).astype(np.uint16))
    with np.errstate(over="ignore"):
        return _encode_checked(texels.astype(np.float32), path)


def read_texture_exactly(path: Path, shape: tuple[int, ...] | None = None) -> Texels:
    """Read an integer image as it is stored, alpha included; where given, ``(H, W, C)`` must be ``shape``.

    Raises
    ------
    FaceZipError
        ``MISSING_FILE``, ``CANNOT_READ``, ``TOO_LARGE``, or ``UNREADABLE_IMAGE`` where it is damaged, of another size,
        or not of integers.
    """
    texels = decode(path, shape)
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
    if texels.dtype.kind == "f":
        is_exr = path.suffix.lower() == ".exr"
        texels = decode_srgb(texels) if is_exr else np.rint(np.clip(texels, 0, 1) * 255).astype(np.uint8)  # type: ignore[arg-type]
    _encode_file(path, texels, compression)


def read_values(path: Path) -> NDArray[np.float32]:
    """The first channel ``(H, W)`` of an image that holds no colour: floats as stored, integers over their maximum.

    Raises
    ------
    FaceZipError
        What :func:`read_texture_exactly` raises; ``BAD_TEXELS`` for values that are negative or not finite.
    """
    stored = decode(path)[:, :, 0]
    maximum = np.float32(1) if stored.dtype.kind == "f" else np.float32(np.iinfo(stored.dtype).max)
    values: NDArray[np.float32] = stored.astype(np.float32) / maximum
    if not np.isfinite(values).all() or values.min() < 0:
        raise FaceZipError(ErrorCode.BAD_TEXELS, f"{path}: negative or not finite values; paint or export them again")
    return values


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


def _encode_file(path: Path, texels: Texels, compression: int) -> None:
    height, width, channels = texels.shape
    spec = oiio.ImageSpec(width, height, channels, str(texels.dtype).replace("float32", "float"))
    spec.attribute("oiio:UnassociatedAlpha", 1)
    spec.attribute("png:compressionLevel", compression)
    output = oiio.ImageOutput.create(str(path))
    if output is None:
        raise FaceZipError(ErrorCode.CANNOT_WRITE, f"{path}: {reason(oiio)}; use .png, .tif or .exr")
    with muted_stderr:
        written = output.open(str(path), spec) and output.write_image(np.ascontiguousarray(texels))
        why = reason(output)
        written = output.close() and written
    if not written:
        raise FaceZipError(ErrorCode.CANNOT_WRITE, f"{path}: cannot write the image ({why}); check space and rights")


def _encode_checked(linear: NDArray[np.float32], path: Path) -> NDArray[np.float32]:
    finite = np.isfinite(linear)
    if not finite.all():
        row, column = np.argwhere(~finite.all(axis=2))[0]
        raise FaceZipError(
            ErrorCode.BAD_TEXELS,
            f"{path}: NaN or infinite value at column {column}, row {row}; repaint or export that texel again",
        )
    if linear.min() < 0 or linear.max() > 1:
        raise FaceZipError(
            ErrorCode.BAD_TEXELS,
            f"{path}: values from {linear.min():.3g} to {linear.max():.3g}; an albedo lies within 0 and 1, rescale it",
        )
    return encode_srgb(linear)
