"""The weight maps' equations from the textures of a run of texels (:mod:`facezip.fit.sweep` says what they are).

The four shares of a texel in the weight texels about it are products of one along the row and one along the column. So
what lies between two rows of weight texels is summed first, column by column, and shared out to their equations once.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from facezip.fit.weights import WeightSystem
from facezip.machine.kernels import inner
from facezip.pack.sampling import RUN, Taps, end_of_cell


class Sums(NamedTuple):
    """Sums of a run over the rows of texels between two rows of weight texels; v is the share of the lower one.

    Attributes
    ----------
    squares : ``(3, R(R+1)/2, RUN)``, of m ⟨D_i, D_j⟩ for i ≥ j, times (1-v)², (1-v) v and v².
    products : ``(2, R, N, RUN)``, of m ⟨D_i, d_n⟩, times 1-v and v.
    """

    squares: NDArray[np.float32]
    products: NDArray[np.float32]


@inner(inline="always")
def no_sums(slots: int, count: int) -> Sums:
    """Sums of nothing, for R ``slots`` and N = ``count`` expressions."""
    pairs = slots * (slots + 1) // 2
    return Sums(np.zeros((3, pairs, RUN), np.float32), np.zeros((2, slots, count, RUN), np.float32))


@inner(inline="always")
def clear(sums: Sums) -> None:
    """Begin again."""
    sums.squares[:] = 0
    sums.products[:] = 0


@inner(fastmath={"contract"})
def accumulate_run(
    solved: NDArray[np.float32],
    differences: NDArray[np.float32],
    importance: NDArray[np.float32],
    v: np.float32,
    sums: Sums,
) -> None:
    """Add one row of a run: ``solved`` ``(R, C, RUN)``, ``differences`` ``(C, N, RUN)``, ``importance`` ``(run,)``."""
    slots, channels, _ = solved.shape
    run = len(importance)
    squares, near = sums.squares, np.float32(1) - v
    total = np.empty(run, np.float32)
    weighted = np.empty((slots, channels, run), np.float32)
    pair = 0
    for i in range(slots):
        for c in range(channels):
            for x in range(run):
                weighted[i, c, x] = solved[i, c, x] * importance[x]
        for j in range(i + 1):
            total[:] = 0
            for c in range(channels):
                for x in range(run):
                    total[x] += weighted[i, c, x] * solved[j, c, x]
            for x in range(run):
                squares[0, pair, x] += near * near * total[x]
                squares[1, pair, x] += near * v * total[x]
                squares[2, pair, x] += v * v * total[x]
            pair += 1
    if channels == 3:
        _add_products(weighted, differences, v, run, sums.products)
    else:
        _add_any_products(weighted, differences, v, run, sums.products)


@inner(fastmath={"contract"})
def _add_products(
    weighted: NDArray[np.float32],
    differences: NDArray[np.float32],
    v: np.float32,
    run: int,
    products: NDArray[np.float32],
) -> None:
    """Three channels at a time: a good part of an alternation is spent here."""
    for i in range(len(weighted)):
        for n in range(differences.shape[1]):
            for x in range(run):
                total = (
                    weighted[i, 0, x] * differences[0, n, x]
                    + weighted[i, 1, x] * differences[1, n, x]
                    + weighted[i, 2, x] * differences[2, n, x]
                )
                lower = v * total
                products[0, i, n, x] += total - lower
                products[1, i, n, x] += lower


@inner(fastmath={"contract"})
def _add_any_products(
    weighted: NDArray[np.float32],
    differences: NDArray[np.float32],
    v: np.float32,
    run: int,
    products: NDArray[np.float32],
) -> None:
    """As :func:`_add_products`, of any number of channels: one after the other, each sum kept beside."""
    total = np.empty(run, np.float32)
    for i in range(len(weighted)):
        for n in range(differences.shape[1]):
            total[:] = 0
            for c in range(weighted.shape[1]):
                for x in range(run):
                    total[x] += weighted[i, c, x] * differences[c, n, x]
            for x in range(run):
                lower = v * total[x]
                products[0, i, n, x] += total[x] - lower
                products[1, i, n, x] += lower


@inner()
def collect_run(sums: Sums, rows: tuple[int, int], columns: Taps, left: int, run: int, system: WeightSystem) -> None:
    """Share the sums of a run out to the equations of the weight texels that it samples, in two ``rows``."""
    begin = left
    while begin < left + run:
        end = end_of_cell(columns, begin, left + run)
        between = columns.first[begin], columns.second[begin]
        u = columns.fraction[begin:end]
        _collect_products(sums.products, begin - left, u, rows, between, system.right)
        _collect_squares(sums.squares, begin - left, u, rows, between, system.matrix)
        begin = end


@inner()
def _collect_products(
    products: NDArray[np.float32],
    begin: int,
    u: NDArray[np.float32],
    rows: tuple[int, int],
    columns: tuple[int, int],
    right: NDArray[np.float32],
) -> None:
    for a in range(2):
        for i in range(products.shape[1]):
            for n in range(products.shape[2]):
                near, far = _moments(products[a, i, n, begin : begin + len(u)], u)
                right[rows[a], i, n, columns[0]] += near
                right[rows[a], i, n, columns[1]] += far


@inner()
def _collect_squares(
    squares: NDArray[np.float32],
    begin: int,
    u: NDArray[np.float32],
    rows: tuple[int, int],
    columns: tuple[int, int],
    matrix: NDArray[np.float32],
) -> None:
    slots = matrix.shape[1]
    for a in range(2):
        for b in range(2):
            pair = 0
            for i in range(slots):
                for j in range(i + 1):
                    moments = _square_moments(squares[a + b, pair, begin : begin + len(u)], u)
                    for s in range(2):
                        for t in range(2):
                            neighbour = 3 * (rows[b] - rows[a] + 1) + columns[t] - columns[s] + 1
                            matrix[rows[a], i, j, neighbour, columns[s]] += moments[s + t]
                            if i != j:
                                matrix[rows[a], j, i, neighbour, columns[s]] += moments[s + t]
                    pair += 1


@inner(fastmath={"contract", "reassoc"})
def _moments(values: NDArray[np.float32], u: NDArray[np.float32]) -> tuple[np.float32, np.float32]:
    """Sums of ``(1 - u) · values`` and ``u · values``."""
    total, far = np.float32(0), np.float32(0)
    for x in range(len(u)):
        total += values[x]
        far += u[x] * values[x]
    return total - far, far


@inner(fastmath={"contract", "reassoc"})
def _square_moments(values: NDArray[np.float32], u: NDArray[np.float32]) -> tuple[np.float32, np.float32, np.float32]:
    """Sums of ``(1 - u)² · values``, ``u (1 - u) · values`` and ``u² · values``."""
    total, far, both = np.float32(0), np.float32(0), np.float32(0)
    for x in range(len(u)):
        total += values[x]
        far += u[x] * values[x]
        both += u[x] * u[x] * values[x]
    near = total - far
    return near - far + both, far - both, both
