"""Difference textures that an artist painted: they stay byte for byte, and the rest is fitted around them.

A byte b of such a layer stands for (b - 128) · unit, as of any difference texture. The unit is free, since weights are
fitted to it: it is chosen so that the layer and its weights are about as large as in the gauge of a free fit
(:func:`facezip.fit.start.balanced_start`).
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import Key
from facezip.character.samples import Samples
from facezip.character.scans import Character, unknown
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.images import Texels, read_texture_exactly
from facezip.fit.pca import difference_gram
from facezip.pack.quantise import STEPS, ZERO

_NAME = re.compile(r"(?:(?P<map>[a-z][a-z0-9_]*)\.)?(?:(?P<tile>\d{4})\.)?difference_(?P<slot>\d)")


@dataclass(frozen=True, eq=False)
class Lock:
    """A layer that stays as it is.

    Attributes
    ----------
    name : as a pack calls its file, without ``.png``.
    key, slot : of which map on which tile, and which of its difference textures.
    texels : ``(H, W, C)`` uint8; 128 changes nothing.
    """

    name: str
    key: Key
    slot: int
    texels: NDArray[np.uint8]

    def texture(self, unit: np.float32) -> NDArray[np.float32]:
        """The difference texture ``(H, W, C)``."""
        return (self.texels.astype(np.float32) - np.float32(ZERO)) * unit

    def unit(self, samples: Samples) -> np.float32:
        """What one step of a byte stands for, for the texels of its map on its tile."""
        count, channels = len(samples.textures), samples.neutral.shape[2]
        total = max(float(samples.importance.sum(dtype=np.float64)), 1e-30)
        size = np.sqrt(np.trace(difference_gram(samples)) / (total * count * channels))
        steps = np.square(self.texels.astype(np.float32) - np.float32(ZERO)).mean(axis=2)
        own = np.sqrt(np.vdot(samples.importance, steps) / total)
        balanced = np.sqrt(size * np.sqrt(count / channels))
        return np.float32(max(balanced, 1e-6) / own if own > 0 else 1 / STEPS)


def read_locks(named: Mapping[str, Path], character: Character, slots: int) -> tuple[Lock, ...]:
    """Painted layers by name: ``difference_0``, ``normal.difference_0``, ``albedo.1002.difference_0``.

    Parameters
    ----------
    named : files by name. A map that is not named is the albedo; a tile has to be, where there are several.
    character : whose layers they are.
    slots : how many there are.

    Raises
    ------
    FaceZipError
        ``BAD_VALUE`` for a name of another form, or two of one layer; ``UNKNOWN_NAME`` for a map, tile or layer that
        there is not; ``MISSING_FILE``; ``UNREADABLE_IMAGE``; ``SIZE_MISMATCH``; ``BAD_TEXELS`` for an image that is not
        of 8 bits and as many channels as a pack has.
    """
    locks: dict[str, Lock] = {}
    for name, file in named.items():
        lock = _read(name, file, character, slots)
        if lock.name in locks:
            raise FaceZipError(ErrorCode.BAD_VALUE, f"--lock '{name}': {lock.name} is locked twice; leave one out")
        locks[lock.name] = lock
    return tuple(locks.values())


def _read(name: str, file: Path, character: Character, slots: int) -> Lock:
    match = _NAME.fullmatch(name)
    if match is None:
        form = "write it as difference_0=FILE, normal.difference_0=FILE, or albedo.1002.difference_0=FILE"
        raise FaceZipError(ErrorCode.BAD_VALUE, f"--lock '{name}': {form}")
    kind = character.kind(match["map"] or character.maps[0].name)
    if match["tile"] is None and len(character.tiles) > 1:
        tiles = ", ".join(map(str, character.tiles))
        raise FaceZipError(ErrorCode.BAD_VALUE, f"--lock '{name}': there are tiles {tiles}; name one of them too")
    tile, slot = character.tile(int(match["tile"]) if match["tile"] else None), int(match["slot"])
    if slot >= slots:
        raise unknown("layer", f"difference_{slot}", [f"difference_{i}" for i in range(slots)], "this fit")
    key = kind.name, tile
    if not file.is_file():
        raise FaceZipError(ErrorCode.MISSING_FILE, f"{file}: no such image; --lock takes a painted layer, {name}=FILE")
    stack = character.stacks[key]
    texels = _of_channels(read_texture_exactly(file), 3 if kind.is_normal else stack.channels, file)
    if texels.shape[:2] != stack.resolution:
        (h, w), (rows, columns) = texels.shape[:2], stack.resolution
        reason = f"{w}x{h} texels, {kind.name} of {character.name} has {columns}x{rows}; paint it at that size"
        raise FaceZipError(ErrorCode.SIZE_MISMATCH, f"{file}: {reason}")
    return Lock(f"{kind.name}.{tile}.difference_{slot}", key, slot, texels[..., : stack.channels])


def _of_channels(texels: Texels, channels: int, file: Path) -> NDArray[np.uint8]:
    """The image without an alpha that says nothing."""
    if texels.shape[2] == channels + 1 and bool(np.min(texels[..., -1]) == np.iinfo(str(texels.dtype)).max):
        texels = texels[..., :-1]
    if texels.dtype != np.uint8 or texels.shape[2] != channels:
        found = f"{texels.shape[2]} channels of {8 * texels.itemsize} bits"
        raise FaceZipError(ErrorCode.BAD_TEXELS, f"{file}: {found}; a layer has {channels} of 8: save it so")
    return np.ascontiguousarray(texels, np.uint8)


def of_maps(
    locks: Sequence[Lock], keys: Sequence[Key], units: Mapping[str, np.float32]
) -> list[dict[int, NDArray[np.float32]]]:
    """The locked textures of each of some maps, by slot."""
    return [{lock.slot: lock.texture(units[lock.name]) for lock in locks if lock.key == key} for key in keys]
