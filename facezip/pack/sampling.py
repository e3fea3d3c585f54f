"""How a GPU samples weight maps: bilinearly, with clamped borders; and kernels that do so over runs of texels.

Fits and measurements walk a texture in runs along a row, one value of a run beside the other, so that every innermost
loop has a few arrays to walk and fills vector registers. A run is short enough for what it needs to stay in the
second-level cache.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from facezip.character.samples import Stored
from facezip.machine.kernels import inner

RUN = 128


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


@inner(inline="always")
def end_of_cell(columns: Taps, begin: int, end: int) -> int:
    """The first column after ``begin`` and before ``end`` that lies between two other columns of weight texels."""
    x = begin + 1
    while x < end and columns.first[x] == columns.first[begin] and columns.second[x] == columns.second[begin]:
        x += 1
    return x


@inner()
def expand_row(weights: NDArray[np.float32], columns: Taps, left: int, run: int, out: NDArray[np.float32]) -> None:
    """Sample one row of weight texels ``(R, N, w)`` at the columns of a run: ``(R, N, RUN)``."""
    slots, count, _ = out.shape
    begin = left
    while begin < left + run:
        end = end_of_cell(columns, begin, left + run)
        first, second = columns.first[begin], columns.second[begin]
        for i in range(slots):
            for n in range(count):
                near, slope = weights[i, n, first], weights[i, n, second] - weights[i, n, first]
                for x in range(begin, end):
                    out[i, n, x - left] = near + columns.fraction[x] * slope
        begin = end


@inner()
def expand_rows(
    weights: NDArray[np.float32],
    grid: Grid,
    y: int,
    top: int,
    left: int,
    run: int,
    upper: NDArray[np.float32],
    lower: NDArray[np.float32],
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """The rows of weight texels above and below row ``y`` of a texture, by :func:`expand_row`.

    ``upper`` and ``lower`` hold those of row ``y - 1`` where that is not above ``top``: they are used again where they
    serve, and may come back the other way round.
    """
    rows = grid.rows
    if y > top and same_rows(rows, y, y - 1):
        return upper, lower
    if y > top and rows.first[y] == rows.second[y - 1]:
        upper, lower = lower, upper
    else:
        expand_row(weights[rows.first[y]], grid.columns, left, run, upper)
    expand_row(weights[rows.second[y]], grid.columns, left, run, lower)
    return upper, lower


@inner(fastmath={"contract"})
def mix_rows(
    upper: NDArray[np.float32], lower: NDArray[np.float32], fraction: np.float32, run: int, out: NDArray[np.float32]
) -> None:
    """Weights ``(R, N, RUN)`` of a run from the rows of weight texels above and below, ``fraction`` of the lower."""
    for i in range(len(out)):
        for n in range(out.shape[1]):
            for x in range(run):
                out[i, n, x] = upper[i, n, x] + fraction * (lower[i, n, x] - upper[i, n, x])


@inner()
def read_run(stored: Stored, y: int, left: int, run: int, out: NDArray[np.float32]) -> None:
    """D_n = I_n - I_0 of a run, ``(C, N, RUN)``; the texels must lie row by row."""
    channels, count, _ = out.shape
    begin, end = channels * left, channels * (left + run)
    neutral = stored.neutral[y].reshape(-1)[begin:end]
    # Converted as it lies, then spread to the channels with a stride known to the compiler: twice as fast.
    flat = np.empty(end - begin, np.float32)
    for n in range(count):
        texture = stored.textures[n, y].reshape(-1)[begin:end]
        for k in range(end - begin):
            flat[k] = stored.scale * (np.float32(texture[k]) - np.float32(neutral[k]))
        if channels == 3:
            red, green, blue = out[0, n], out[1, n], out[2, n]
            for x in range(run):
                red[x], green[x], blue[x] = flat[3 * x], flat[3 * x + 1], flat[3 * x + 2]
        else:
            for c in range(channels):
                for x in range(run):
                    out[c, n, x] = flat[channels * x + c]
