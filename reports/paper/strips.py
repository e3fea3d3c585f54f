"""The pictures of Figure 8: the part of each shape's texture that changes most, made in several ways, side by side."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter, zoom

from facezip.character.maps import ALBEDO
from facezip.character.scans import Character
from facezip.files.images import to_float
from reports.images import data_uri, to_bytes

# Of a texture's side: how much a picture shows. And in pixels: how wide it is, and the gap to the next.
PART, WIDTH, GAP = 0.28, 220, 6
Texture = NDArray[np.float32]


# A tile, and rows and columns of its texture.
Window = tuple[int, tuple[slice, slice]]


def strips(
    scans: Character, columns: Mapping[str, Callable[[str, int], Texture]], shapes: Sequence[str]
) -> dict[str, str]:
    """A data URI for each shape: its albedo by every column, where the first one differs most from the neutral.

    Columns give ``(H, W, C)`` of a shape on a tile.
    """
    first, found = next(iter(columns.values())), {}
    for shape in shapes:
        tile, window = _window(scans, {tile: first(shape, tile) for tile in scans.tiles})
        parts = [texture(shape, tile)[window] for texture in columns.values()]
        found[shape] = data_uri(to_bytes(_beside(parts)), 90)
    return found


def _window(scans: Character, textures: Mapping[int, Texture]) -> Window:
    """The square with the most change on any tile."""
    best: tuple[float, Window] | None = None
    for tile, texture in textures.items():
        stack = scans.stacks[ALBEDO, tile]
        change = np.abs(texture - to_float(stack.neutral)).mean(axis=2) * stack.weight
        most, window = _most(change)
        if best is None or most > best[0]:
            best = most, (tile, window)
    if best is None:
        raise ValueError("no tile to look at")
    return best[1]


def _most(change: NDArray[np.float32]) -> tuple[float, tuple[slice, slice]]:
    """The mean of a change ``(H, W)`` over the square where it is largest, and that square."""
    sides = [max(round(PART * side), 1) for side in change.shape]
    within = uniform_filter(change, sides, mode="constant")
    at = np.unravel_index(int(within.argmax()), change.shape)
    begins = [
        min(max(int(middle) - side // 2, 0), whole - side)
        for middle, side, whole in zip(at, sides, change.shape, strict=True)
    ]
    rows, columns = (slice(begin, begin + side) for begin, side in zip(begins, sides, strict=True))
    return float(within[at]), (rows, columns)


def _beside(parts: Sequence[Texture]) -> Texture:
    """The parts, enlarged, from left to right with gaps of the page's colour between them."""
    large = [_shown(part) for part in parts]
    gap = np.full((len(large[0]), GAP, 3), 0.5, np.float32)
    joined: Texture = np.concatenate([piece for part in large for piece in (part, gap)][:-1], axis=1)
    return joined


def _shown(part: Texture) -> Texture:
    factor = WIDTH / part.shape[1]
    colour = part if part.shape[2] == 3 else np.repeat(part[:, :, :1], 3, axis=2)
    large: Texture = np.clip(zoom(colour, (factor, factor, 1), order=1, grid_mode=True, mode="nearest"), 0, 1)
    return large
