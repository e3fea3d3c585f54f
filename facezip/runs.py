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
    for i in range(slots):
        for n in range(count):
            line, target = row[i, n], out[i, n]
            for x in range(run):
                a, b = line[column0[left + x]], line[column1[left + x]]
                target[x] = a + column_f[left + x] * (b - a)


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
            above, below, mixed = upper[i, n], lower[i, n], out[i, n]
            for x in range(run):
                mixed[x] = above[x] + share * (below[x] - above[x])


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
            _dot(weight[i], weight[j], run, normal[i, j])
        for x in range(run):
            normal[i, i, x] += ridge
        for c in range(len(differences)):
            _dot(weight[i], differences[c], run, out[i, c])
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
def _dot(a: NDArray[np.float32], b: NDArray[np.float32], run: int, out: NDArray[np.float32]) -> None:
    """``out[x] = Σ_n a[n, x] b[n, x]``, several terms at a time so that the sum is read and written less often."""
    whole = len(a) - len(a) % 4
    for x in range(run):
        out[x] = 0
    for n in range(0, whole, 4):
        a0, a1, a2, a3, b0, b1, b2, b3 = a[n], a[n + 1], a[n + 2], a[n + 3], b[n], b[n + 1], b[n + 2], b[n + 3]
        for x in range(run):
            out[x] += a0[x] * b0[x] + a1[x] * b1[x] + a2[x] * b2[x] + a3[x] * b3[x]
    if len(a) - whole == 3:
        a0, a1, a2, b0, b1, b2 = a[whole], a[whole + 1], a[whole + 2], b[whole], b[whole + 1], b[whole + 2]
        for x in range(run):
            out[x] += a0[x] * b0[x] + a1[x] * b1[x] + a2[x] * b2[x]
        return
    for n in range(whole, len(a)):
        a0, b0 = a[n], b[n]
        for x in range(run):
            out[x] += a0[x] * b0[x]


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
    count = differences.shape[1]
    run = len(importance)
    gy = np.float32(1) - fy
    total = np.empty(run, np.float32)
    weighted = np.empty((channels, run), np.float32)
    pair = 0
    for i in range(slots):
        for c in range(channels):
            value, out = solved[i, c], weighted[c]
            for x in range(run):
                out[x] = value[x] * importance[x]
        for j in range(i + 1):
            total[:] = 0
            for c in range(channels):
                a, b = weighted[c], solved[j, c]
                for x in range(run):
                    total[x] += a[x] * b[x]
            above, across, below = squares[0, pair], squares[1, pair], squares[2, pair]
            for x in range(run):
                above[x] += gy * gy * total[x]
                across[x] += gy * fy * total[x]
                below[x] += fy * fy * total[x]
            pair += 1
        for n in range(count):
            above, below = products[0, i, n], products[1, i, n]
            if channels == 3:
                _add_products(weighted, differences[:, n], fy, run, above, below)
                continue
            total[:] = 0
            for c in range(channels):
                a, b = weighted[c], differences[c, n]
                for x in range(run):
                    total[x] += a[x] * b[x]
            for x in range(run):
                above[x] += gy * total[x]
                below[x] += fy * total[x]


@njit(cache=True, nogil=True, fastmath={"contract"})
def _add_products(
    a: NDArray[np.float32],
    b: NDArray[np.float32],
    fy: np.float32,
    run: int,
    above: NDArray[np.float32],
    below: NDArray[np.float32],
) -> None:
    """Three channels at a time: nearly all of an alternation is spent here."""
    a0, a1, a2, b0, b1, b2 = a[0], a[1], a[2], b[0], b[1], b[2]
    for x in range(run):
        total = a0[x] * b0[x] + a1[x] * b1[x] + a2[x] * b2[x]
        share = fy * total
        above[x] += total - share
        below[x] += share


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
