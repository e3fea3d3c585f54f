"""From linear renders to pictures inside a page: encoding for a display, difference maps, data URIs."""

import base64
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from io import BytesIO
from pathlib import Path

import matplotlib
import numpy as np
import OpenImageIO as oiio
from numpy.typing import NDArray
from PIL import Image

from facezip.errors import ErrorCode, FaceZipError
from facezip.files.opening import opened, reason
from facezip.files.srgb import decode_srgb, encode_srgb

# What stands behind a head, encoded: a dark neutral that belongs to no side of a colour judgement.
BACKDROP = (24, 25, 27)
COLOUR_MAP = "inferno"


def read_coverage(path: Path) -> NDArray[np.float32]:
    """Coverage ``(H, W)`` of the first part of a render, without reading the other parts.

    Raises
    ------
    FaceZipError
        ``MISSING_FILE`` or ``UNREADABLE_IMAGE``, naming the file.
    """
    with opened(path) as image:
        spec = image.spec()
        pixels = image.read_image(0, 0, 3, 4, oiio.FLOAT) if spec.nchannels == 4 else None
        if pixels is None:
            raise FaceZipError(ErrorCode.UNREADABLE_IMAGE, f"{path}: {reason(image)}; validate again")
    return np.asarray(pixels, np.float32).reshape(spec.height, spec.width)


def display(render: NDArray[np.float32]) -> NDArray[np.float32]:
    """A linear premultiplied ``(H, W, 4)`` render as an sRGB display shows it: ``(H, W, 3)`` encoded, in [0, 1].

    The head stands before :data:`BACKDROP`; values above 1 are clipped, as a display clips them.
    """
    backdrop = decode_srgb(np.float32(1 / 255) * np.array(BACKDROP, np.float32))
    linear = render[..., :3] + (1 - render[..., 3:4]) * backdrop
    return encode_srgb(np.clip(linear, 0, 1))


def difference(original: NDArray[np.float32], compressed: NDArray[np.float32]) -> NDArray[np.float32]:
    """``(H, W)`` difference of two displayed pictures: the largest of the three channels, 0..255."""
    red, green, blue = (np.abs(original[..., i] - compressed[..., i]) for i in range(3))
    largest: NDArray[np.float32] = np.maximum(np.maximum(red, green), blue)
    return largest * np.float32(255)


@dataclass(frozen=True)
class ColourScale:
    """A perceptually uniform scale for differences between 0 and ``limit`` (of 255); what is above is clipped."""

    limit: float

    @classmethod
    def for_error(cls, rmse: float) -> "ColourScale":
        """The scale of a whole page: the first power of two above four times its worst RMSE, 1 to 64."""
        return cls(float(2 ** np.clip(np.ceil(np.log2(max(4 * rmse, 1))), 0, 6)))

    @property
    def factor(self) -> float:
        """How many times a difference is amplified when ``limit`` fills the range of the display."""
        return 256 / self.limit

    @cached_property
    def table(self) -> NDArray[np.uint8]:
        """``(256, 3)`` colours from no difference to ``limit``."""
        colours = np.asarray(matplotlib.colormaps[COLOUR_MAP](np.linspace(0, 1, 256)), np.float32)
        return to_bytes(colours[:, :3])

    def colours(self, differences: NDArray[np.float32]) -> NDArray[np.uint8]:
        """Differences ``(H, W)``, 0..255, as ``(H, W, 3)`` colours."""
        return np.take(self.table, to_bytes(differences / np.float32(self.limit)), axis=0)

    def gradient(self, stops: int = 12) -> str:
        """The scale as the colours of a CSS gradient."""
        picked = self.table[np.rint(np.linspace(0, 255, stops)).astype(int)]
        return ", ".join("#{:02x}{:02x}{:02x}".format(*colour) for colour in picked)


@dataclass(frozen=True)
class Crop:
    """The part of a picture that is shown: rows ``top:bottom``, columns ``left:right``."""

    top: int
    bottom: int
    left: int
    right: int

    @classmethod
    def around(cls, coverages: Iterable[NDArray[np.float32]], margin: float = 0.02) -> "Crop":
        """The smallest crop that holds all covered pixels of pictures of one size, and a margin."""
        seen = np.logical_or.reduce([coverage > 0 for coverage in coverages])
        height, width = seen.shape
        rows, columns = np.flatnonzero(seen.any(axis=1)), np.flatnonzero(seen.any(axis=0))
        if rows.size == 0:
            return cls(0, height, 0, width)
        edge = round(margin * max(height, width))
        return cls(
            max(int(rows[0]) - edge, 0), min(int(rows[-1]) + 1 + edge, height),
            max(int(columns[0]) - edge, 0), min(int(columns[-1]) + 1 + edge, width),
        )  # fmt: skip

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels."""
        return self.right - self.left, self.bottom - self.top

    def of(self, picture: NDArray[np.float32]) -> NDArray[np.float32]:
        """The cropped picture ``(h, w, ...)``."""
        return picture[self.top : self.bottom, self.left : self.right]


def to_bytes(picture: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Encoded values in [0, 1] rounded to 8 bits."""
    return np.rint(np.clip(picture, 0, 1) * 255).astype(np.uint8)


def data_uri(pixels: NDArray[np.uint8], quality: int | None = None) -> str:
    """An 8-bit picture ``(H, W, 3)`` as a WebP data URI, of ``quality`` 0..100, lossless without one."""
    file = BytesIO()
    if quality is None:
        Image.fromarray(pixels).save(file, "webp", lossless=True, quality=0, method=0)
    else:
        Image.fromarray(pixels).save(file, "webp", quality=quality, method=1)
    return "data:image/webp;base64," + base64.b64encode(file.getvalue()).decode("ascii")
