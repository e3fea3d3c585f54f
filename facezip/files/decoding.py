"""One image file a band of rows at a time: its texels, where and as the file states that they are meant.

Channels are those of the layer that counts, rows and columns lie as the orientation says and within the display window,
and colours that were multiplied by alpha are divided by it. Of which colour space they are is another question
(:mod:`facezip.files.colours`).
"""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio
from numpy.typing import NDArray

from facezip.files.bands import BAND, Bands, filled, placed, sliced, upright
from facezip.files.facts import Facts
from facezip.files.opening import opened, reason, unreadable
from facezip.files.statements import facts_of
from facezip.machine import telling
from facezip.machine.rows import BLOCK

# Of the largest number: what rounding, or a lossy compression, may leave a colour above its alpha.
ABOVE_ALPHA = 1 / 64
# Of half floats: what rounding may add to a quotient, and the alpha below which they have no digits left for colours.
ROUNDING, LEAST_ALPHA = 2**-9, 2**-14

_TYPES = {
    **{"uint8": oiio.UINT8, "uint16": oiio.UINT16, "uint32": oiio.UINT32},
    **{"float16": oiio.HALF, "float32": oiio.FLOAT, "float64": oiio.DOUBLE},
}


def decode(path: Path, expected: tuple[int, ...] | None = None, into: NDArray[Any] | None = None) -> NDArray[Any]:
    """Texels ``(H, W, C)`` of the stored type, alpha last and unassociated.

    Parameters
    ----------
    path : which image.
    expected : the shape that it must have; None for any.
    into : filled and returned where it has the image's shape and type; otherwise there is a new array.

    Raises
    ------
    FaceZipError
        ``MISSING_FILE``, ``CANNOT_READ``, ``UNREADABLE_IMAGE`` or ``TOO_LARGE``.
    """
    return filled(decoded_bands(path, expected), into)


def decoded_bands(path: Path, expected: tuple[int, ...] | None = None) -> Bands:
    """An image a band at a time: its first row, the rows of the image, and its texels; raises as :func:`decode`."""
    with decoding(path) as (facts, bands):
        shape = (*facts.size, len(facts.channels))
        if expected is not None and shape != expected:
            raise unreadable(path, f"{shape[1]}x{shape[0]}, {shape[2]} channels; expected {expected}")
        yield from bands


@contextmanager
def decoding(path: Path) -> Iterator[tuple[Facts, Bands]]:
    """What an image states, and its bands (:func:`decoded_bands`), while it is open; raises as :func:`decode`."""
    with opened(path) as image:
        facts = facts_of(path, image)
        bands = _stored(image, facts)
        if facts.alpha == "associated":
            bands = _divided(bands, facts)
        if facts.window is not None:
            bands = placed(bands, facts.window, facts.size[::-1] if facts.is_turned else facts.size)
        yield facts, upright(bands, facts.orientation)


def _stored(image: Any, facts: Facts) -> Bands:
    """Bands as rows and columns are stored."""
    spec = image.spec()
    rows = max(BAND // max(spec.tile_height, 1), 1) * max(spec.tile_height, 1)
    for top in range(0, spec.height, rows):
        band = _read(image, spec, facts, top, min(top + rows, spec.height))
        yield top, spec.height, np.iinfo(band.dtype).max - band if facts.white_is_zero else band


def _read(image: Any, spec: Any, facts: Facts, top: int, bottom: int) -> NDArray[Any]:
    channels = facts.layer.channels
    rows, among = (spec.y + top, spec.y + bottom), (min(channels), max(channels) + 1)
    kind = _TYPES[facts.type]
    telling.go_on()
    if spec.tile_width == 0:
        read = image.read_scanlines(*rows, 0, *among, kind)
    else:
        read = image.read_tiles(spec.x, spec.x + spec.width, *rows, 0, 1, *among, kind)
    if read is None:
        raise unreadable(facts.path, reason(image))
    texels = np.asarray(read).reshape(bottom - top, spec.width, -1)
    wanted = [channel - among[0] for channel in channels]
    return texels if wanted == [*range(texels.shape[2])] else texels[:, :, wanted]


def _divided(bands: Bands, facts: Facts) -> Bands:
    """Colours divided by alpha, halves as floats; where alpha is 0 they stay: no division tells what they were."""
    exact: type[np.floating[Any]] = (
        np.float32 if facts.type in ("uint8", "uint16", "float16", "float32") else np.float64
    )
    for top, height, band in sliced(bands, BLOCK):
        colours, alpha = band[:, :, :-1].astype(exact), band[:, :, -1:].astype(exact)
        whole = exact(1 if facts.is_float else np.iinfo(band.dtype).max)
        partly = (alpha > whole * LEAST_ALPHA) & (alpha < whole)
        if not facts.is_float and (partly & (colours > alpha + whole * ABOVE_ALPHA)).any():
            raise unreadable(facts.path, "it says that its colours are multiplied by alpha, and some exceed it")
        with np.errstate(all="ignore"):
            # What is not finite is found by those who ask for numbers.
            divided = colours / np.where(partly, alpha, whole)
        # Rounding alone takes no colour out of range.
        divided = np.where(partly & (divided < 1 + ROUNDING), np.minimum(divided, 1), divided)
        if not facts.is_float:
            divided = np.rint(np.minimum(divided, 1) * whole).astype(band.dtype)
        yield top, height, np.concatenate([divided, alpha.astype(divided.dtype)], axis=2)
