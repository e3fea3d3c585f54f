"""Work over the rows of a texture on all cores, with results that do not depend on how many cores there are."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from facezip.cores import cores

Result = TypeVar("Result")

# Fixed, so that sums over blocks are taken in the same order on every machine.
BLOCK = 32


def map_rows(work: Callable[[int, int], Result], height: int) -> list[Result]:
    """Call ``work(first_row, last_row)`` for every block of rows, in threads; results in the order of the rows.

    ``work`` should spend its time in compiled code that releases the interpreter lock.
    """
    blocks = [(top, min(top + BLOCK, height)) for top in range(0, height, BLOCK)]
    with ThreadPoolExecutor(cores()) as pool:
        return list(pool.map(lambda block: work(*block), blocks))


def sum_rows(work: Callable[[int, int], NDArray[np.float64]], height: int) -> NDArray[np.float64]:
    """The sum of ``work(first_row, last_row)`` over all blocks of rows, always in the same order."""
    total, *rest = map_rows(work, height)
    for part in rest:
        total += part
    return total
