"""Smaller versions of the maps for distant heads: the mip-map of a blend is not the blend of mip-maps.

What a renderer wants of a distant texel is the mean of linear light over its area, of the blend. Averaging each map on
its own differs from that twice: the mean of a product D · W is not the product of the means, and a mean of encoded
values is not that of light. Nothing can be done about the first for good, since a texel holds four values and the
expressions are many; but the values that are best for all expressions together come from the same least squares that
fitted the pack, against the expressions' own mip-maps under the weights that the shader reads there.

Of a normal map the mean is that of slopes, as of a surface whose heights are averaged; of data it is that of values.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from facezip.export.fill import Fill
from facezip.export.sheets import Sheet
from facezip.files.srgb import decode_srgb, encode_srgb
from facezip.machine import memory
from facezip.machine.progress import track
from facezip.machine.rows import by_rows, write_rows
from facezip.pack.model import Part, blended_rows

# The finest step of 16 bits, in which the targets of the fit are kept.
WIDE = 65535


def level_sizes(size: tuple[int, int]) -> list[tuple[int, int]]:
    """Rows and columns of every level, halved and rounded down until one texel is left."""
    sizes = [size]
    while max(sizes[-1]) > 1:
        sizes.append((max(sizes[-1][0] // 2, 1), max(sizes[-1][1] // 2, 1)))
    return sizes


class Pyramid:
    """Means over the covered texels of each texel of each level: no texel outside the chart counts.

    Parameters
    ----------
    fill : of the finest level, which says what is covered.

    Attributes
    ----------
    sizes : rows and columns of the levels.
    shares : for each level ``(h, w)``, which part of a texel's area is covered.
    fills : for each level, what fills the rest.
    """

    def __init__(self, fill: Fill) -> None:
        height, width = fill.covered.shape
        self.sizes = level_sizes((height, width))
        self._steps = [
            (_means(above[0], below[0]), _means(above[1], below[1]))
            for above, below in zip(self.sizes, self.sizes[1:], strict=False)
        ]
        covered = by_rows(lambda rows: fill.covered[rows, :, None], (height, width, 1), np.float32)
        self.shares = [share[..., 0] for share in self._shrunk(covered)]
        self.fills = [fill, *(Fill(_some(share)) for share in self.shares[1:])]

    def levels(self, values: NDArray[np.float32]) -> Iterator[NDArray[np.float32]]:
        """The means of ``(H, W, C)`` values, finest level first; texels of no covered area are like their nearest."""
        covered = by_rows(lambda rows: values[rows] * (self.shares[0][rows] > 0)[..., None], values.shape, np.float32)
        for sums, share, fill in zip(self._shrunk(covered), self.shares, self.fills, strict=True):
            yield fill(_divided(sums, share))

    def light(self, values: NDArray[np.float32]) -> Iterator[NDArray[np.float32]]:
        """As :meth:`levels`, of encoded values whose light is averaged."""
        means = self.levels(by_rows(lambda rows: decode_srgb(values[rows]), values.shape, np.float32))
        next(means)
        yield self.fills[0](values)
        yield from map(_encoded, means)

    def looks(self, sheet: Sheet, values: NDArray[np.float32]) -> Iterator[NDArray[np.float32]]:
        """How a sheet's texels should look from afar: colours by their light; slopes and data by their means."""
        return self.light(values) if sheet.is_colour else self.levels(values)

    def _shrunk(self, values: NDArray[np.float32]) -> Iterator[NDArray[np.float32]]:
        yield values
        for down, across in self._steps:
            values = _shrunk(values, down, across)
            yield values


def targets(sheet: Sheet, part: Part, pyramid: Pyramid) -> list[NDArray[np.uint16]]:
    """Every expression as it should look at each level: ``(N, h, w, C)`` of 16 bits."""
    count, channels = len(sheet.expressions), part.neutral.shape[2]
    stacks = [memory.empty((count, *size, channels), np.uint16) for size in pyramid.sizes]
    for n in track(range(count), "Mip-maps", count):
        whole = by_rows(blended_rows(part, sheet.weights[n]), part.neutral.shape, np.float32)
        for stack, level in zip(stacks, pyramid.looks(sheet, whole), strict=True):
            write_rows(_wide(level).__getitem__, stack[n])
    return stacks


def _wide(values: NDArray[np.float32]) -> NDArray[np.uint16]:
    return by_rows(lambda rows: np.rint(values[rows] * WIDE), values.shape, np.uint16)


def _shrunk(values: NDArray[np.float32], down: csr_array, across: csr_array) -> NDArray[np.float32]:
    """Values ``(H, W, C)`` of the next level."""
    height, width, channels = values.shape
    flat = values.reshape(height, -1)

    def rows(some: slice) -> NDArray[Any]:
        fewer = (down[some] @ flat).reshape(-1, width, channels)
        turned = fewer.swapaxes(0, 1).reshape(width, -1)
        shrunk: NDArray[Any] = (across @ turned).reshape(across.shape[0], -1, channels).swapaxes(0, 1)
        return shrunk

    return by_rows(rows, (down.shape[0], across.shape[0], channels), np.float32)


def _some(share: NDArray[np.float32]) -> NDArray[np.bool_]:
    return by_rows(lambda rows: share[rows] > 0, share.shape, np.bool_)


def _divided(sums: NDArray[np.float32], share: NDArray[np.float32]) -> NDArray[np.float32]:
    def rows(some: slice) -> NDArray[Any]:
        return sums[some] / np.where(share[some] > 0, share[some], 1)[..., None]

    return by_rows(rows, sums.shape, np.float32)


def _encoded(linear: NDArray[np.float32]) -> NDArray[np.float32]:
    return by_rows(lambda rows: encode_srgb(linear[rows]), linear.shape, np.float32)


def _means(above: int, below: int) -> csr_array:
    """``(below, above)``: each of fewer texels as the mean over its own part of the row."""
    edges = np.linspace(0, above, below + 1)
    low, high = edges[:-1, None], edges[1:, None]
    # The few that a part can touch: all, for every part, would be an array as large as the texture.
    texel = np.floor(low) + np.arange(-(-above // below) + 1)
    overlap = np.clip(np.minimum(high, texel + 1) - np.maximum(low, texel), 0, None)
    shares = (overlap / (above / below)).astype(np.float32)
    touched = shares.nonzero()
    return csr_array((shares[touched], (touched[0], texel[touched].astype(np.intp))), shape=(below, above))
