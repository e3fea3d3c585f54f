"""How much each map, and each texel of it, counts in a fit."""

from collections.abc import Collection, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import Key
from facezip.character.masks import nearest
from facezip.character.samples import Samples, samples_of
from facezip.character.scans import Character, Stack, unknown
from facezip.errors import ErrorCode, FaceZipError
from facezip.machine.rows import by_rows, sum_rows

# An image for the albedo of one tile; or one for each map and tile, where maps that have none take the albedo's.
Importance = NDArray[np.float32] | Mapping[Key, NDArray[np.float32]]


def importance_files(character: Character) -> dict[Key, str]:
    """The name of each image in a folder: ``importance.exr``, ``importance.normal.1002.exr``, in the order of maps."""
    first, several = character.maps[0].name, len(character.tiles) > 1
    return {
        (kind.name, tile): f"importance{f'.{kind.name}' * (kind.name != first)}{f'.{tile}' * several}.exr"
        for kind in character.maps
        for tile in character.tiles
    }


def by_key(importance: Importance | None, character: Character) -> dict[Key, NDArray[np.float32]]:
    """The images that there are by map and tile; empty for none.

    Raises
    ------
    FaceZipError
        ``SIZE_MISMATCH``: a tile has none of its albedo, a map that has some lacks one, or an image has another size
        than its map. ``UNKNOWN_NAME``: an image of a map or tile that there is not.
    """
    if importance is None:
        return {}
    first, tiles = character.maps[0].name, character.tiles
    if not isinstance(importance, Mapping):
        importance = {(first, tiles[0]): importance}
    for name, tile in importance:
        character.kind(name)
        character.tile(tile)
    for name in {first, *(name for name, _ in importance)}:
        missing = [tile for tile in tiles if (name, tile) not in importance]
        if missing:
            reason = f"none of {name} for tile {missing[0]} of {character.name}; give one image a tile"
            raise FaceZipError(ErrorCode.SIZE_MISMATCH, f"importance: {reason}")
    for (name, tile), image in importance.items():
        size = character.stacks[name, tile].resolution
        if image.shape != size:
            (height, width), (rows, columns) = image.shape, size
            whose = f"{name} of {character.name} has {columns} x {rows} on tile {tile}"
            reason = f"{width} x {height} texels; the {whose}: give as many"
            raise FaceZipError(ErrorCode.SIZE_MISMATCH, f"importance: {reason}")
    return dict(importance)


def weighted_samples(
    stack: Stack, weight: float, importance: NDArray[np.float32] | None = None, beside: float = 0
) -> Samples:
    """The texels of a map on a tile, whose squared errors count ``weight`` times their importance and the mask.

    An ``importance`` ``(H, W)`` may be of another map's size: its nearest texels are taken.
    """
    if importance is not None:
        importance = nearest(importance, stack.resolution)
    samples = samples_of(stack, importance, beside)
    if weight == 1:
        return samples
    before, factor = samples.importance, np.float32(weight)
    return replace(samples, importance=by_rows(lambda rows: before[rows] * factor, before.shape, np.float32))


def map_factors(
    character: Character, given: Mapping[str, float], judged: Collection[str] = frozenset()
) -> dict[str, float]:
    """The factor of each map's squared error: with a weight of 1 the expressions' differences of each map count alike
    in sum, whatever its units, channels and size; the first map's factor is the weight that is given for it, 1 if none.

    So it is of ``judged`` maps: they have an importance of their own, which says how much they count beside the first.

    Raises
    ------
    FaceZipError
        ``UNKNOWN_NAME`` for a map that there is not, ``BAD_VALUE`` for a weight that is not within 0 and 1e6.
    """
    names = [kind.name for kind in character.maps]
    for name, weight in given.items():
        if name not in names:
            raise unknown("map", name, names, character.name)
        if not 0 < weight <= 1e6:
            raise FaceZipError(ErrorCode.BAD_VALUE, f"weight {weight} of map '{name}': must be above 0 and at most 1e6")
    if len(names) == 1:
        return {names[0]: 1.0}
    energy = {name: sum(map(_energy, character.of_map(name).values())) for name in names}
    unit = energy[names[0]] or 1.0
    units = {name: 1.0 if name in judged else unit / (energy[name] or unit) for name in names}
    return {name: given.get(name, 1.0) * units[name] for name in names}


def _energy(stack: Stack) -> float:
    """Σ_n Σ_p m(p) ‖D_n(p)‖²."""
    samples = samples_of(stack)

    def block(top: int, bottom: int) -> NDArray[np.float64]:
        neutral = samples.neutral[top:bottom].astype(np.float32)
        gaps = (samples.scale * (texture[top:bottom].astype(np.float32) - neutral) for texture in samples.textures)
        squares = sum(np.einsum("hwc,hwc->hw", gap, gap) for gap in gaps)
        return np.vdot(samples.importance[top:bottom], squares).astype(np.float64)

    return float(sum_rows(block, len(samples.neutral)))
