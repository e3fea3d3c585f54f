"""Work over the rows of a texture on all cores, with results that do not depend on how many cores there are."""

from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from itertools import islice
from typing import Any, TypeVar

import numpy as np
from numpy.typing import DTypeLike, NDArray

from facezip.machine import memory
from facezip.machine.cores import cores

Result = TypeVar("Result")

# Fixed, so that sums over blocks are taken in the same order on every machine.
BLOCK = 32


def each_block(work: Callable[[int, int], Result], height: int) -> Iterator[Result]:
    """Call ``work(first_row, last_row)`` for every block of rows, in threads; results in the order of the rows.

    ``work`` should spend its time in compiled code that releases the interpreter lock. Few results wait at a time.
    """

    def block(top: int) -> Result:
        result = work(top, min(top + BLOCK, height))
        memory.ease()
        return result

    if 0 < height <= BLOCK:
        # No threads for one: what works on a few rows is often within a block of others.
        yield block(0)
        return
    threads, tops = cores(), iter(range(0, height, BLOCK))
    with ThreadPoolExecutor(threads) as pool:
        waiting = deque(pool.submit(block, top) for top in islice(tops, 2 * threads))
        while waiting:
            yield waiting.popleft().result()
            waiting.extend(pool.submit(block, top) for top in islice(tops, 1))


def map_rows(work: Callable[[int, int], Result], height: int) -> list[Result]:
    """The results of :func:`each_block`, all of them."""
    return list(each_block(work, height))


def sum_rows(work: Callable[[int, int], NDArray[np.float64]], height: int) -> NDArray[np.float64]:
    """The sum of ``work(first_row, last_row)`` over all blocks of rows, always in the same order."""
    blocks = each_block(work, height)
    total = next(blocks)
    for part in blocks:
        total += part
    return total


def by_rows(
    values: Callable[[slice], NDArray[Any]], shape: tuple[int, ...], dtype: DTypeLike, axis: int = 0
) -> NDArray[Any]:
    """An array whose rows are ``values(rows)``, a block of them at a time; rows lie along ``axis``."""
    out = memory.empty(shape, dtype)
    write_rows(values, out, axis)
    return out


def write_rows(values: Callable[[slice], NDArray[Any]], out: NDArray[Any], axis: int = 0) -> None:
    """As :func:`by_rows`, into an array that is there."""
    before = (slice(None),) * axis

    def block(top: int, bottom: int) -> None:
        rows = slice(top, bottom)
        out[(*before, rows)] = values(rows)

    map_rows(block, out.shape[axis])
