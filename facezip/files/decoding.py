"""One image file, decoded only after what it claims about itself has been found possible."""

from collections.abc import Generator, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio
from numpy.typing import NDArray

from facezip.errors import ErrorCode, FaceZipError
from facezip.files.muting import muted_stderr
from facezip.files.reading import check_expansion, reading
from facezip.machine import memory

MAX_SIDE = 16384
# Rows that are decoded and encoded at a time: whole blocks of every compression of OpenEXR.
BAND = 256
# How each kind of file begins. A library that guesses would try its forty other readers on hostile bytes.
_MAGIC = {
    ".png": (b"\x89PNG\r\n\x1a\n",),
    ".exr": (b"v/1\x01",),
    ".tif": (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"),
    ".jpg": (b"\xff\xd8\xff",),
}
_MAGIC |= {".tiff": _MAGIC[".tif"], ".jpeg": _MAGIC[".jpg"]}
# For each band of an image its first row, the rows of the image, and its texels.
Bands = Generator[tuple[int, int, NDArray[Any]], None, None]

_TYPES = ("uint8", "uint16", "uint32", "float16", "float32", "float64")

oiio.attribute("try_all_readers", 0)


def decode(path: Path, expected: tuple[int, ...] | None = None, into: NDArray[Any] | None = None) -> NDArray[Any]:
    """Texels ``(H, W, C)`` as they are stored, alpha unassociated; where given, their shape must be ``expected``.

    Parameters
    ----------
    path, expected : which image.
    into : filled and returned where it has the image's shape and type; otherwise there is a new array.

    Raises
    ------
    FaceZipError
        ``MISSING_FILE``, ``CANNOT_READ``, ``UNREADABLE_IMAGE`` or ``TOO_LARGE``.
    """
    return filled(decoded_bands(path, expected), into)


def filled(bands: Bands, into: NDArray[Any] | None = None) -> NDArray[Any]:
    """The image that bands (:func:`decoded_bands`) make; ``into`` as in :func:`decode`."""
    out = into
    # Closed at once even where Ctrl-C ends it: an open image keeps the terminal from saying so.
    with closing(bands):
        for top, height, band in bands:
            if out is None or out.shape != (height, *band.shape[1:]) or out.dtype != band.dtype:
                out = memory.empty((height, *band.shape[1:]), band.dtype)
            out[top : top + len(band)] = band
            memory.ease()
    if out is None:
        raise ValueError("an image has at least one row")
    return out


def decoded_bands(path: Path, expected: tuple[int, ...] | None = None) -> Bands:
    """An image a band at a time: its first row, the rows of the image, and its texels; raises as :func:`decode`."""
    with opened(path) as image:
        spec = image.spec()
        if expected is not None and (spec.height, spec.width, spec.nchannels) != expected:
            raise unreadable(path, f"{spec.width}x{spec.height}, {spec.nchannels} channels; expected {expected}")
        rows = max(BAND // max(spec.tile_height, 1), 1) * max(spec.tile_height, 1)
        for top in range(0, spec.height, rows):
            band = _read(image, top, min(top + rows, spec.height))
            if band is None:
                raise unreadable(path, reason(image))
            if band.dtype.name not in _TYPES:
                raise unreadable(path, f"holds {band.dtype}")
            yield top, spec.height, np.asarray(band).reshape(-1, spec.width, spec.nchannels)


def _read(image: Any, top: int, bottom: int) -> Any:
    """Rows of an open image, None where that fails."""
    spec = image.spec()
    origin, left, channels = spec.y, spec.x, spec.nchannels
    rows = origin + top, origin + bottom
    if spec.tile_width == 0:
        return image.read_scanlines(*rows, 0, 0, channels, oiio.UNKNOWN)
    return image.read_tiles(left, left + spec.width, *rows, 0, 1, 0, channels, oiio.UNKNOWN)


def stated_size(path: Path) -> tuple[int, int, int]:
    """Rows, columns, and bytes of all texels, by the header alone; raises as :func:`decode`."""
    with opened(path) as image:
        spec = image.spec()
        return spec.height, spec.width, spec.image_bytes(True)


@contextmanager
def opened(path: Path) -> Iterator[Any]:
    """An ``OpenImageIO.ImageInput`` whose header is read and possible; raises as :func:`decode`."""
    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)
    with reading(path), muted_stderr:
        _check_kind(path)
        image = oiio.ImageInput.open(str(path), config)
        if image is None:
            raise unreadable(path, reason(oiio))
        try:
            _check_claims(path, image.spec())
            yield image
        finally:
            image.close()


def _check_kind(path: Path) -> None:
    if not path.is_file():
        raise FaceZipError(ErrorCode.MISSING_FILE, f"{path}: no such texture; add the file or remove its mesh")
    with open(path, "rb") as file:
        start = file.read(8)
    if not start.startswith(_MAGIC.get(path.suffix.lower(), ())):
        kinds = [suffix[1:] for suffix, magic in _MAGIC.items() if start.startswith(magic)]
        inside = f"holds {kinds[0]}" if kinds else "holds no PNG, TIFF, JPEG or OpenEXR"
        raise unreadable(path, f"{inside}; its name says {path.suffix.lower() or 'nothing'}")


def _check_claims(path: Path, spec: Any) -> None:
    sides = spec.width, spec.height, spec.tile_width, spec.tile_height
    if min(sides[:2]) < 1 or max(sides) > MAX_SIDE or not 1 <= spec.nchannels <= 4 or spec.depth > 1 or spec.deep:
        raise FaceZipError(
            ErrorCode.TOO_LARGE,
            f"{path}: {spec.width}x{spec.height}, {spec.nchannels} channels; 1 to {MAX_SIDE} texels a side and 1 to 4 "
            "channels are read, export it smaller",
        )
    tile = max(1, spec.tile_width) * max(1, spec.tile_height)
    decoded = max(spec.width * spec.height, tile) * spec.pixel_bytes(True)
    check_expansion(path, decoded, path.stat().st_size)


def unreadable(path: Path, why: str) -> FaceZipError:
    """The error for a file that is no image of ours."""
    return FaceZipError(ErrorCode.UNREADABLE_IMAGE, f"{path}: not a readable image ({why}); export it again")


def reason(source: Any) -> str:
    """The first line of what OpenImageIO, or one of its images, says; it may quote bytes of a hostile file."""
    try:
        text: str = source.geterror()
    except UnicodeDecodeError:
        return "its header is damaged"
    return (text.splitlines() or ["no reason given"])[0].strip()
