"""A sheet: maps side by side in the channels of one neutral and its difference textures, as stored and as seen."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import ALBEDO, Map
from facezip.character.neutrals import packed_neutral, unpacked_neutral
from facezip.export.fill import Fill
from facezip.files.images import Texels, to_float
from facezip.machine.rows import by_rows
from facezip.pack.model import Part
from facezip.pack.quantise import ZERO


@dataclass(frozen=True, eq=False)
class Sheet:
    """Maps that share a neutral and difference textures.

    Attributes
    ----------
    maps : each kind, and its channels.
    neutral : ``(H, W, C)`` as the pack stores it, C ≤ 3, uint8 or uint16; of normals x and y.
    differences : ``(R, H, W, C)`` uint8.
    span : ``(R, C)`` float32: D = (t - 128/255) · span, of texels.
    expressions : N names.
    weights : ``(N, h, w, R)`` float32, which all sheets of a tile share.
    fill : which texels lie in the UV chart, all where the pack has no mesh, and what fills the rest.
    """

    maps: tuple[tuple[Map, slice], ...]
    neutral: Texels
    differences: NDArray[np.uint8]
    span: NDArray[np.float32]
    expressions: tuple[str, ...]
    weights: NDArray[np.float32]
    fill: Fill

    @property
    def name(self) -> str:
        """Of its maps; empty for the albedo, whose textures are called as those of a pack are."""
        names = [kind.name for kind, _ in self.maps]
        return "" if names == [ALBEDO] else "_".join(names)

    @property
    def textures(self) -> list[str]:
        """What its neutral and difference textures are called."""
        names = ["neutral", *(f"difference_{i}" for i in range(len(self.span)))]
        return [f"{self.name}_{name}" if self.name else name for name in names]

    @property
    def size(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.neutral.shape[0], self.neutral.shape[1]

    @property
    def channels(self) -> int:
        """C, of a texel."""
        return int(self.neutral.shape[2])

    @property
    def is_colour(self) -> bool:
        """Whether texels are encoded light, whose means are those of light."""
        return self.maps[0][0].encoding == "srgb"

    @property
    def is_normal(self) -> bool:
        """Whether the first of its maps is one of normals."""
        return self.maps[0][0].is_normal

    @property
    def span_of_values(self) -> list[tuple[float, ...]]:
        """:attr:`span` in units of the maps: slopes of normals."""
        units = [kind.unit for kind, at in self.maps for _ in range(at.start, at.stop)]
        return [tuple(float(v) * unit for v, unit in zip(row, units, strict=True)) for row in self.span]

    def dequantised(self) -> Part:
        """What is stored as float32 texels, which take four times as much."""
        steps = (self.span / np.float32(255))[:, None, None]

        def values(rows: slice) -> NDArray[np.float32]:
            return (self.differences[:, rows].astype(np.float32) - np.float32(ZERO)) * steps

        return Part(self.unpacked(self.neutral), by_rows(values, self.differences.shape, np.float32, axis=1))

    def packed(self, texels: NDArray[np.float32]) -> NDArray[np.uint8]:
        """A neutral ``(h, w, C)`` of texels as bytes, one or three channels; normals as (n + 1) / 2."""

        def rows(some: slice) -> NDArray[np.uint8]:
            parts = [packed_neutral(texels[some, :, at], kind, 8)[..., : at.stop - at.start] for kind, at in self.maps]
            together: NDArray[Any] = np.concatenate(parts, axis=2)
            return _padded(together, 255)

        return by_rows(rows, _padded_shape(texels), np.uint8)

    def unpacked(self, stored: Texels) -> NDArray[np.float32]:
        """Texels ``(h, w, C)`` float32 of a neutral as it is stored, or as a sampler sees that."""

        def rows(some: slice) -> NDArray[np.float32]:
            parts = [unpacked_neutral(stored[some, :, at], kind) for kind, at in self.maps]
            return np.concatenate([to_float(one) for one in parts], axis=2)

        return by_rows(rows, (*stored.shape[:2], self.channels), np.float32)

    def steps(self, difference: NDArray[np.float32], slot: int) -> NDArray[np.uint8]:
        """A difference ``(h, w, C)`` of a slot as it is stored, one or three channels; what lies beyond is clipped."""
        per_unit = np.float32(255) / np.maximum(self.span[slot], np.float32(1e-30))

        def rows(some: slice) -> NDArray[np.uint8]:
            return _padded(np.clip(np.rint(difference[some] * per_unit) + ZERO, 0, 255).astype(np.uint8), ZERO)

        return by_rows(rows, _padded_shape(difference), np.uint8)

    def difference(self, stored: Texels, slot: int) -> NDArray[np.float32]:
        """The difference ``(h, w, C)`` of a slot as it is stored, or as a sampler sees that."""
        step = self.span[slot] / np.float32(255)

        def rows(some: slice) -> NDArray[np.float32]:
            return (in_bytes(stored[some, :, : self.channels]) - np.float32(ZERO)) * step

        return by_rows(rows, (*stored.shape[:2], self.channels), np.float32)

    def neutral_image(self) -> Texels:
        """The neutral as an image has it."""
        return _image(self.neutral, int(np.iinfo(str(self.neutral.dtype)).max))

    def images(self) -> Iterator[Texels]:
        """Neutral and differences as the pack has them, outside the chart as what is nearest inside."""
        differences = (_image(difference, ZERO) for difference in self.differences)
        yield from map(self.fill, chain([self.neutral_image()], differences))


def in_bytes(seen: Texels) -> NDArray[np.float32]:
    """What a sampler sees, in units of 0..255, finer than those where it interpolates."""
    return seen * np.float32(255 / np.iinfo(str(seen.dtype)).max)


def _image(texels: NDArray[Any], third: int) -> NDArray[Any]:
    return by_rows(lambda rows: _padded(texels[rows], third), _padded_shape(texels), texels.dtype)


def _padded(texels: NDArray[Any], third: int) -> NDArray[Any]:
    """Images have one channel or three."""
    return np.pad(texels, ((0, 0), (0, 0), (0, int(texels.shape[2] == 2))), constant_values=third)


def _padded_shape(texels: NDArray[Any]) -> tuple[int, int, int]:
    height, width, channels = texels.shape
    return height, width, channels + (channels == 2)
