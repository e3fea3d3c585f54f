"""Kernels over a run of texels along a row, one value of the run beside the other.

Every innermost loop walks the run with at most a few arrays, so that compilers fill vector registers with it. A run is
short enough for what it needs to stay in the second-level cache.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

RUN = 128


@njit(cache=True, nogil=True)
def expand_row(
    row: NDArray[np.float32],
    column0: NDArray[np.int64],
    column1: NDArray[np.int64],
    column_f: NDArray[np.float32],
    left: int,
    run: int,
    out: NDArray[np.float32],
) -> None:
    """Sample one row of weight texels ``(R, N, w)`` at the columns of a run: ``(R, N, RUN)``."""
    slots, count, _ = out.shape
    x = 0
    while x < run:
        # Texels between the same two columns of weight texels.
        a, b = column0[left + x], column1[left + x]
        end = x + 1
        while end < run and column0[left + end] == a and column1[left + end] == b:
            end += 1
        for i in range(slots):
            for n in range(count):
                near, slope = row[i, n, a], row[i, n, b] - row[i, n, a]
                for k in range(x, end):
                    out[i, n, k] = near + column_f[left + k] * slope
        x = end


@njit(cache=True, nogil=True)
def read_run(
    stored: NDArray[np.uint8],
    neutral: NDArray[np.uint8],
    scale: np.float32,
    y: int,
    left: int,
    run: int,
    out: NDArray[np.float32],
) -> None:
    """D_n = I_n - I_0 of a run, ``(C, N, RUN)``."""
    channels, count, _ = out.shape
    begin, end = channels * left, channels * (left + run)
    base = neutral[y].reshape(-1)[begin:end]
    # Converted as it lies, then spread to the channels with a stride known to the compiler: twice as fast.
    flat = np.empty(end - begin, np.float32)
    for n in range(count):
        line = stored[n, y].reshape(-1)[begin:end]
        for k in range(end - begin):
            flat[k] = scale * (np.float32(line[k]) - np.float32(base[k]))
        if channels == 3:
            red, green, blue = out[0, n], out[1, n], out[2, n]
            for x in range(run):
                red[x], green[x], blue[x] = flat[3 * x], flat[3 * x + 1], flat[3 * x + 2]
        else:
            for c in range(channels):
                for x in range(run):
                    out[c, n, x] = flat[channels * x + c]


@njit(cache=True, nogil=True, fastmath={"contract"})
def mix_rows(
    upper: NDArray[np.float32], lower: NDArray[np.float32], share: np.float32, run: int, out: NDArray[np.float32]
) -> None:
    """Weights ``(R, N, RUN)`` of a run from the rows of weight texels above and below; ``share`` is the lower one's."""
    for i in range(len(out)):
        for n in range(out.shape[1]):
            for x in range(run):
                out[i, n, x] = upper[i, n, x] + share * (lower[i, n, x] - upper[i, n, x])


@njit(cache=True, nogil=True, fastmath={"contract"})
def solve_run(
    weight: NDArray[np.float32],
    differences: NDArray[np.float32],
    ridge: np.float32,
    steps: NDArray[np.float32],
    run: int,
    normal: NDArray[np.float32],
    out: NDArray[np.float32],
) -> None:
    """Least squares ``Σ_i weight[i, n] · out[i, c] = differences[c, n]`` over n for every texel of a run.

    ``out`` is ``(R, C, RUN)``; where there are ``steps`` ``(R, C)`` its values are multiples of them within ±127.
    """
    factor_run(weight, differences, ridge, run, normal, out)
    for i in range(len(weight) - 1, -1, -1):
        substitute_run(i, normal, run, out)
        # Rounded before those that follow are solved, so that they make up for it (Babai's nearest plane).
        if len(steps):
            for c in range(out.shape[1]):
                _round(steps[i, c], run, out[i, c])


@njit(cache=True, nogil=True, fastmath={"contract"})
def factor_run(
    weight: NDArray[np.float32],
    differences: NDArray[np.float32],
    ridge: np.float32,
    run: int,
    normal: NDArray[np.float32],
    out: NDArray[np.float32],
) -> None:
    """The first half of :func:`solve_run`: every texel's Cholesky factor, and ``out`` ready for substitution."""
    slots = len(weight)
    for i in range(slots):
        for j in range(i + 1):
            _dot(weight, i, weight, j, run, normal)
        for x in range(run):
            normal[i, i, x] += ridge
        for c in range(len(differences)):
            _dot(weight, i, differences, c, run, out)
    for i in range(slots):
        _eliminate(i, ridge, run, normal, out)


@njit(cache=True, nogil=True, fastmath={"contract"})
def substitute_run(i: int, normal: NDArray[np.float32], run: int, out: NDArray[np.float32]) -> None:
    """The best ``out[i]`` given all ``out[k]`` of k > i, the rest of them free."""
    for c in range(out.shape[1]):
        for k in range(i + 1, len(out)):
            _subtract(normal[k, i], out[k, c], run, out[i, c])
        _scale(normal[i, i], run, out[i, c])


@njit(cache=True, nogil=True, fastmath={"contract"}, error_model="numpy")
def _eliminate(i: int, ridge: np.float32, run: int, normal: NDArray[np.float32], out: NDArray[np.float32]) -> None:
    """Row i of the Cholesky factor in place, with the reciprocal on its diagonal, and forward substitution."""
    diagonal = normal[i, i]
    for j in range(i):
        for k in range(j):
            _subtract(normal[i, k], normal[j, k], run, normal[i, j])
        _scale(normal[j, j], run, normal[i, j])
        _subtract(normal[i, j], normal[i, j], run, diagonal)
    for x in range(run):
        diagonal[x] = np.float32(1) / np.sqrt(max(diagonal[x], ridge))
    for c in range(out.shape[1]):
        for k in range(i):
            _subtract(normal[i, k], out[k, c], run, out[i, c])
        _scale(diagonal, run, out[i, c])


@njit(cache=True, nogil=True, error_model="numpy")
def _round(step: np.float32, run: int, values: NDArray[np.float32]) -> None:
    per_step = np.float32(1) / step
    for x in range(run):
        values[x] = step * min(max(np.rint(values[x] * per_step), np.float32(-127)), np.float32(127))


@njit(cache=True, nogil=True)
def _scale(factor: NDArray[np.float32], run: int, values: NDArray[np.float32]) -> None:
    for x in range(run):
        values[x] *= factor[x]


@njit(cache=True, nogil=True, fastmath={"contract"})
def _dot(a: NDArray[np.float32], i: int, b: NDArray[np.float32], j: int, run: int, out: NDArray[np.float32]) -> None:
    """``out[i, j, x] = Σ_n a[i, n, x] b[j, n, x]``, four terms at a time: the sum is read and written less often."""
    count = a.shape[1]
    whole = count - count % 4
    for x in range(run):
        out[i, j, x] = 0
    for n in range(0, whole, 4):
        for x in range(run):
            out[i, j, x] += (
                a[i, n, x] * b[j, n, x]
                + a[i, n + 1, x] * b[j, n + 1, x]
                + a[i, n + 2, x] * b[j, n + 2, x]
                + a[i, n + 3, x] * b[j, n + 3, x]
            )
    for n in range(whole, count):
        for x in range(run):
            out[i, j, x] += a[i, n, x] * b[j, n, x]


@njit(cache=True, nogil=True, fastmath={"contract"})
def _subtract(a: NDArray[np.float32], b: NDArray[np.float32], run: int, out: NDArray[np.float32]) -> None:
    for x in range(run):
        out[x] -= a[x] * b[x]


@njit(cache=True, nogil=True, fastmath={"contract"})
def accumulate_run(
    solved: NDArray[np.float32],
    differences: NDArray[np.float32],
    importance: NDArray[np.float32],
    fy: np.float32,
    squares: NDArray[np.float32],
    products: NDArray[np.float32],
) -> None:
    """Add a run to the sums over the rows that lie between two rows of weight texels."""
    slots, channels, _ = solved.shape
    run = len(importance)
    gy = np.float32(1) - fy
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
                squares[0, pair, x] += gy * gy * total[x]
                squares[1, pair, x] += gy * fy * total[x]
                squares[2, pair, x] += fy * fy * total[x]
            pair += 1
    if channels == 3:
        _add_products(weighted, differences, fy, run, products)
    else:
        _add_any_products(weighted, differences, fy, run, products)


@njit(cache=True, nogil=True, fastmath={"contract"})
def _add_products(
    weighted: NDArray[np.float32],
    differences: NDArray[np.float32],
    fy: np.float32,
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
                share = fy * total
                products[0, i, n, x] += total - share
                products[1, i, n, x] += share


@njit(cache=True, nogil=True, fastmath={"contract"})
def _add_any_products(
    weighted: NDArray[np.float32],
    differences: NDArray[np.float32],
    fy: np.float32,
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
                share = fy * total[x]
                products[0, i, n, x] += total[x] - share
                products[1, i, n, x] += share


@njit(cache=True, nogil=True)
def collect_run(
    squares: NDArray[np.float32],
    products: NDArray[np.float32],
    at: tuple[int, int],
    column0: NDArray[np.int64],
    column1: NDArray[np.int64],
    column_f: NDArray[np.float32],
    left: int,
    run: int,
    matrix: NDArray[np.float32],
    right: NDArray[np.float32],
) -> None:
    """Add the sums of a run to the equations of the weight texels that it samples."""
    _, slots, count, _ = products.shape
    x = 0
    while x < run:
        # Texels between the same two columns of weight texels.
        left_column, right_column = column0[left + x], column1[left + x]
        end = x + 1
        while end < run and column0[left + end] == left_column and column1[left + end] == right_column:
            end += 1
        f = column_f[left + x : left + end]
        for a in range(2):
            for i in range(slots):
                for n in range(count):
                    near, far = _moments(products[a, i, n, x:end], f)
                    right[at[a], i, n, left_column] += near
                    right[at[a], i, n, right_column] += far
        for a in range(2):
            for b in range(2):
                row, dy = at[a], at[b] - at[a]
                pair = 0
                for i in range(slots):
                    for j in range(i + 1):
                        sums = _square_moments(squares[a + b, pair, x:end], f)
                        for s in range(2):
                            for t in range(2):
                                column, other = (left_column, right_column)[s], (left_column, right_column)[t]
                                cell = 3 * (dy + 1) + other - column + 1
                                matrix[row, i, j, cell, column] += sums[s + t]
                                if i != j:
                                    matrix[row, j, i, cell, column] += sums[s + t]
                        pair += 1
        x = end


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc"})
def _moments(values: NDArray[np.float32], f: NDArray[np.float32]) -> tuple[np.float32, np.float32]:
    """Sums of ``(1 - f) · values`` and ``f · values``."""
    total, far = np.float32(0), np.float32(0)
    for x in range(len(f)):
        total += values[x]
        far += f[x] * values[x]
    return total - far, far


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc"})
def _square_moments(values: NDArray[np.float32], f: NDArray[np.float32]) -> tuple[np.float32, np.float32, np.float32]:
    """Sums of ``(1 - f)² · values``, ``f (1 - f) · values`` and ``f² · values``."""
    total, far, both = np.float32(0), np.float32(0), np.float32(0)
    for x in range(len(f)):
        total += values[x]
        far += f[x] * values[x]
        both += f[x] * f[x] * values[x]
    near = total - far
    return near - far + both, far - both, both
