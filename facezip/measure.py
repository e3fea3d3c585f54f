"""How far reconstructed textures are from the originals."""

from collections.abc import Callable, Mapping

import numpy as np
from numba import njit
from numpy.typing import NDArray

from facezip.character import Character
from facezip.fragments import texel_scale
from facezip.progress import track
from facezip.rows import map_rows


def texture_errors(character: Character, texture: Callable[[str], NDArray[np.float32]]) -> dict[str, float]:
    """RMSE of every expression, in units of 0..255, over channels and texels weighted by the character's mask.

    Parameters
    ----------
    character : the originals.
    texture : gives the other side, ``(H, W, C)`` float32 in [0, 1], for an expression's name.
    """
    weight = np.ones(character.resolution, np.float32) if character.mask is None else character.mask
    names = track(character.expressions, "Measuring textures", len(character.expressions))
    return {name: _rmse(character, name, texture(name), weight) for name in names}


def mean_rmse(errors: Mapping[str, float]) -> float:
    """The mean over expressions of their RMSE: one number for a character, as in the paper's Figure 6."""
    return sum(errors.values()) / len(errors)


def _rmse(character: Character, name: str, other: NDArray[np.float32], weight: NDArray[np.float32]) -> float:
    original = character.textures[character.index(name)]
    scale = texel_scale(character)

    def block(top: int, bottom: int) -> float:
        return float(_squared_error(top, bottom, original, scale, other, weight))

    total = sum(map_rows(block, len(original)))
    return float(255 * np.sqrt(total / (weight.sum(dtype=np.float64) * original.shape[2])))


@njit(cache=True, nogil=True)
def _squared_error(
    top: int,
    bottom: int,
    original: NDArray[np.uint8],
    scale: np.float32,
    other: NDArray[np.float32],
    weight: NDArray[np.float32],
) -> float:
    total = 0.0
    for y in range(top, bottom):
        for x in range(original.shape[1]):
            for c in range(original.shape[2]):
                gap = scale * np.float32(original[y, x, c]) - other[y, x, c]
                total += weight[y, x] * gap * gap
    return total
