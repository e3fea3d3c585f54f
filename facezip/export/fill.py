"""Texels outside the UV chart become like their nearest neighbour inside, so that no filter brings background in."""

from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from facezip.character.raster import covered as on_chart
from facezip.files.obj import Topology
from facezip.machine import memory
from facezip.machine.kernels import kernel
from facezip.machine.rows import BLOCK, by_rows, map_rows

Kind = TypeVar("Kind", bound=np.generic)
NONE = -1


class Fill:
    """The nearest texel inside the chart, of every texel: Maurer's distance transform (2003), which is exact.

    Parameters
    ----------
    covered : ``(H, W)``, whether a texel is inside.
    """

    def __init__(self, covered: NDArray[np.bool_]) -> None:
        self.covered = covered
        whole = all(map_rows(lambda top, bottom: bool(covered[top:bottom].all()), len(covered)))
        self._nearest = None if whole else _nearest(covered)

    def __call__(self, texels: NDArray[Kind]) -> NDArray[Kind]:
        """Fill ``(H, W, C)`` texels; those inside stay as they are."""
        if self._nearest is None:
            return texels
        nearest, width = self._nearest, texels.shape[1]

        def rows(some: slice) -> NDArray[Any]:
            return texels[np.divmod(nearest[some], width)]

        return by_rows(rows, texels.shape, texels.dtype)


def _nearest(covered: NDArray[np.bool_]) -> NDArray[np.int32]:
    """``(H, W)``: row · W + column of the nearest covered texel; the first of those that are equally near."""
    height, width = covered.shape
    above: NDArray[np.int32] = memory.empty(covered.shape, np.int32)
    last = np.full(width, NONE, np.int32)
    for top in range(0, height, BLOCK):
        _downwards(top, covered[top : top + BLOCK], last, above[top : top + BLOCK])
        memory.ease()
    last[:] = NONE
    for top in reversed(range(0, height, BLOCK)):
        _upwards(top, covered[top : top + BLOCK], last, above[top : top + BLOCK])
        memory.ease()
    map_rows(lambda top, bottom: _across(top, above[top:bottom]), height)
    return above


@kernel()
def _downwards(top: int, covered: NDArray[np.bool_], last: NDArray[np.int32], nearest: NDArray[np.int32]) -> None:
    """In every column, the last covered row so far."""
    for y in range(len(covered)):
        for x in range(len(last)):
            if covered[y, x]:
                last[x] = top + y
            nearest[y, x] = last[x]


@kernel()
def _upwards(top: int, covered: NDArray[np.bool_], last: NDArray[np.int32], nearest: NDArray[np.int32]) -> None:
    """In every column, the nearer one of the last covered row and the next."""
    for y in range(len(covered) - 1, -1, -1):
        for x in range(len(last)):
            if covered[y, x]:
                last[x] = top + y
            row = top + y
            if last[x] != NONE and (nearest[y, x] == NONE or last[x] - row < row - nearest[y, x]):
                nearest[y, x] = last[x]


@kernel()
def _across(top: int, nearest: NDArray[np.int32]) -> None:
    """From the nearest covered row of every column to the nearest texel, along each row."""
    height, width = nearest.shape
    rows = np.empty(width, np.int64)
    site = np.empty(width, np.int64)
    for y in range(height):
        count = 0
        for x in range(width):
            rows[x] = nearest[y, x]
            if rows[x] == NONE:
                continue
            # A column that is nowhere nearer than those around it goes.
            while count > 1:
                a, b = site[count - 1] - site[count - 2], x - site[count - 1]
                far, middle, new = (
                    (rows[site[count - 2]] - top - y) ** 2,
                    (rows[site[count - 1]] - top - y) ** 2,
                    (rows[x] - top - y) ** 2,
                )
                if (a + b) * middle - b * far - a * new - a * b * (a + b) <= 0:
                    break
                count -= 1
            site[count] = x
            count += 1
        at = 0
        for x in range(width):
            near = (rows[site[at]] - top - y) ** 2 + (site[at] - x) ** 2
            while at + 1 < count:
                next_ = (rows[site[at + 1]] - top - y) ** 2 + (site[at + 1] - x) ** 2
                if near <= next_:
                    break
                near = next_
                at += 1
            nearest[y, x] = rows[site[at]] * width + site[at]


def shown(topology: Topology | None, size: tuple[int, int]) -> NDArray[np.bool_]:
    """The texels that the surface shows; all where no face lies on a tile."""
    chart = None if topology is None else on_chart(topology, size)
    if chart is not None and any(map_rows(lambda top, bottom: bool(chart[top:bottom].any()), len(chart))):
        return chart
    return by_rows(lambda _: np.ones(1, np.bool_), size, np.bool_)
