"""The weight maps' equations solved in windows of the grid that fit into a processor's cache.

A window's texels are solved with those about it as they are, by conjugate gradients (Hestenes & Stiefel, Methods of
Conjugate Gradients for Solving Linear Systems, 1952) with a block Jacobi preconditioner M, as in Saad, Iterative
Methods for Sparse Linear Systems, 2nd edition, algorithm 9.1, whose letters these are: residual r = b - A x,
z = M⁻¹ r, direction p, step α, β. Windows are taken one after the other, each from what those before have left
(multiplicative Schwarz, Saad, section 14.3): first every second band of them, in any order, on any number of cores,
then the others.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from facezip.machine.kernels import inner, kernel
from facezip.machine.shuffles import totals
from facezip.machine.vectors import ABREAST, LANES, all_of, load, minus, plus_product, store, times

# Warm started: more steps would solve exactly what the next alternation changes again.
STEPS = 4
# Of a window, which is LANES columns wide.
ROWS = 8
# With a column of neighbours on each side.
WIDE = LANES + 2


class _Window(NamedTuple):
    """A window's system, in the letters of the module; columns innermost, expressions a multiple of ABREAST.

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
def _no_window(slots: int, count: int) -> _Window:
    abreast = (count + ABREAST - 1) // ABREAST * ABREAST
    own, near = (ROWS, slots, abreast, LANES), (ROWS + 2, slots, abreast, WIDE)
    return _Window(
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


@kernel()
def solve_bands(
    top: int,
    bottom: int,
    parity: int,
    matrix: NDArray[np.float32],
    right: NDArray[np.float32],
    moving: NDArray[np.bool_],
    weights: NDArray[np.float32],
    before: NDArray[np.float32],
    gains: NDArray[np.float32],
    along: NDArray[np.float32],
) -> None:
    """Solve, in place, the windows of every second band whose last row lies within ``top`` and ``bottom``.

    Parameters
    ----------
    parity : which bands, 0 or 1.
    matrix, right : the system (:class:`facezip.fit.weights.WeightSystem`).
    moving : ``(h, w)``, the texels whose weights may change.
    weights, before : ``(h, R, N, w)``, as they are, and as they were.
    gains : ``(h, w)``, for rᵀ M⁻¹ r of each that moves before it does: what its own equations alone would gain.
    along : ``(h, w)``, for rᵀ (weights - before).
    """
    h, slots, count, w = weights.shape
    window = _no_window(slots, count)
    flat = matrix.reshape(-1), right.reshape(-1), weights.reshape(-1), before.reshape(-1)
    for band in range((h + ROWS - 1) // ROWS):
        first = band * ROWS
        if band % 2 == parity and top <= min(first + ROWS, h) - 1 < bottom:
            for left in range(0, w, LANES):
                if moving[first : first + ROWS, left : left + LANES].any():
                    _read(first, left, flat, weights.shape, moving, window)
                    _residual(first, left, gains, along, window)
                    _iterate(window)
                    _write(first, left, weights.shape, window.x, flat[2])


@inner()
def _read(
    first: int,
    left: int,
    flat: tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]],
    shape: tuple[int, int, int, int],
    moving: NDArray[np.bool_],
    window: _Window,
) -> None:
    (matrix, right, weights, before), (h, slots, count, w) = flat, shape
    a, m, r, x, own, old = window.a, window.m, window.r, window.x, window.own, window.old
    abreast, couplings, near = r.shape[2], a.reshape(-1), x.reshape(-1)
    own_right, own_old = r.reshape(-1), old.reshape(-1)
    if left <= 0 or left + LANES >= w or first <= 0 or first + ROWS >= h:
        # Nothing couples what lies beside the grid.
        a[:], r[:], x[:], old[:] = 0, 0, 0, 0
    for y in range(max(first - 1, 0), min(first + ROWS + 1, h)):
        for i in range(slots):
            for n in range(count):
                at = (((y - first + 1) * slots + i) * abreast + n) * WIDE
                _copy(weights, ((y * slots + i) * count + n) * w, left - 1, w, near, at)
                _copy(weights, ((y * slots + i) * count + n) * w, left + 1, w, near, at + 2)
    for y in range(max(first, 0), min(first + ROWS, h)):
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
            there = 0 <= y < h and 0 <= left + c < w and moving[y, left + c]
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
def _residual(
    first: int,
    left: int,
    gains: NDArray[np.float32],
    along: NDArray[np.float32],
    window: _Window,
) -> None:
    """r = b - A x and z; what the window's texels would gain, and whether they came the right way."""
    _multiply(window.x, window)
    _, slots, abreast, _ = window.r.shape
    for row in range(ROWS):
        total = all_of(np.float32(0))
        for i in range(slots):
            for n in range(abreast):
                at = ((row * slots + i) * abreast + n) * LANES
                b, ax = load(window.r, at), load(window.ap, at)
                here = load(window.x, (((row + 1) * slots + i) * abreast + n) * WIDE + 1)
                rest = minus(b, ax)
                total = plus_product(total, rest, minus(here, load(window.old, at)))
                store(window.r, at, rest)
        _put(window.sums, total, first + row, left, along)
    _precondition(window)
    for row in range(ROWS):
        total = all_of(np.float32(0))
        for at in range(row * slots * abreast * LANES, (row + 1) * slots * abreast * LANES, LANES):
            total = plus_product(total, load(window.r, at), load(window.ap, at))
        _put(window.sums, total, first + row, left, gains)


@inner()
def _put(room: NDArray[np.float32], values: float, y: int, left: int, out: NDArray[np.float32]) -> None:
    """Sixteen numbers into a row of an image, as far as it goes."""
    store(room, 0, values)
    h, w = out.shape
    if 0 <= y < h:
        for column in range(max(left, 0), min(left + LANES, w)):
            out[y, column] = room[0, column - left]


@inner()
def _multiply(p: NDArray[np.float32], window: _Window) -> None:
    """A·p."""
    _, slots, abreast, _ = window.ap.shape
    for row in range(ROWS):
        for i in range(0, slots, 2):
            for n in range(0, abreast, ABREAST):
                _couple(row, i, min(i + 1, slots - 1), n, p, window.a, window.ap)


@inner()
def _couple(
    row: int, i: int, k: int, n: int, p: NDArray[np.float32], a: NDArray[np.float32], out: NDArray[np.float32]
) -> None:
    """What couples two slots of 16 texels to their neighbours, for four expressions from n on."""
    _, slots, abreast, _ = out.shape
    first = second = third = fourth = all_of(np.float32(0))
    other_first = other_second = other_third = other_fourth = first
    apart = (k - i) * slots * 9 * LANES
    for near in range(3):
        for j in range(slots):
            for beside in range(3):
                here = (((row * slots + i) * slots + j) * 9 + 3 * near + beside) * LANES
                factor, other = load(a, here), load(a, here + apart)
                at = (((row + near) * slots + j) * abreast + n) * WIDE + beside
                value = load(p, at)
                first, other_first = plus_product(first, factor, value), plus_product(other_first, other, value)
                value = load(p, at + WIDE)
                second, other_second = plus_product(second, factor, value), plus_product(other_second, other, value)
                value = load(p, at + 2 * WIDE)
                third, other_third = plus_product(third, factor, value), plus_product(other_third, other, value)
                value = load(p, at + 3 * WIDE)
                fourth, other_fourth = plus_product(fourth, factor, value), plus_product(other_fourth, other, value)
    _store(row, i, n, (first, second, third, fourth), out)
    _store(row, k, n, (other_first, other_second, other_third, other_fourth), out)


@inner()
def _store(row: int, i: int, n: int, values: tuple[float, float, float, float], out: NDArray[np.float32]) -> None:
    at = ((row * out.shape[1] + i) * out.shape[2] + n) * LANES
    store(out, at, values[0])
    store(out, at + LANES, values[1])
    store(out, at + 2 * LANES, values[2])
    store(out, at + 3 * LANES, values[3])


@inner()
def _precondition(window: _Window) -> None:
    """z = M⁻¹ r in the place of A·p, and rᵀ z."""
    _, m, r, z, _, _, rz, _, sums, _, _ = window
    _, slots, abreast, _ = r.shape
    sums[:] = 0
    for row in range(ROWS):
        for n in range(abreast):
            total = load(sums, n * LANES)
            for i in range(slots):
                found = all_of(np.float32(0))
                for j in range(slots):
                    factor = load(m, ((row * slots + i) * slots + j) * LANES)
                    found = plus_product(found, factor, load(r, ((row * slots + j) * abreast + n) * LANES))
                at = ((row * slots + i) * abreast + n) * LANES
                store(z, at, found)
                total = plus_product(total, found, load(r, at))
            store(sums, n * LANES, total)
    _total(sums, rz)


@inner()
def _total(sums: NDArray[np.float32], out: NDArray[np.float32]) -> None:
    for n in range(0, len(sums), ABREAST):
        at = n * LANES
        found = totals(load(sums, at), load(sums, at + LANES), load(sums, at + 2 * LANES), load(sums, at + 3 * LANES))
        out[n], out[n + 1], out[n + 2], out[n + 3] = found


@inner()
def _iterate(window: _Window) -> None:
    """Conjugate gradients, from z on."""
    rz, factor = window.rz, window.factor
    factor[:] = 0
    window.p[:] = 0
    for _ in range(STEPS):
        _turn(window)
        _multiply(window.p, window)
        _project(window)
        for n in range(len(rz)):
            factor[n] = rz[n] / factor[n] if factor[n] > 0 else np.float32(0)
        _advance(window)
        for n in range(len(rz)):
            factor[n] = rz[n]
        _precondition(window)
        for n in range(len(rz)):
            factor[n] = rz[n] / factor[n] if factor[n] > 0 else np.float32(0)


@inner()
def _turn(window: _Window) -> None:
    """``p = z + β p``."""
    _, _, _, z, _, p, _, beta, _, _, _ = window
    _, slots, abreast, _ = z.shape
    for row in range(ROWS):
        for i in range(slots):
            for n in range(abreast):
                at = ((row * slots + i) * abreast + n) * LANES
                here = (((row + 1) * slots + i) * abreast + n) * WIDE + 1
                store(p, here, plus_product(load(z, at), all_of(beta[n]), load(p, here)))


@inner()
def _project(window: _Window) -> None:
    """pᵀ A·p."""
    _, _, _, ap, _, p, _, pap, sums, _, _ = window
    _, slots, abreast, _ = ap.shape
    for n in range(abreast):
        total = all_of(np.float32(0))
        for row in range(ROWS):
            for i in range(slots):
                here = (((row + 1) * slots + i) * abreast + n) * WIDE + 1
                total = plus_product(total, load(p, here), load(ap, ((row * slots + i) * abreast + n) * LANES))
        store(sums, n * LANES, total)
    _total(sums, pap)


@inner()
def _advance(window: _Window) -> None:
    """``x += α p``, ``r -= α A·p``."""
    _, _, r, ap, x, p, _, alpha, _, _, _ = window
    _, slots, abreast, _ = r.shape
    for row in range(ROWS):
        for i in range(slots):
            for n in range(abreast):
                at = ((row * slots + i) * abreast + n) * LANES
                here = (((row + 1) * slots + i) * abreast + n) * WIDE + 1
                step = all_of(alpha[n])
                store(x, here, plus_product(load(x, here), step, load(p, here)))
                store(r, at, minus(load(r, at), times(step, load(ap, at))))


@inner()
def _write(
    first: int, left: int, shape: tuple[int, int, int, int], x: NDArray[np.float32], weights: NDArray[np.float32]
) -> None:
    h, slots, count, w = shape
    for y in range(max(first, 0), min(first + ROWS, h)):
        for i in range(slots):
            for n in range(count):
                at, here = (
                    ((y * slots + i) * count + n) * w + left,
                    (((y - first + 1) * slots + i) * x.shape[2] + n) * WIDE,
                )
                if left >= 0 and left + LANES <= w:
                    store(weights, at, load(x, here + 1))
                else:
                    for c in range(max(-left, 0), min(LANES, w - left)):
                        weights[at + c] = x[y - first + 1, i, n, c + 1]
