"""The pictures of Figure 8: the part of each shape's texture that changes most, made in several ways, side by side."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter, zoom

from facezip.character.scans import Character
from facezip.files.images import to_float
from reports.images import data_uri, to_bytes

# Of a texture's side: how much a picture shows. And in pixels: how wide it is, and the gap to the next.
PART, WIDTH, GAP = 0.28, 220, 6
Texture = NDArray[np.float32]


def strips(scans: Character, columns: Mapping[str, Callable[[str], Texture]], shapes: Sequence[str]) -> dict[str, str]:
    """A data URI for each shape: its texture by every column, where the first one differs most from the neutral."""
    neutral = to_float(scans.first.neutral)
    mask = np.ones(scans.first.resolution, np.float32) if scans.first.mask is None else scans.first.mask
    found = {}
    for shape in shapes:
        textures = [texture(shape) for texture in columns.values()]
        window = _window(np.abs(textures[0] - neutral).mean(axis=2) * mask)
        found[shape] = data_uri(to_bytes(_beside([texture[window] for texture in textures])), 90)
    return found


def _window(change: NDArray[np.float32]) -> tuple[slice, slice]:
    """The square with the most change."""
    sides = [max(round(PART * side), 1) for side in change.shape]
    within = uniform_filter(change, sides, mode="constant")
    at = np.unravel_index(int(within.argmax()), change.shape)
    begins = [
        min(max(int(middle) - side // 2, 0), whole - side)
        for middle, side, whole in zip(at, sides, change.shape, strict=True)
    ]
    rows, columns = (slice(begin, begin + side) for begin, side in zip(begins, sides, strict=True))
    return rows, columns


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
