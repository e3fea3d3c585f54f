"""How much each map, and each texel of it, counts in a fit."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from facezip.character.samples import Samples, samples_of
from facezip.character.scans import Character, Stack, unknown
from facezip.errors import ErrorCode, FaceZipError
from facezip.machine.rows import by_rows, sum_rows

# An image for one tile, or one for each.
Importance = NDArray[np.float32] | Mapping[int, NDArray[np.float32]]


def importance_files(tiles: tuple[int, ...]) -> dict[int, str]:
    """The name of the image of each tile in a folder: ``importance.exr``, with the number where there are several."""
    return {tile: f"importance.{tile}.exr" if len(tiles) > 1 else "importance.exr" for tile in tiles}


def by_tile(importance: Importance | None, character: Character) -> dict[int, NDArray[np.float32]]:
    """The importance of every tile; empty for none.

    Raises
    ------
    FaceZipError
        ``SIZE_MISMATCH``: one image for several tiles, a tile without one, or an image of another size than its albedo.
    """
    if importance is None:
        return {}
    if not isinstance(importance, Mapping):
        importance = {character.tiles[0]: importance}
    missing = [tile for tile in character.tiles if tile not in importance]
    if missing:
        reason = f"none for tile {missing[0]} of {character.name}; give one image a tile"
        raise FaceZipError(ErrorCode.SIZE_MISMATCH, f"importance: {reason}")
    for tile, stack in character.of_map(character.maps[0].name).items():
        if importance[tile].shape != stack.resolution:
            (height, width), (rows, columns) = importance[tile].shape, stack.resolution
            reason = f"{width} x {height} texels; {character.name} has {columns} x {rows} on tile {tile}: give as many"
            raise FaceZipError(ErrorCode.SIZE_MISMATCH, f"importance: {reason}")
    return dict(importance)


def weighted_samples(
    stack: Stack, weight: float, importance: NDArray[np.float32] | None = None, beside: float = 0
) -> Samples:
    """The texels of a map on a tile, whose squared errors count ``weight`` times their importance and the mask.

    An ``importance`` ``(H, W)`` is of the albedo's size; finer and coarser maps take its nearest texels.
    """
    if importance is not None and importance.shape != stack.resolution:
        importance = _nearest(importance, stack.resolution)
    samples = samples_of(stack, importance, beside)
    if weight == 1:
        return samples
    before, factor = samples.importance, np.float32(weight)
    return replace(samples, importance=by_rows(lambda rows: before[rows] * factor, before.shape, np.float32))


def map_factors(character: Character, given: Mapping[str, float]) -> dict[str, float]:
    """The factor of each map's squared error: with a weight of 1 the expressions' differences of each map count alike
    in sum, whatever its units, channels and size; the first map's factor is the weight that is given for it, 1 if none.

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
            raise FaceZipError(ErrorCode.BAD_VALUE, f"weight {weight} of map '{name}': must lie within 0 and 1e6")
    if len(names) == 1:
        return {names[0]: 1.0}
    energy = {name: sum(map(_energy, character.of_map(name).values())) for name in names}
    unit = energy[names[0]] or 1.0
    return {name: given.get(name, 1.0) * unit / (energy[name] or unit) for name in names}


def _energy(stack: Stack) -> float:
    """Σ_n Σ_p m(p) ‖D_n(p)‖²."""
    samples = samples_of(stack)

    def block(top: int, bottom: int) -> NDArray[np.float64]:
        neutral = samples.neutral[top:bottom].astype(np.float32)
        gaps = (samples.scale * (texture[top:bottom].astype(np.float32) - neutral) for texture in samples.textures)
        squares = sum(np.einsum("hwc,hwc->hw", gap, gap) for gap in gaps)
        return np.vdot(samples.importance[top:bottom], squares).astype(np.float64)

    return float(sum_rows(block, len(samples.neutral)))


def _nearest(image: NDArray[np.float32], size: tuple[int, int]) -> NDArray[np.float32]:
    down, across = (np.arange(to) * of // to for to, of in zip(size, image.shape, strict=True))
    return by_rows(lambda rows: image[down[rows]][:, across], size, np.float32)
