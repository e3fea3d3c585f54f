"""Images a band of rows at a time: put together, put into a larger frame, and turned upright."""

from collections.abc import Generator
from contextlib import closing
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.files.facts import Window
from facezip.machine import memory

# Rows that are decoded and encoded at a time: whole blocks of every compression of OpenEXR.
BAND = 256
# For each band of an image its first row, the rows of the image, and its texels. Bands come in any order.
Bands = Generator[tuple[int, int, NDArray[Any]], None, None]


def filled(bands: Bands, into: NDArray[Any] | None = None) -> NDArray[Any]:
    """The image that bands make: in ``into`` where that has its shape and type, otherwise in a new array."""
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


def sliced(bands: Bands, rows: int) -> Bands:
    """The same image in bands of so few rows that several copies of one may be made."""
    with closing(bands):
        for first, height, band in bands:
            for top in range(0, len(band), rows):
                yield first + top, height, band[top : top + rows]


def placed(bands: Bands, window: Window, size: tuple[int, int]) -> Bands:
    """Bands at their place in a frame of rows and columns: 0 where there are none, cut off where they exceed it."""
    height, width = size
    left, right = max(window.left, 0), min(window.right, width)

    def frame(rows: int, like: NDArray[Any]) -> NDArray[Any]:
        return np.zeros((rows, width, like.shape[2]), like.dtype)

    covered = 0
    with closing(bands):
        for first, _, band in bands:
            top, bottom = window.top + first, window.top + first + len(band)
            for empty in range(covered, min(top, height), BAND):
                yield empty, height, frame(min(BAND, top - empty, height - empty), band)
            covered = max(covered, bottom)
            inside = band[max(-top, 0) : max(height - top, 0)]
            if len(inside):
                whole = frame(len(inside), band)
                whole[:, left:right] = inside[:, left - window.left : right - window.left]
                yield max(top, 0), height, whole
        for empty in range(covered, height, BAND):
            yield empty, height, frame(min(BAND, height - empty), band)


def upright(bands: Bands, orientation: int) -> Bands:
    """Bands of an image whose rows and columns lie as an orientation of Exif (1 to 8) says, the right way up."""
    if orientation > 4:
        # Columns become rows, and the last column may be the first row.
        stored = filled(bands).swapaxes(0, 1)
        bands = ((top, len(stored), stored[top : top + BAND]) for top in range(0, len(stored), BAND))
        orientation -= 4
    with closing(bands):
        for top, height, band in bands:
            rows = band[::-1] if orientation in (3, 4) else band
            yield (
                height - top - len(band) if orientation in (3, 4) else top,
                height,
                rows[:, ::-1] if orientation in (2, 3) else rows,
            )
