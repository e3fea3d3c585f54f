"""The rendered images as multi-part OpenEXR files: linear floats that any viewer or compositor opens."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from facezip.errors import ErrorCode, FaceZipError


def write_exr(path: Path, parts: Mapping[str, NDArray[np.float32]], conditions: Mapping[str, str]) -> None:
    """Write images ``(H, W, 3)`` or ``(H, W, 4)`` as half floats, one named part each, ZIP-compressed.

    Parameters
    ----------
    path : the file.
    parts : name → scene-linear image; names are stored as given.
    conditions : text attributes of every part: samples, seed, view and the like.
    """
    import OpenEXR

    files = []
    for name, image in parts.items():
        header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage, **conditions}
        channels = {"RGBA"[: image.shape[2]]: np.ascontiguousarray(image, np.float16)}
        files.append(OpenEXR.Part(header, channels, name))
    try:
        OpenEXR.File(files).write(str(path))
    except (OSError, RuntimeError) as error:
        reason = str(error).splitlines()[0]
        raise FaceZipError(ErrorCode.CANNOT_WRITE, f"{path}: cannot write ({reason}); check space and rights") from None


def read_exr(path: Path) -> dict[str, NDArray[np.float32]]:
    """Read the parts of :func:`write_exr`, in their order, as float32.

    Raises
    ------
    FaceZipError
        ``MISSING_FILE`` or ``UNREADABLE_IMAGE``.
    """
    import OpenEXR

    with _readable(path), OpenEXR.File(str(path)) as file:
        return {part.name(): next(iter(part.channels.values())).pixels.astype(np.float32) for part in file.parts}


def read_conditions(path: Path) -> dict[str, str]:
    """The text attributes that :func:`write_exr` stored with its first part; raises as :func:`read_exr` does."""
    import OpenEXR

    with _readable(path), OpenEXR.File(str(path), header_only=True) as file:
        return {key: value for key, value in file.parts[0].header.items() if isinstance(value, str) and key != "name"}


@contextmanager
def _readable(path: Path) -> Iterator[None]:
    if not path.is_file():
        raise FaceZipError(ErrorCode.MISSING_FILE, f"{path}: no such image; render it again")
    try:
        yield
    except (OSError, RuntimeError, ValueError) as error:
        reason = (str(error).splitlines() or ["no reason given"])[0]
        raise FaceZipError(ErrorCode.UNREADABLE_IMAGE, f"{path}: not a readable OpenEXR file ({reason})") from None
