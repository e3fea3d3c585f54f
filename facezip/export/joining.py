"""Which maps share textures: those of one tile and size lie side by side in three channels, one fetch gives all.

Two channels of a normal and one of a roughness are one texture. Colours have one of their own, since the means of light
that their mip-maps hold are no other map's. Blocks keep normals best on their own, where that takes no fetch more.
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


def joined(alone: Sequence[Sheet], normals_alone: bool = False) -> tuple[Sheet, ...]:
    """Sheets of one map each, joined where three channels hold more: in their order, each into the first with room.

    With ``normals_alone`` nothing is joined to normals, unless that made more sheets.
    """
    groups = _grouped(alone, normals_alone=False)
    apart = _grouped(alone, normals_alone=True)
    if normals_alone and len(apart) <= len(groups):
        groups = apart
    return tuple(_side_by_side(sheets) for sheets in groups)


def _grouped(alone: Iterable[Sheet], normals_alone: bool) -> list[list[Sheet]]:
    groups: list[list[Sheet]] = []
    for sheet in alone:
        room = next((others for others in groups if _fits(sheet, others, normals_alone)), None)
        if room is None:
            groups.append([sheet])
        else:
            room.append(sheet)
    return groups


def _fits(sheet: Sheet, others: Sequence[Sheet], normals_alone: bool) -> bool:
    first = others[0]
    alike = (sheet.size, sheet.neutral.dtype) == (first.size, first.neutral.dtype)
    channels = sum(one.channels for one in (sheet, *others))
    alone = any(one.is_colour or (normals_alone and one.is_normal) for one in (sheet, first))
    return alike and channels <= CHANNELS and not alone


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
