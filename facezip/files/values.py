"""Images of one number a texel, such as masks: which of their channels holds it, and the numbers as they are stored."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.errors import ErrorCode, FaceZipError
from facezip.files.bands import filled
from facezip.files.decoding import decoding
from facezip.files.facts import Facts
from facezip.machine.rows import by_rows, map_rows

# Of the largest number: what a lossy compression may turn one grey, or three equal channels, into.
ALIKE = 2 / 255


def read_mask(path: Path) -> tuple[NDArray[np.float32], str]:
    """A mask ``(H, W)`` in [0, 1], and the name of its channel where that is none of several that are alike.

    Raises as :func:`read_values`, and ``BAD_TEXELS`` for more than 1.
    """
    mask, channel = _read(path)
    highest = max(map_rows(lambda top, bottom: float(mask[top:bottom].max()), len(mask)))
    if highest > 1:
        raise FaceZipError(
            ErrorCode.BAD_TEXELS, f"{path}: values up to {highest:.3g}; a mask lies within 0 and 1, rescale it"
        )
    return mask, channel


def read_values(path: Path) -> NDArray[np.float32]:
    """The numbers ``(H, W)`` of an image that holds no colours: floats as stored, integers over their maximum.

    They are in the channels that vary, if those are alike, or in an alpha that varies beside one visible colour. What
    the file says of a colour space does not matter to them.

    Raises
    ------
    FaceZipError
        What :func:`facezip.files.decoding.decode` raises; ``BAD_TEXELS`` for values that are negative or not finite,
        and where channels differ, so that one of them would have to be guessed.
    """
    return _read(path)[0]


def _read(path: Path) -> tuple[NDArray[np.float32], str]:
    with decoding(path) as (facts, bands):
        texels = filled(bands)
    if not all(map_rows(lambda top, bottom: _are_values(texels[top:bottom]), len(texels))):
        raise FaceZipError(ErrorCode.BAD_TEXELS, f"{path}: negative or not finite values; paint or export them again")
    whole = np.float32(1 if facts.is_float else np.iinfo(texels.dtype).max)
    channel, is_only = (0, False) if len(facts.channels) == 1 else _Channels(facts, texels, float(whole)).meant()
    values = by_rows(lambda rows: texels[rows, :, channel].astype(np.float32) / whole, texels.shape[:2], np.float32)
    return values, facts.channels[channel] if is_only else ""


def _are_values(texels: NDArray[Any]) -> bool:
    return bool(np.isfinite(texels).all() and texels.min() >= 0)


class _Channels:
    """The channels of an image, of which one is meant."""

    def __init__(self, facts: Facts, texels: NDArray[Any], whole: float) -> None:
        self._facts, self._texels, self._alike = facts, texels, ALIKE * whole
        self._alpha = facts.colour_channels

    def meant(self) -> tuple[int, bool]:
        """The number of the channel, and whether others are not like it; ``BAD_TEXELS`` where that is not certain."""
        colours = [*range(self._facts.colour_channels)]
        varying = [channel for channel in colours if self._spread(channel) > self._alike]
        if self._facts.alpha and self._spread(self._alpha) > self._alike:
            visible = [self._spread(channel, visible=True) for channel in varying]
            if max(visible, default=0) <= self._alike or self._are_equal(varying, self._alpha):
                return self._alpha, True
            raise self._unclear("its colours and its alpha")
        among = varying or colours
        if self._are_equal(among, among[0]):
            return among[0], among != colours
        raise self._unclear(f"its channels {', '.join(self._facts.channels[channel] for channel in among)}")

    def _spread(self, channel: int, visible: bool = False) -> float:
        """The largest number less the smallest one, of all texels or of those whose alpha is not 0."""

        def extent(top: int, bottom: int) -> tuple[float, float]:
            rows = self._texels[top:bottom]
            some = rows[..., channel][rows[..., self._alpha] > 0] if visible else rows[..., channel]
            return (float(some.min()), float(some.max())) if some.size else (np.inf, -np.inf)

        extents = map_rows(extent, len(self._texels))
        return max(high for _, high in extents) - min(low for low, _ in extents)

    def _are_equal(self, channels: list[int], other: int) -> bool:
        def apart(top: int, bottom: int) -> float:
            rows = self._texels[top:bottom].astype(np.float64)
            return float(np.abs(rows[..., channels] - rows[..., [other]]).max(initial=0))

        return max(map_rows(apart, len(self._texels))) <= self._alike

    def _unclear(self, what: str) -> FaceZipError:
        return FaceZipError(
            ErrorCode.BAD_TEXELS,
            f"{self._facts.path}: {what} differ, and which is meant is not certain; export it as one grey channel",
        )
