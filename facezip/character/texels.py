"""Reading one texture of a map, some rows at a time: from what the file stores to the numbers that are fitted."""

from itertools import takewhile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.character.layout import MapFiles
from facezip.character.maps import MAX_SLOPE
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.bands import Bands, sliced
from facezip.files.colours import check_range, colour_bands, finite, narrow
from facezip.files.decoding import decoded_bands, decoding
from facezip.files.facts import Facts
from facezip.machine.rows import BLOCK

# Shallower is 84° or more.
LEAST_Z = 1 / (1 + MAX_SLOPE**2) ** 0.5
# Normals of 8 bits lose nothing in 16 bits of slope, and take half the memory of floats.
_NARROW = np.uint16(65535)
# On average; filtering shortens vectors by a tenth at most, and colours are off by more.
OFF = 0.25


def value_rows(path: Path, how: MapFiles, alpha: "Extremes | None" = None) -> Bands:
    """The rows of a texture of colours or data: integers as stored, floats as values (colours encoded).

    The alpha of colours, which is not among them, is counted into ``alpha``.

    Raises
    ------
    FaceZipError
        What :func:`facezip.files.colours.colour_bands` raises, but for spaces of data; ``BAD_TEXELS`` for data whose
        channels differ.
    """
    if how.kind.encoding == "srgb":
        yield from colour_bands(path, how.keeps_floats, see_alpha=None if alpha is None else alpha.add)
    else:
        yield from _data_rows(path, how.keeps_floats)


def _data_rows(path: Path, keeps_floats: bool) -> Bands:
    colours, alpha = Extremes(), Extremes()
    low, high = np.inf, -np.inf
    with decoding(path) as (facts, bands):
        for top, height, band in sliced(bands, BLOCK):
            stored = _one_channel(path, facts.without_alpha(band))
            colours.add(stored)
            alpha.add(band[:, :, facts.colour_channels :])
            if not facts.is_float:
                yield top, height, narrow(stored)
                continue
            values = finite(path, top, stored)
            low, high = min(low, float(values.min())), max(high, float(values.max()))
            yield top, height, values
    if not keeps_floats and facts.is_float:
        check_range(path, low, high)
    if facts.alpha and colours.are_constant.all() and not alpha.are_constant.all():
        raise FaceZipError(
            ErrorCode.BAD_TEXELS,
            f"{path}: its alpha varies and its grey does not; export the one that is meant as one grey channel",
        )


def normal_rows(path: Path, how: MapFiles, signed: bool, seen: NDArray[np.bool_]) -> Bands:
    """The rows of a normal map as fitted slopes ``(H, W, 2)``: uint16 of 8-bit files, else float32.

    Where a file keeps x and y alone, z follows from the length of 1: two channels, or the ways of engines (x in alpha
    beside a constant red, or a constant blue). Those show at the end of the file alone: all its rows then come again.

    Parameters
    ----------
    path, how : which.
    signed : whether floats are components in [-1, 1]; otherwise (v + 1) / 2, as integers are.
    seen : ``(H, W)``, of the image's size: texels that matter. Others may hold what they like; where that is no normal,
        they become flat.

    Raises
    ------
    FaceZipError
        What :func:`facezip.files.decoding.decode` raises; ``BAD_TEXELS`` for what is no normal or steeper than 84°.
    """
    with decoding(path) as (facts, bands):
        if facts.colour_channels == 1:
            what = "grey and alpha" if facts.alpha else "one channel"
            raise FaceZipError(ErrorCode.BAD_TEXELS, f"{path}: {what}; a normal map has x, y and z, or x and y")
        first = _Normals(facts, how, signed, seen, (0, 1, 2)[: facts.colour_channels])
        yield from first.rows(bands)
    packed = first.packed_in
    if packed is None:
        first.check()
        return
    second = _Normals(facts, how, signed, seen, packed)
    yield from second.rows(decoded_bands(path))
    second.check()


class _Normals:
    """One reading of a normal map, by its x, y and z in some of its channels, or x and y."""

    def __init__(
        self, facts: Facts, how: MapFiles, signed: bool, seen: NDArray[np.bool_], channels: tuple[int, ...]
    ) -> None:
        self._facts, self._how, self._seen, self._channels = facts, how, seen, channels
        self._signed = signed and facts.is_float
        self._extremes = Extremes()
        self._wrong: tuple[int, int] | None = None
        self._off, self._count = 0.0, 0

    def rows(self, bands: Bands) -> Bands:
        for top, height, stored in sliced(bands, BLOCK):
            self._extremes.add(stored)
            vectors, lengths = self._vectors(top, stored[:, :, list(self._channels)])
            seen = self._seen[top : top + len(vectors)]
            self._off, self._count = self._off + float(np.abs(lengths[seen] - 1).sum()), self._count + int(seen.sum())
            if self._how.green_down:
                vectors[..., 1] *= -1
            steep = vectors[..., 2] < LEAST_Z
            if self._wrong is None and (wrong := np.argwhere(steep & seen)).size:
                self._wrong = int(wrong[0, 1]), top + int(wrong[0, 0])
            vectors[steep] = (0, 0, 1)
            fitted = self._how.kind.encode(vectors)
            is_narrow = stored.dtype.itemsize == 1
            yield top, height, np.rint(fitted * _NARROW).astype(np.uint16) if is_narrow else fitted

    @property
    def packed_in(self) -> tuple[int, ...] | None:
        """The channels of x and y, if what all texels are shows that it was not x, y and z; known at the end."""
        if self._facts.colour_channels != 3:
            return None
        at_end = self._extremes.are_at_an_end(self._facts)
        # No texel of skin looks along x alone: red stands for nothing, and what does not is in alpha.
        if self._facts.alpha and at_end[0] and not at_end[3]:
            return 3, 1
        return (0, 1) if at_end[2] else None

    def check(self) -> None:
        """Raise ``BAD_TEXELS`` for the first texel that was no normal, or where most are none."""
        if self._off > OFF * self._count:
            raise FaceZipError(
                ErrorCode.BAD_TEXELS,
                f"{self._facts.path}: its vectors are {self._off / self._count:.2f} off the length of 1 on average; "
                "give a tangent-space normal map",
            )
        if self._wrong is not None:
            column, row = self._wrong
            raise FaceZipError(
                ErrorCode.BAD_TEXELS,
                f"{self._facts.path}: no normal, or steeper than 84 degrees, at column {column}, row {row}; give a "
                "tangent-space normal map, or leave such texels out of the mask",
            )

    def _vectors(self, top: int, stored: NDArray[Any]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Unit vectors ``(H, W, 3)``, and their stored lengths ``(H, W)``."""
        is_float = self._facts.is_float
        values = finite(self._facts.path, top, stored) if is_float else stored / np.float32(np.iinfo(stored.dtype).max)
        if not self._signed:
            values = 2 * values - 1
        if values.shape[2] == 2:
            rest = np.maximum(1 - np.square(values).sum(axis=2, keepdims=True), 0)
            values = np.concatenate([values, np.sqrt(rest)], axis=2)
        length = np.sqrt(np.square(values).sum(axis=2, keepdims=True))
        return (values / np.maximum(length, 1e-6)).astype(np.float32), length[..., 0]


class Extremes:
    """The smallest and the largest number of every channel of an image."""

    def __init__(self) -> None:
        self._low: Any = np.inf
        self._high: Any = -np.inf

    def add(self, texels: NDArray[Any]) -> None:
        """Count the channels of some rows ``(H, W, C)`` in."""
        self._low = np.minimum(self._low, texels.min(axis=(0, 1)))
        self._high = np.maximum(self._high, texels.max(axis=(0, 1)))

    @property
    def are_constant(self) -> NDArray[np.bool_]:
        """Whether all texels are alike, by channel; of no texels they are."""
        return np.atleast_1d(self._low >= self._high)

    def are_at_an_end(self, facts: Facts) -> NDArray[np.bool_]:
        """Whether all of them are 0, or all are the largest number, by channel."""
        whole = 1 if facts.is_float else np.iinfo(facts.type).max
        return self.are_constant & ((self._low == 0) | (self._low == whole))


def states_signs(path: Path) -> bool:
    """Whether the floats of a normal map are components in [-1, 1]: then some of them are negative."""
    floats = takewhile(lambda rows: rows[2].dtype.kind == "f", sliced(decoded_bands(path), BLOCK))
    return any(bool(stored.min() < -0.01) for _, _, stored in floats)


def _one_channel(path: Path, stored: NDArray[Any]) -> NDArray[Any]:
    first = stored[:, :, :1]
    if stored.shape[2] > 1 and not (stored == first).all():
        raise FaceZipError(
            ErrorCode.BAD_TEXELS, f"{path}: its channels differ; a map of one number a texel is grey, export it so"
        )
    return first
