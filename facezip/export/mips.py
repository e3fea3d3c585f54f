"""Smaller versions of the maps for distant heads: the mip-map of a blend is not the blend of mip-maps.

What a renderer wants of a distant texel is the mean of linear light over its area, of the blend. Averaging each map on
its own differs from that twice: the mean of a product D · W is not the product of the means, and a mean of encoded
values is not that of light. Nothing can be done about the first for good, since a texel holds four values and the
expressions are many; but the values that are best for all expressions together come from the same least squares that
fitted the pack, against the expressions' own mip-maps under the weights that the shader reads there.

Of a normal map the mean is that of slopes, as of a surface whose heights are averaged; of data it is that of values.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from facezip.export.sheets import Fill, Sheet
from facezip.files.srgb import decode_srgb, encode_srgb
from facezip.machine.progress import track

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

    Attributes
    ----------
    sizes : rows and columns of the levels.
    shares : for each level ``(h, w)``, which part of a texel's area is covered.
    fills : for each level, what fills the rest.
    """

    def __init__(self, covered: NDArray[np.bool_]) -> None:
        height, width = covered.shape
        self.sizes = level_sizes((height, width))
        self._steps = [
            (_means(above[0], below[0]), _means(above[1], below[1]))
            for above, below in zip(self.sizes, self.sizes[1:], strict=False)
        ]
        self.shares = [share[..., 0] for share in self._shrunk(covered.astype(np.float32)[..., None])]
        self.fills = [Fill(share > 0) for share in self.shares]

    def levels(self, values: NDArray[np.float32]) -> Iterator[NDArray[np.float32]]:
        """The means of ``(H, W, C)`` values, finest level first; texels of no covered area are like their nearest."""
        covered = values * (self.shares[0] > 0)[..., None]
        for sums, share, fill in zip(self._shrunk(covered), self.shares, self.fills, strict=True):
            yield fill((sums / np.where(share > 0, share, 1)[..., None]).astype(np.float32))

    def light(self, values: NDArray[np.float32]) -> Iterator[NDArray[np.float32]]:
        """As :meth:`levels`, of encoded values whose light is averaged."""
        means = self.levels(decode_srgb(values))
        next(means)
        yield self.fills[0](values)
        yield from map(encode_srgb, means)

    def looks(self, sheet: Sheet, values: NDArray[np.float32]) -> Iterator[NDArray[np.float32]]:
        """How a sheet's fitted texels should look from afar: colours by their light; slopes and data by their means."""
        return self.light(values) if sheet.is_colour else self.levels(values)

    def _shrunk(self, values: NDArray[np.float32]) -> Iterator[NDArray[np.float32]]:
        yield values
        for rows, columns in self._steps:
            height, _, channels = values.shape
            fewer = (rows @ values.reshape(height, -1)).reshape(rows.shape[0], -1, channels)
            turned = fewer.swapaxes(0, 1).reshape(fewer.shape[1], -1)
            values = (columns @ turned).reshape(columns.shape[0], -1, channels).swapaxes(0, 1)
            yield values


def targets(sheet: Sheet, pyramid: Pyramid) -> list[NDArray[np.uint16]]:
    """Every expression as it should look at each level: ``(N, h, w, C)`` of 16 bits."""
    names, channels = sheet.model.expressions, sheet.model.neutral.shape[2]
    stacks = [np.empty((len(names), *size, channels), np.uint16) for size in pyramid.sizes]
    for n, name in enumerate(track(names, "Mip-maps", len(names))):
        for stack, level in zip(stacks, pyramid.looks(sheet, sheet.model.reconstruct(name)), strict=True):
            stack[n] = np.rint(level * WIDE)
    return stacks


def _means(above: int, below: int) -> csr_array:
    """``(below, above)``: each of fewer texels as the mean over its own part of the row."""
    edges = np.linspace(0, above, below + 1)
    low, high = edges[:-1, None], edges[1:, None]
    texel = np.arange(above)
    overlap = np.clip(np.minimum(high, texel + 1) - np.maximum(low, texel), 0, None)
    return csr_array((overlap / (above / below)).astype(np.float32))
