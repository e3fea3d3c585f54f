"""A window of the weight maps' grid, with what its system needs, in a room that fits into a processor's cache."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from facezip.machine.kernels import inner
from facezip.machine.vectors import ABREAST, LANES, load, store, times

# Of a window, which is LANES columns wide.
ROWS = 8
# With a column of neighbours on each side.
WIDE = LANES + 2


class Window(NamedTuple):
    """A window's system, in the letters of :mod:`facezip.fit.conjugate_gradients`.

    Columns are innermost, and expressions a multiple of ABREAST.

    Attributes
    ----------
    a : ``(ROWS, R, R, 9, LANES)``.
    m : ``(ROWS, R, R, LANES)``, M⁻¹; zero where a weight stays as it is.
    r, ap, old : ``(ROWS, R, N, LANES)``; A·p gives its place to z, and b its own to r; old is what x was.
    x, p : ``(ROWS + 2, R, N, WIDE)``, with the neighbours.
    rz, factor : ``(N,)``, each expression has its own; the factor is pᵀ A·p, α or β.
    sums, own : ``(N, LANES)`` and ``(LANES,)``, room.
    """

    a: NDArray[np.float32]
    m: NDArray[np.float32]
    r: NDArray[np.float32]
    ap: NDArray[np.float32]
    x: NDArray[np.float32]
    p: NDArray[np.float32]
    rz: NDArray[np.float32]
    factor: NDArray[np.float32]
    sums: NDArray[np.float32]
    own: NDArray[np.float32]
    old: NDArray[np.float32]


@inner()
def no_window(slots: int, count: int) -> Window:
    """Room for one of so many expressions."""
    abreast = (count + ABREAST - 1) // ABREAST * ABREAST
    own, near = (ROWS, slots, abreast, LANES), (ROWS + 2, slots, abreast, WIDE)
    return Window(
        np.zeros((ROWS, slots, slots, 9, LANES), np.float32),
        np.zeros((ROWS, slots, slots, LANES), np.float32),
        np.zeros(own, np.float32),
        np.zeros(own, np.float32),
        np.zeros(near, np.float32),
        np.zeros(near, np.float32),
        np.zeros(abreast, np.float32),
        np.zeros(abreast, np.float32),
        np.zeros((abreast, LANES), np.float32),
        np.zeros(LANES, np.float32),
        np.zeros(own, np.float32),
    )


@inner()
def read(
    first: int,
    left: int,
    flat: tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]],
    shape: tuple[int, int, int, int],
    moving: NDArray[np.bool_],
    window: Window,
) -> None:
    """Fill a window, whose first row and column are given, all but its iteration.

    Parameters
    ----------
    flat : a system's matrix and right side, and weights as they are and as they were, each as one row of numbers.
    shape : ``(h, R, N, w)``, of weights.
    moving : ``(h, w)``, the texels whose weights may change.
    """
    (matrix, right, weights, before), (h, slots, count, w) = flat, shape
    a, m, r, x, own, old = window.a, window.m, window.r, window.x, window.own, window.old
    abreast, couplings, near = r.shape[2], a.reshape(-1), x.reshape(-1)
    own_right, own_old = r.reshape(-1), old.reshape(-1)
    if left == 0 or left + LANES >= w or first == 0 or first + ROWS >= h:
        # Nothing couples what lies beside the grid.
        a[:], r[:], x[:], old[:] = 0, 0, 0, 0
    for y in range(max(first - 1, 0), min(first + ROWS + 1, h)):
        for i in range(slots):
            for n in range(count):
                at = (((y - first + 1) * slots + i) * abreast + n) * WIDE
                _copy(weights, ((y * slots + i) * count + n) * w, left - 1, w, near, at)
                _copy(weights, ((y * slots + i) * count + n) * w, left + 1, w, near, at + 2)
    for y in range(first, min(first + ROWS, h)):
        row = y - first
        for cell in range(slots * slots * 9):
            _copy(
                matrix, (y * slots * slots * 9 + cell) * w, left, w, couplings, (row * slots * slots * 9 + cell) * LANES
            )
        for i in range(slots):
            for n in range(count):
                at = ((row * slots + i) * abreast + n) * LANES
                _copy(right, ((y * slots + i) * count + n) * w, left, w, own_right, at)
                _copy(before, ((y * slots + i) * count + n) * w, left, w, own_old, at)
    for row in range(ROWS):
        y = first + row
        for c in range(LANES):
            there = y < h and left + c < w and moving[y, left + c]
            own[c] = there
            for i in range(slots):
                for j in range(slots):
                    m[row, i, j, c] = a[row, i, j, 4, c] if there else np.float32(i == j)
        _invert(row, m)
        for at in range(row * slots * slots * LANES, (row + 1) * slots * slots * LANES, LANES):
            store(m, at, times(load(m, at), load(own, 0)))


@inner()
def _copy(source: NDArray[np.float32], at: int, left: int, w: int, out: NDArray[np.float32], to: int) -> None:
    """The columns from ``left`` on of a row that begins at number ``at``, as far as there are any."""
    if left >= 0 and left + LANES <= w:
        store(out, to, load(source, at + left))
        return
    for c in range(max(-left, 0), min(LANES, w - left)):
        out[to + c] = source[at + left + c]


@inner(fastmath={"contract"}, error_model="numpy")
def _invert(row: int, m: NDArray[np.float32]) -> None:
    """A row's matrices, by Gauss and Jordan: they are positive definite."""
    slots = m.shape[1]
    for k in range(slots):
        for x in range(LANES):
            m[row, k, k, x] = np.float32(1) / m[row, k, k, x]
        for i in range(slots):
            for x in range(LANES if i != k else 0):
                m[row, i, k, x] *= -m[row, k, k, x]
        for i in range(slots):
            for j in range(slots):
                for x in range(LANES if i != k and j != k else 0):
                    m[row, i, j, x] += m[row, i, k, x] * m[row, k, j, x]
        for j in range(slots):
            for x in range(LANES if j != k else 0):
                m[row, k, j, x] *= m[row, k, k, x]


@inner()
def write(
    first: int, left: int, shape: tuple[int, int, int, int], x: NDArray[np.float32], weights: NDArray[np.float32]
) -> None:
    """Put a window's x, whose first row and column are given, into weights of ``shape`` as one row of numbers."""
    h, slots, count, w = shape
    for y in range(first, min(first + ROWS, h)):
        row = y - first + 1
        for i in range(slots):
            for n in range(count):
                at = ((y * slots + i) * count + n) * w + left
                if left + LANES <= w:
                    store(weights, at, load(x, ((row * slots + i) * x.shape[2] + n) * WIDE + 1))
                else:
                    for c in range(w - left):
                        weights[at + c] = x[row, i, n, c + 1]
