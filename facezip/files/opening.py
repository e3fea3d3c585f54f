"""Opening an image file: nothing is decoded before what it claims about itself has been found possible."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import OpenImageIO as oiio

from facezip.errors import ErrorCode, FaceZipError
from facezip.files.muting import muted_stderr
from facezip.files.reading import check_expansion, digest, reading
from facezip.machine import telling

MAX_SIDE = 16384
# Layers of a render beside the texture; four channels at most are read.
MAX_CHANNELS = 256
MAX_PARTS = 64
# How each kind of file begins. A library that guesses would try its forty other readers on hostile bytes.
_MAGIC = {
    ".png": (b"\x89PNG\r\n\x1a\n",),
    ".exr": (b"v/1\x01",),
    ".tif": (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"),
    ".jpg": (b"\xff\xd8\xff",),
    ".webp": (b"RIFF",),
    ".bmp": (b"BM",),
    # Nothing: what is none of the others is left to the image library, which reads no other kind under this name.
    ".tga": (b"",),
}
_MAGIC |= {".tiff": _MAGIC[".tif"], ".jpeg": _MAGIC[".jpg"]}
TEXTURE_SUFFIXES = tuple(_MAGIC)
READ = "PNG, TIFF, JPEG, OpenEXR, WebP, TGA and BMP"
# Images all the same, whose files would be missed beside the others.
OTHER_SUFFIXES = (
    *(".psd", ".psb", ".xcf", ".kra", ".svg", ".gif", ".ico", ".heic", ".heif", ".avif", ".jxl", ".jp2", ".j2k"),
    *(".tx", ".dds", ".ktx", ".ktx2", ".hdr", ".dpx", ".cin", ".sgi", ".rgb", ".rgba", ".pcx", ".iff"),
    *(".ppm", ".pgm", ".pnm", ".pfm"),
)

oiio.attribute("try_all_readers", 0)

# The sha256 of images that are not opened → why.
_refused: Mapping[str, str] = {}


def refuse(digests: Mapping[str, str]) -> None:
    """Open no image any more whose bytes have one of these sha256, whatever it is called: → why."""
    global _refused
    _refused = digests


@contextmanager
def opened(path: Path) -> Iterator[Any]:
    """An ``OpenImageIO.ImageInput`` whose header is read and possible.

    Raises
    ------
    FaceZipError
        ``MISSING_FILE``, ``CANNOT_READ``, ``UNREADABLE_IMAGE`` or ``TOO_LARGE``.
    """
    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)
    with reading(path), muted_stderr, telling.at(path):
        _check_kind(path)
        if _refused and (why := _refused.get(digest(path))):
            raise unreadable(path, why)
        image = oiio.ImageInput.open(str(path), config)
        if image is None:
            raise unreadable(path, reason(oiio))
        try:
            check_claims(path, image.spec())
            yield image
        finally:
            image.close()


def _check_kind(path: Path) -> None:
    if not path.is_file():
        raise FaceZipError(ErrorCode.MISSING_FILE, f"{path}: no such image; add it, or name another")
    with open(path, "rb") as file:
        start = file.read(8)
    suffix = path.suffix.lower()
    if suffix not in _MAGIC:
        raise not_read(path)
    kinds = [kind[1:] for kind, magic in _MAGIC.items() if magic[0] and start.startswith(magic)]
    if not start.startswith(_MAGIC[suffix]) or (suffix == ".tga" and kinds):
        inside = f"holds {kinds[0]}" if kinds else f"holds none of {READ}"
        raise unreadable(path, f"{inside}; its name says {suffix}")


def check_claims(path: Path, spec: Any) -> None:
    """Refuse what is no texture, or would unfold out of proportion: ``TOO_LARGE`` or ``UNREADABLE_IMAGE``."""
    sides = spec.width, spec.height, spec.full_width, spec.full_height, spec.tile_width, spec.tile_height
    if spec.deep or spec.depth > 1:
        raise unreadable(path, f"holds {'deep pixels' if spec.deep else 'a volume'}")
    if min(sides[:4]) < 1 or max(sides) > MAX_SIDE or not 1 <= spec.nchannels <= MAX_CHANNELS:
        raise FaceZipError(
            ErrorCode.TOO_LARGE,
            f"{path}: {spec.width}x{spec.height}, {spec.nchannels} channels; 1 to {MAX_SIDE} texels a side and 1 to "
            f"{MAX_CHANNELS} channels are read, export it smaller",
        )
    tile = max(1, spec.tile_width) * max(1, spec.tile_height)
    largest = max(spec.width * spec.height, spec.full_width * spec.full_height, tile)
    check_expansion(path, largest * spec.pixel_bytes(True), path.stat().st_size)


def not_read(path: Path) -> FaceZipError:
    """The error for an image of a kind that is not read."""
    kind = path.suffix.lower() or "a file without a suffix"
    return FaceZipError(ErrorCode.UNREADABLE_IMAGE, f"{path}: {kind} is not read, {READ} are; save it as one of these")


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
