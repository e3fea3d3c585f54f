"""The weight maps of all expressions as one image: N maps side by side, four slots in its four channels."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.files.images import Texels
from facezip.machine import memory
from facezip.pack.footprint import SLOTS_PER_LAYER


def atlas(slots: NDArray[Any], columns: int) -> NDArray[np.uint8]:
    """``(N, h, w, ≤4)`` weight maps as one RGBA image, in expression order, row by row."""
    n, h, w, used = slots.shape
    image: NDArray[np.uint8] = memory.zeros((-(-n // columns) * h, columns * w, SLOTS_PER_LAYER), np.uint8)
    for place, slot in zip(_places(n, (h, w), columns), slots, strict=True):
        image[(*place, slice(used))] = slot
        memory.ease()
    return image


def atlases(weights: NDArray[Any], columns: int) -> list[NDArray[np.uint8]]:
    """``(N, h, w, R)`` weight maps as the atlas of every four slots."""
    slots = range(0, weights.shape[3], SLOTS_PER_LAYER)
    return [atlas(weights[..., slot : slot + SLOTS_PER_LAYER], columns) for slot in slots]


def columns_of(count: int) -> int:
    """How many maps lie in a row of an atlas of ``count``: as many as in a column, or one more."""
    return math.isqrt(count - 1) + 1


def from_atlas(layers: list[Texels], size: tuple[int, int], count: int, slots: int) -> NDArray[np.uint8]:
    """Weight maps ``(N, h, w, R)`` out of the atlas images of every four slots; inverse of :func:`atlas`."""
    h, w = size
    columns = layers[0].shape[1] // w
    weights: NDArray[np.uint8] = memory.empty((count, h, w, slots), np.uint8)
    for n, place in enumerate(_places(count, size, columns)):
        weights[n] = np.concatenate([layer[place] for layer in layers], axis=2)[..., :slots]
        memory.ease()
    return weights


def _places(count: int, size: tuple[int, int], columns: int) -> Iterator[tuple[slice, slice]]:
    """The rows and columns of each weight map in an atlas."""
    h, w = size
    for n in range(count):
        row, column = divmod(n, columns)
        yield slice(row * h, (row + 1) * h), slice(column * w, (column + 1) * w)
