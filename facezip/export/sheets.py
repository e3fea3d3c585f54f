"""The textures of an export: maps of one tile and size lie side by side in their channels, so that one fetch gives all.

Two channels of a normal and one of a roughness are one texture. Colours have one of their own, since the means of light
that their mip-maps hold are no other map's.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from facezip.character.maps import ALBEDO, Map
from facezip.character.neutrals import packed_neutral, unpacked_neutral
from facezip.files.images import Texels, to_float
from facezip.pack.model import CompressedTextures
from facezip.pack.quantise import ZERO

Kind = TypeVar("Kind", np.uint8, np.uint16, np.float32)
# Without alpha: block codecs, importers and render targets all have their own idea of it.
CHANNELS = 3


@dataclass(frozen=True, eq=False)
class Sheet:
    """Maps that share a neutral and difference textures.

    Attributes
    ----------
    maps : each kind, and its channels.
    model : all channels ``(H, W, C)``, C ≤ 3, as fitted texels (:class:`facezip.character.maps.MapKind`).
    difference_scale : ``(R, C)``: D = (t - 128/255) · scale, of fitted texels.
    neutral_bits : 8 or 16 a channel.
    covered : ``(H, W)``, whether a texel's centre lies in the UV chart; everywhere where the pack has no mesh.
    """

    maps: tuple[tuple[Map, slice], ...]
    model: CompressedTextures
    difference_scale: NDArray[np.float32]
    neutral_bits: int
    covered: NDArray[np.bool_]

    @property
    def name(self) -> str:
        """Of its maps; empty for the albedo, whose textures are called as those of a pack are."""
        names = [kind.name for kind, _ in self.maps]
        return "" if names == [ALBEDO] else "_".join(names)

    @property
    def textures(self) -> list[str]:
        """What its neutral and difference textures are called."""
        names = ["neutral", *(f"difference_{i}" for i in range(len(self.difference_scale)))]
        return [f"{self.name}_{name}" if self.name else name for name in names]

    @property
    def size(self) -> tuple[int, int]:
        """Rows and columns."""
        height, width, _ = self.model.neutral.shape
        return height, width

    @cached_property
    def fill(self) -> "Fill":
        """What fills its textures outside the chart."""
        return Fill(self.covered)

    @property
    def is_colour(self) -> bool:
        """Whether texels are encoded light, whose means are those of light."""
        return self.maps[0][0].encoding == "srgb"

    @property
    def scale_of_values(self) -> list[tuple[float, ...]]:
        """:attr:`difference_scale` in units of the maps: slopes of normals."""
        units = [kind.unit for kind, at in self.maps for _ in range(at.start, at.stop)]
        return [tuple(float(v) * unit for v, unit in zip(row, units, strict=True)) for row in self.difference_scale]

    def packed(self, fitted: NDArray[np.float32], bits: int) -> Texels:
        """A neutral ``(h, w, C)`` as it is stored, integers of one or three channels; normals as (n + 1) / 2."""
        parts = [packed_neutral(fitted[..., at], kind, bits)[..., : at.stop - at.start] for kind, at in self.maps]
        together: NDArray[Any] = np.concatenate(parts, axis=2)
        return _padded(together, 2**bits - 1)

    def unpacked(self, stored: Texels) -> NDArray[np.float32]:
        """Inverse of :meth:`packed`, float32."""
        return np.concatenate([to_float(unpacked_neutral(stored[..., at], kind)) for kind, at in self.maps], axis=2)

    def steps(self, difference: NDArray[np.float32], slot: int) -> NDArray[np.uint8]:
        """A difference ``(h, w, C)`` of a slot as it is stored, one or three channels; what lies beyond is clipped."""
        per_unit = np.float32(255) / np.maximum(self.difference_scale[slot], np.float32(1e-30))
        return _padded(np.clip(np.rint(difference * per_unit) + ZERO, 0, 255).astype(np.uint8), ZERO)

    def difference(self, stored: NDArray[np.uint8], slot: int) -> NDArray[np.float32]:
        """Inverse of :meth:`steps`."""
        scale = self.difference_scale[slot]
        texels = stored[..., : len(scale)].astype(np.float32) - np.float32(ZERO)
        return texels * (scale / np.float32(255))

    def stored(self) -> Iterator[Texels]:
        """Neutral and differences as the pack has them, outside the chart as what is nearest inside."""
        neutral: NDArray[Any] = self.packed(self.model.neutral, self.neutral_bits)
        yield self.fill(neutral)
        for slot, difference in enumerate(self.model.differences):
            yield self.fill(self.steps(difference, slot))


def in_sheets(alone: Iterable[Sheet]) -> tuple[Sheet, ...]:
    """Sheets of one map each, joined where three channels hold more: in their order, each into the first with room."""
    found: list[list[Sheet]] = []
    for sheet in alone:
        room = next((others for others in found if _fits(sheet, others)), None)
        if room is None:
            found.append([sheet])
        else:
            room.append(sheet)
    return tuple(_joined(sheets) for sheets in found)


def _fits(sheet: Sheet, others: Sequence[Sheet]) -> bool:
    first = others[0]
    alike = (sheet.size, sheet.neutral_bits) == (first.size, first.neutral_bits)
    channels = sum(len(one.difference_scale[0]) for one in (sheet, *others))
    return alike and channels <= CHANNELS and not (sheet.is_colour or first.is_colour)


def _joined(sheets: Sequence[Sheet]) -> Sheet:
    if len(sheets) == 1:
        return sheets[0]
    ends = np.cumsum([len(sheet.difference_scale[0]) for sheet in sheets]).tolist()
    places = [slice(start, end) for start, end in zip([0, *ends], ends, strict=False)]
    model = replace(
        sheets[0].model,
        neutral=np.concatenate([sheet.model.neutral for sheet in sheets], axis=2),
        differences=np.concatenate([sheet.model.differences for sheet in sheets], axis=3),
    )
    maps = tuple((sheet.maps[0][0], place) for sheet, place in zip(sheets, places, strict=True))
    scale = np.concatenate([sheet.difference_scale for sheet in sheets], axis=1)
    return replace(sheets[0], maps=maps, model=model, difference_scale=scale)


def _padded(texels: NDArray[Any], value: int) -> NDArray[Any]:
    """Images have one channel or three."""
    return np.pad(texels, ((0, 0), (0, 0), (0, int(texels.shape[2] == 2))), constant_values=value)


class Fill:
    """Makes each texel outside the chart like its nearest neighbour inside, so that no filter brings background in.

    Parameters
    ----------
    covered : ``(H, W)``, whether a texel is inside.
    """

    def __init__(self, covered: NDArray[np.bool_]) -> None:
        self._nearest: tuple[NDArray[np.int32], ...] | None = None
        if not covered.all():
            self._nearest = tuple(distance_transform_edt(~covered, return_distances=False, return_indices=True))

    def __call__(self, texels: NDArray[Kind]) -> NDArray[Kind]:
        """Fill ``(H, W, C)`` texels; those inside stay as they are."""
        return texels if self._nearest is None else texels[self._nearest]
