"""Which maps share textures: those of one tile and size lie side by side in three channels, one fetch gives all.

Two channels of a normal and one of a roughness are one texture. Colours have one of their own, since the means of light
that their mip-maps hold are no other map's.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.export.sheets import Sheet
from facezip.machine.rows import by_rows

# Without alpha: block codecs, importers and render targets all have their own idea of it.
CHANNELS = 3


def joined(alone: Iterable[Sheet]) -> tuple[Sheet, ...]:
    """Sheets of one map each, joined where three channels hold more: in their order, each into the first with room."""
    found: list[list[Sheet]] = []
    for sheet in alone:
        room = next((others for others in found if _fits(sheet, others)), None)
        if room is None:
            found.append([sheet])
        else:
            room.append(sheet)
    return tuple(_side_by_side(sheets) for sheets in found)


def _fits(sheet: Sheet, others: Sequence[Sheet]) -> bool:
    first = others[0]
    alike = (sheet.size, sheet.neutral.dtype) == (first.size, first.neutral.dtype)
    channels = sum(one.channels for one in (sheet, *others))
    return alike and channels <= CHANNELS and not (sheet.is_colour or first.is_colour)


def _side_by_side(sheets: Sequence[Sheet]) -> Sheet:
    if len(sheets) == 1:
        return sheets[0]
    first, ends = sheets[0], np.cumsum([sheet.channels for sheet in sheets]).tolist()
    places = [slice(start, end) for start, end in zip([0, *ends], ends, strict=False)]
    return replace(
        first,
        maps=tuple((sheet.maps[0][0], place) for sheet, place in zip(sheets, places, strict=True)),
        neutral=_beside([sheet.neutral for sheet in sheets], axis=0),
        differences=_beside([sheet.differences for sheet in sheets], axis=1),
        span=np.concatenate([sheet.span for sheet in sheets], axis=1),
    )


def _beside(textures: Sequence[NDArray[Any]], axis: int) -> NDArray[Any]:
    """Textures with their channels one after the other; rows lie along ``axis``."""
    before, first = (slice(None),) * axis, textures[0]
    shape = *first.shape[:-1], sum(texture.shape[-1] for texture in textures)

    def rows(some: slice) -> NDArray[Any]:
        return np.concatenate([texture[(*before, some)] for texture in textures], axis=-1)

    return by_rows(rows, shape, first.dtype, axis)
