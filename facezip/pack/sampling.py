"""How a GPU samples weight maps: bilinearly, with clamped borders."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from facezip.machine.kernels import inner


class Taps(NamedTuple):
    """Where a sampler looks along one axis, for each of ``size`` texel centres.

    Attributes
    ----------
    first, second : ``(size,)`` int64, indices of the two neighbours among the samples; alike at a border.
    fraction : ``(size,)`` float32 in [0, 1], the share of ``second``.
    """

    first: NDArray[np.int64]
    second: NDArray[np.int64]
    fraction: NDArray[np.float32]


class Grid(NamedTuple):
    """Where the texels ``(H, W)`` of a texture look in weight maps ``(h, w)``.

    Attributes
    ----------
    rows : taps of the H rows, in h.
    columns : taps of the W columns, in w.
    """

    rows: Taps
    columns: Taps


def bilinear_taps(size: int, low: int) -> Taps:
    """Where a GPU sampler with clamped borders looks in ``low`` texels for each of ``size`` texel centres."""
    position = np.clip((np.arange(size) + 0.5) * (low / size) - 0.5, 0, low - 1)
    first = np.floor(position).astype(np.int64)
    return Taps(first, np.minimum(first + 1, low - 1), (position - first).astype(np.float32))


def bilinear_grid(size: tuple[int, int], low: tuple[int, int]) -> Grid:
    """The taps of both axes, for a texture of ``size`` ``(H, W)`` and weight maps of ``low`` ``(h, w)``."""
    return Grid(bilinear_taps(size[0], low[0]), bilinear_taps(size[1], low[1]))


@inner(inline="always")
def same_rows(rows: Taps, y: int, other: int) -> bool:
    """Whether two rows of texels lie between the same two rows of weight texels."""
    return rows.first[y] == rows.first[other] and rows.second[y] == rows.second[other]


@inner()
def rows_between(first: NDArray[np.int64], second: NDArray[np.int64], y: int, bottom: int) -> int:
    """Where the rows of texels from y on end, before ``bottom``, that have the same taps ``first`` and ``second``."""
    end = y + 1
    while end < bottom and first[end] == first[y] and second[end] == second[y]:
        end += 1
    return end
