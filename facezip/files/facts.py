"""What an image file states about its numbers, and what therefore is done to them before anyone sees them."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.errors import ErrorCode, FaceZipError
from facezip.files.colour_space import LINEAR, SRGB, ColourFault, ColourSpace
from facezip.files.layers import Layer
from facezip.files.opening import unreadable


@dataclass(frozen=True)
class Window:
    """Where stored texels lie in the texture: rows ``top:bottom``, columns ``left:right``; they may reach beyond it."""

    top: int
    left: int
    bottom: int
    right: int


@dataclass(frozen=True, eq=False)
class Facts:
    """An image as its header states it.

    Attributes
    ----------
    path : the file.
    size : rows and columns of the texture that is read: of the display window, the right way up.
    type : ``uint8``, ``uint16``, ``uint32``, ``float16``, ``float32`` or ``float64``.
    channels : the names of those that are read, alpha last.
    alpha : "" where there is none; "associated" where colours are multiplied by it, "unassociated", or "unspecified".
    orientation : 1 to 8, as Exif and TIFF number them: how stored rows and columns lie.
    window : where stored texels lie before they are turned; None where they are the whole texture.
    layer : which part and channels are read.
    white_is_zero : whether numbers count downwards, and OpenImageIO leaves them so.
    left_out : parts and channels that are not read.
    """

    path: Path
    size: tuple[int, int]
    type: str
    channels: tuple[str, ...]
    alpha: str
    orientation: int
    window: Window | None
    layer: Layer
    white_is_zero: bool
    left_out: tuple[str, ...]
    stated_space: Callable[[], ColourSpace | None]

    @property
    def is_float(self) -> bool:
        """Whether texels are floats."""
        return self.type.startswith("float")

    @property
    def is_turned(self) -> bool:
        """Whether rows are stored as columns."""
        return self.orientation > 4

    @property
    def colour_channels(self) -> int:
        """How many channels are no alpha."""
        return len(self.channels) - bool(self.alpha)

    @property
    def texel_bytes(self) -> int:
        """Bytes of a texel."""
        return len(self.channels) * np.dtype(self.type).itemsize

    def without_alpha(self, texels: NDArray[Any]) -> NDArray[Any]:
        """Texels ``(H, W, C)`` without their alpha."""
        return texels[:, :, : self.colour_channels]

    @property
    def colour_space(self) -> ColourSpace:
        """What colours are stated to be; where nothing is, sRGB of integers and linear light of floats.

        Raises
        ------
        FaceZipError
            ``UNREADABLE_IMAGE``, naming the space: it cannot be converted to sRGB.
        """
        try:
            return self.stated_space() or (LINEAR if self.is_float else SRGB)
        except ColourFault as fault:
            raise FaceZipError(
                ErrorCode.UNREADABLE_IMAGE, f"{self.path}: its colours are {fault}; save it as sRGB in an image editor"
            ) from None
        except ValueError as fault:
            raise unreadable(self.path, str(fault)) from None

    def applied(self, as_colours: bool) -> tuple[str, ...]:
        """What is done to the numbers because the file says so, in a few words each; nothing for an ordinary file.

        Parameters
        ----------
        as_colours : whether it is read as colours; numbers and normals are of no colour space.

        Raises
        ------
        FaceZipError
            As :attr:`colour_space`.
        """
        done = {
            f"channels {', '.join(self.channels)} are read, {', '.join(self.left_out)} are not": self.left_out,
            "white is zero: numbers are turned around": self.white_is_zero,
            "colours are divided by alpha": self.alpha == "associated",
            f"placed in its display window of {self.size[1]}x{self.size[0]}": self.window,
            f"turned upright (orientation {self.orientation})": self.orientation > 1,
        }
        space = self.colour_space if as_colours else SRGB
        if not (space.is_srgb or (self.is_float and space.is_light)):
            done[f"converted from {space.name} to sRGB"] = True
        return tuple(words for words, holds in done.items() if holds)
