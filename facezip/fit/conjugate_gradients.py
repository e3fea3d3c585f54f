"""Conjugate gradients in a window of the weight maps' grid.

Hestenes & Stiefel, Methods of Conjugate Gradients for Solving Linear Systems, 1952, with a block Jacobi preconditioner
M, as in Saad, Iterative Methods for Sparse Linear Systems, 2nd edition, algorithm 9.1, whose letters these are:
residual r = b - A x, z = M⁻¹ r, direction p, step α, β.
"""

import numpy as np
from numpy.typing import NDArray

from facezip.fit.window import ROWS, WIDE, Window
from facezip.machine.kernels import inner
from facezip.machine.shuffles import totals
from facezip.machine.vectors import ABREAST, LANES, all_of, load, minus, plus_product, store, times

# Warm started: more steps would solve exactly what the next alternation changes again.
STEPS = 4


@inner()
def residual(
    first: int,
    left: int,
    gains: NDArray[np.float32],
    along: NDArray[np.float32],
    window: Window,
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
    if y < h:
        for column in range(left, min(left + LANES, w)):
            out[y, column] = room[0, column - left]


@inner()
def iterate(window: Window) -> None:
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
def _turn(window: Window) -> None:
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
def _project(window: Window) -> None:
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
def _advance(window: Window) -> None:
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
def _multiply(p: NDArray[np.float32], window: Window) -> None:
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
def _precondition(window: Window) -> None:
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
