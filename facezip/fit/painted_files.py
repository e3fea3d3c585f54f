"""Painted weight maps as images, by the names of expressions, tiles and layers."""

import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from facezip.character.scans import Character, unknown
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.images import Texels, read_texture_exactly
from facezip.fit.painted import Painted
from facezip.names import one_form
from facezip.pack.footprint import SLOTS_PER_LAYER

_NAME = re.compile(r"(?P<expression>.+?)(?:\.(?P<tile>1\d{3}))?(?:\.difference_(?P<slot>\d))?", re.DOTALL)


def read_painted(named: Mapping[str, Path], character: Character, slots: int, weight_scale: int) -> tuple[Painted, ...]:
    """Painted weight maps by name: ``smile``, ``smile.difference_2``, ``smile.1002.difference_2``.

    Parameters
    ----------
    named : files by name; a tile has to be named where there are several. Where no layer is named, an image holds the
        maps of all of them in its channels, of four at most, as the atlas of a pack does.
    character : whose expressions they are.
    slots, weight_scale : how many layers there are, and how many times smaller weight maps are.

    Raises
    ------
    FaceZipError
        ``UNKNOWN_NAME`` for an expression, tile or layer that there is not; ``BAD_VALUE`` for two images of one map, or
        several tiles of which none is named; ``MISSING_FILE``; ``UNREADABLE_IMAGE``; ``SIZE_MISMATCH``; ``BAD_TEXELS``
        for an image that is not of 8 bits and as many channels.
    """
    painted = []
    taken: set[tuple[str, int, int]] = set()
    for name, file in named.items():
        one = _read(name, file, character, slots, weight_scale)
        own = {(one.expression, one.tile, slot) for slot in one.texels}
        if own & taken:
            raise _refused(name, f"a weight map of {one.expression} is locked twice; leave one out")
        painted.append(one)
        taken |= own
    return tuple(painted)


def _refused(name: str, reason: str) -> FaceZipError:
    return FaceZipError(ErrorCode.BAD_VALUE, f"--lock-weights '{name}': {reason}")


def _read(name: str, file: Path, character: Character, slots: int, weight_scale: int) -> Painted:
    expression, number, slot = _parsed(name, character)
    character.index(expression)
    if number is None and len(character.tiles) > 1:
        tiles = ", ".join(map(str, character.tiles))
        raise _refused(name, f"there are tiles {tiles}; name one of them too, as {expression}.{character.tiles[0]}")
    tile = character.tile(number)
    if slot is not None and slot >= slots:
        raise unknown("layer", f"difference_{slot}", [f"difference_{i}" for i in range(slots)], "this fit")
    if not file.is_file():
        reason = f"no such image; --lock-weights takes a painted weight map, {name}=FILE"
        raise FaceZipError(ErrorCode.MISSING_FILE, f"{file}: {reason}")
    those = range(min(slots, SLOTS_PER_LAYER)) if slot is None else (slot,)
    texels = _of_channels(read_texture_exactly(file), len(those), file, expression)
    height, width = character.stacks[character.maps[0].name, tile].resolution
    size = -(-height // weight_scale), -(-width // weight_scale)
    if texels.shape[:2] != size:
        (rows, columns), (h, w) = texels.shape[:2], size
        reason = f"{columns}x{rows} texels, weight maps of this fit have {w}x{h}; paint it at that size"
        raise FaceZipError(ErrorCode.SIZE_MISMATCH, f"{file}: {reason}")
    return Painted(expression, tile, {i: np.ascontiguousarray(texels[..., k]) for k, i in enumerate(those)})


def _parsed(name: str, character: Character) -> tuple[str, int | None, int | None]:
    """Expression, tile and layer; an expression may be called as if it named those."""
    match = _NAME.fullmatch(one_form(name))
    if match is None or match.string in character.expressions:
        return one_form(name), None, None
    tile, slot = match["tile"], match["slot"]
    return match["expression"], int(tile) if tile else None, int(slot) if slot else None


def _of_channels(texels: Texels, count: int, file: Path, expression: str) -> NDArray[np.uint8]:
    """The image with a channel for each layer: as many as there are, or four as in a pack."""
    if count == 1:
        texels = _grey(texels)
    channels = texels.shape[2]
    if texels.dtype != np.uint8 or channels not in (count, SLOTS_PER_LAYER if count > 1 else count):
        found = f"{channels} channel(s) of {8 * texels.itemsize} bits"
        needed = (
            f"{count} of 8" if count == 1 else f"{count} of 8, or one for each layer, {expression}.difference_0=FILE"
        )
        raise FaceZipError(ErrorCode.BAD_TEXELS, f"{file}: {found}; the weight map has {needed}: save it so")
    return texels.astype(np.uint8, copy=False)[..., :count]


def _grey(texels: Texels) -> Texels:
    """One channel of an image whose alpha says nothing and whose colours are alike, as many tools save grey."""
    if texels.shape[2] in (2, 4) and bool(np.min(texels[..., -1]) == np.iinfo(str(texels.dtype)).max):
        texels = texels[..., :-1]
    return texels[..., :1] if bool((texels == texels[..., :1]).all()) else texels
