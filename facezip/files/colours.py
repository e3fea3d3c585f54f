"""Colours of an image file as encoded sRGB values, of whatever colour space it states that its numbers are."""

from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.errors import ErrorCode, FaceZipError
from facezip.files.bands import Bands, sliced
from facezip.files.colour_space import SRGB, ColourSpace
from facezip.files.decoding import decoding
from facezip.files.facts import Facts
from facezip.files.srgb import encode_srgb
from facezip.machine.rows import BLOCK

# Larger is damage, whatever a map holds.
LARGEST = 1e6
# Encoded: by how much a colour lies outside of sRGB before it counts, and which share of such texels is too large.
OUTSIDE, SHARE = 4 / 255, 0.01


def colour_bands(
    path: Path,
    keeps_range: bool = False,
    ignores_space: bool = False,
    see_alpha: Callable[[NDArray[Any]], None] | None = None,
) -> Bands:
    """The bands of an image of colours, converted to sRGB and encoded, without alpha.

    Integers stay of their type (32 bits become 16), and unchanged where they are of sRGB; floats become float32.

    Parameters
    ----------
    path : the file.
    keeps_range : whether floats outside of [0, 1] are kept, instead of refused.
    ignores_space : whether its numbers are sRGB whatever it states, as those of images in glTF are.
    see_alpha : called with the alpha ``(h, W, 1)`` of every band, where there is one.

    Raises
    ------
    FaceZipError
        What :func:`facezip.files.decoding.decode` raises; ``UNREADABLE_IMAGE`` for colours that cannot be converted;
        ``BAD_TEXELS`` for NaN, infinite or huge values, values outside of [0, 1], or many colours outside of sRGB.
    """
    with decoding(path) as (facts, bands):
        if see_alpha is not None and facts.alpha:
            bands = _watched(bands, see_alpha)
        space = SRGB if ignores_space else facts.colour_space
        if facts.colour_channels == 2:
            raise FaceZipError(ErrorCode.BAD_TEXELS, f"{path}: two channels; colours are grey or red, green and blue")
        if facts.is_float or not space.is_srgb:
            yield from _Conversion(facts, space, keeps_range).of(bands)
            return
        for top, height, band in bands:
            yield top, height, narrow(facts.without_alpha(band))


def _watched(bands: Bands, see_alpha: Callable[[NDArray[Any]], None]) -> Bands:
    with closing(bands):
        for top, height, band in bands:
            see_alpha(band[:, :, -1:])
            yield top, height, band


class _Conversion:
    """The colours of one file on their way to sRGB, and how many of them lie outside of it."""

    def __init__(self, facts: Facts, space: ColourSpace, keeps_range: bool) -> None:
        self._facts, self._space = facts, space
        # Curves say nothing of what is beyond them.
        self._keeps_range = keeps_range and facts.is_float and space.transfer is None
        self._outside, self._low, self._high = 0, np.inf, -np.inf
        self._light: NDArray[np.float32] | None = None

    def of(self, bands: Bands) -> Bands:
        for top, height, band in sliced(bands, BLOCK):
            stored = narrow(self._facts.without_alpha(band))
            yield top, height, self._of_floats(top, stored) if self._facts.is_float else self._of_integers(stored)
        self._check_range()

    def _of_floats(self, top: int, stored: NDArray[Any]) -> NDArray[np.float32]:
        values = finite(self._facts.path, top, stored)
        self._low, self._high = min(self._low, float(values.min())), max(self._high, float(values.max()))
        if self._space.is_srgb:
            return values
        # Of values that are refused at the end, curves may be beyond all numbers.
        with np.errstate(all="ignore"):
            light = self._space.light(values)
            return encode_srgb(light) if self._keeps_range else self._encoded(light)

    def _of_integers(self, stored: NDArray[Any]) -> NDArray[Any]:
        whole = np.iinfo(stored.dtype).max
        if self._light is None:
            ramp = np.arange(whole + 1, dtype=np.float32)[:, None] / np.float32(whole)
            curve = self._space.transfer
            ramp = np.repeat(ramp, stored.shape[2], axis=1)
            self._light = ramp if curve is None else curve(ramp)
        light = np.stack([self._light[stored[..., c], c] for c in range(stored.shape[2])], axis=-1)
        encoded = self._encoded(self._space.mixed(light))
        return np.rint(encoded * whole).astype(stored.dtype)

    def _encoded(self, light: NDArray[np.float32]) -> NDArray[np.float32]:
        encoded = encode_srgb(light)
        inside = np.clip(encoded, 0, 1)
        if not self._space.has_srgb_primaries:
            self._outside += int((np.abs(encoded - inside) > OUTSIDE).any(axis=2).sum())
        return inside

    def _check_range(self) -> None:
        path, (height, width) = self._facts.path, self._facts.size
        if not self._keeps_range and self._facts.is_float:
            check_range(path, self._low, self._high)
        share = self._outside / (height * width)
        if share > SHARE:
            raise FaceZipError(
                ErrorCode.BAD_TEXELS,
                f"{path}: {share:.0%} of its colours, of {self._space.name}, are outside of sRGB; convert it to sRGB "
                "in an image editor, where you see what becomes of them",
            )


def check_range(path: Path, low: float, high: float) -> None:
    """Raise ``BAD_TEXELS`` where the smallest or the largest value of an image lies outside of [0, 1]."""
    if low < 0 or high > 1:
        raise FaceZipError(
            ErrorCode.BAD_TEXELS,
            f"{path}: values from {low:.3g} to {high:.3g}; rescale them to 0..1, or keep them with --float",
        )


def narrow(stored: NDArray[Any]) -> NDArray[Any]:
    """Integers of 32 bits as their upper 16; all else as it is."""
    return (stored >> 16).astype(np.uint16) if stored.dtype == np.uint32 else stored


def finite(path: Path, top: int, stored: NDArray[Any]) -> NDArray[np.float32]:
    """Floats ``(H, W, C)`` from row ``top`` on, as float32; raises ``BAD_TEXELS`` where they are damaged."""
    with np.errstate(over="ignore"):
        values: NDArray[np.float32] = stored.astype(np.float32)
    wrong = ~(np.abs(values) <= LARGEST)
    if wrong.any():
        row, column = np.argwhere(wrong.any(axis=2))[0]
        raise FaceZipError(
            ErrorCode.BAD_TEXELS,
            f"{path}: NaN, infinite or huge value at column {column}, row {top + row}; repaint or export that texel "
            "again",
        )
    return values
