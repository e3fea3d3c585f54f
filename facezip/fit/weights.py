"""The weight maps' side of an alternation: a sparse system on the low-resolution grid, solved for all expressions.

Layout: a row of the grid holds ``(R, N, w)`` weights and ``(R, R, 9, w)`` couplings, columns innermost, so that the
kernels run along rows in vector registers.

The system ``A x = b`` is solved by conjugate gradients (Hestenes & Stiefel, Methods of Conjugate Gradients for Solving
Linear Systems, 1952) with a block Jacobi preconditioner M, as in Saad, Iterative Methods for Sparse Linear Systems,
2nd edition, algorithm 9.1, whose letters these are: residual r = b - A x, z = M⁻¹ r, direction p, step α, β.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from facezip.machine import memory
from facezip.machine.kernels import inner, kernel
from facezip.machine.rows import by_rows, map_rows, sum_rows
from facezip.machine.shuffles import totals
from facezip.machine.vectors import ABREAST, LANES, all_of, load, plus_product, room, store

# Warm started: more steps would solve exactly what the next alternation changes again.
STEPS = 4
# What ties a weight to its neighbours, and to zero, as a part of the system's mean diagonal. The first fills what no
# texel sees; both keep noise out of the weights.
SMOOTHNESS = 1e-3
RIDGE = 3e-3


class WeightSystem(NamedTuple):
    """Normal equations of all weight maps: ``matrix · W_n = right_n`` on the grid of low-resolution texels.

    Attributes
    ----------
    matrix : ``(h, R, R, 9, w)`` float32, coupling of a texel with its 3 x 3 neighbours, row by row.
    right : ``(h, R, N, w)`` float32.
    """

    matrix: NDArray[np.float32]
    right: NDArray[np.float32]

    @classmethod
    def zeros(cls, shape: tuple[int, ...]) -> "WeightSystem":
        """No equation yet for weights of ``shape`` ``(h, R, N, w)``."""
        h, slots, _, w = shape
        return cls(memory.zeros((h, slots, slots, 9, w), np.float32), memory.zeros(shape, np.float32))

    @property
    def mean_diagonal(self) -> float:
        """The unit of the regularisation."""
        return float(np.einsum("hiiw->", self.matrix[:, :, :, 4], dtype=np.float64) / self.right[:, :, 0].size)

    def regularise(self, unit: float, smoothness: float = SMOOTHNESS) -> None:
        """Add the equations of ``smoothness · unit · ‖∇W‖² + RIDGE · unit · ‖W‖²``."""
        # A grid where no texel counts at all would be singular.
        tie, ridge = np.float32(smoothness * unit), np.float32(max(RIDGE * unit, 1e-30))
        map_rows(lambda top, bottom: _regularise(top, bottom, self.matrix, tie, ridge), len(self.matrix))


class _State(NamedTuple):
    """Where conjugate gradients are: x, r, p and A·p ``(h, R, N, w)``, and M⁻¹ ``(h, R, R, w)``."""

    x: NDArray[np.float32]
    r: NDArray[np.float32]
    p: NDArray[np.float32]
    ap: NDArray[np.float32]
    m_inverse: NDArray[np.float32]


def solve_weights(system: WeightSystem, start: NDArray[np.float32]) -> tuple[NDArray[np.float32], float]:
    """A few steps of conjugate gradients from ``start``, ``(h, R, N, w)``, each expression with its own α and β.

    Returns
    -------
    weights : ``(h, R, N, w)``.
    explained : how much lower the system's squared error is at ``start`` than with all weights zero.
    """
    height, a, b = len(start), system.matrix, system.right
    state = _begin(system, start)
    explained = sum(map_rows(lambda top, bottom: _explained(top, bottom, start, b, state.r), height))
    alpha, beta = np.zeros((2, start.shape[2]), np.float32)

    def advanced() -> NDArray[np.float64]:
        return sum_rows(lambda top, bottom: _advance(top, bottom, alpha, state), height)

    rz = advanced()
    for _ in range(STEPS):
        map_rows(lambda top, bottom: _turn(top, bottom, beta, state), height)
        pap = sum_rows(lambda top, bottom: multiply(top, bottom, a, state.p, state.ap), height)
        alpha[:] = _ratio(rz, pap)
        before, rz = rz, advanced()
        beta[:] = _ratio(rz, before)
    return state.x, explained


def _begin(system: WeightSystem, start: NDArray[np.float32]) -> _State:
    """x = ``start`` and p = 0: the first step goes along z."""
    height, slots, _, w = start.shape
    m_inverse: NDArray[np.float32] = memory.empty((height, slots, slots, w), np.float32)
    map_rows(lambda top, bottom: _invert(top, bottom, system.matrix, m_inverse), height)
    product: NDArray[np.float32] = memory.empty(start.shape, np.float32)
    sum_rows(lambda top, bottom: multiply(top, bottom, system.matrix, start, product), height)
    r = by_rows(lambda rows: system.right[rows] - product[rows], start.shape, np.float32)
    x = by_rows(lambda rows: start[rows], start.shape, np.float32)
    return _State(x, r, memory.zeros(start.shape, np.float32), product, m_inverse)


@kernel()
def _explained(
    top: int, bottom: int, start: NDArray[np.float32], b: NDArray[np.float32], r: NDArray[np.float32]
) -> float:
    """``startᵀ (b + r)``: in single precision the last digits would hide what the last alternations gain."""
    _, slots, count, w = start.shape
    total = 0.0
    for y in range(top, bottom):
        for i in range(slots):
            for n in range(count):
                for x in range(w):
                    total += np.float64(start[y, i, n, x]) * (np.float64(b[y, i, n, x]) + np.float64(r[y, i, n, x]))
    return total


def _ratio(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float32]:
    return np.divide(a, b, out=np.zeros_like(a), where=b > 0).astype(np.float32)


@kernel()
def _regularise(top: int, bottom: int, matrix: NDArray[np.float32], tie: np.float32, ridge: np.float32) -> None:
    h, slots, _, _, w = matrix.shape
    for y in range(top, bottom):
        for i in range(slots):
            for x in range(w):
                neighbours = 0
                for there, cell in ((y > 0, 1), (x > 0, 3), (x < w - 1, 5), (y < h - 1, 7)):
                    if there:
                        matrix[y, i, i, cell, x] -= tie
                        neighbours += 1
                matrix[y, i, i, 4, x] += neighbours * tie + ridge


@kernel(fastmath={"contract"}, error_model="numpy")
def _invert(top: int, bottom: int, matrix: NDArray[np.float32], out: NDArray[np.float32]) -> None:
    """The inverse of every texel's coupling with itself, by Gauss and Jordan: they are positive definite."""
    _, slots, _, _, w = matrix.shape
    for y in range(top, bottom):
        # Not by slices: their check of shapes takes longer to compile than all else here.
        for i in range(slots):
            for j in range(slots):
                for x in range(w):
                    out[y, i, j, x] = matrix[y, i, j, 4, x]
        for k in range(slots):
            for x in range(w):
                out[y, k, k, x] = np.float32(1) / out[y, k, k, x]
            for i in range(slots):
                for x in range(w if i != k else 0):
                    out[y, i, k, x] *= -out[y, k, k, x]
            for i in range(slots):
                for j in range(slots):
                    for x in range(w if i != k and j != k else 0):
                        out[y, i, j, x] += out[y, i, k, x] * out[y, k, j, x]
            for j in range(slots):
                for x in range(w if j != k else 0):
                    out[y, k, j, x] *= out[y, k, k, x]


@kernel()
def multiply(
    top: int, bottom: int, a: NDArray[np.float32], p: NDArray[np.float32], ap: NDArray[np.float32]
) -> NDArray[np.float64]:
    """A·p of rows; returns pᵀ A·p per expression, ``(N,)``."""
    _, slots, count, w = p.shape
    wide, abreast = (w + LANES - 1) // LANES * LANES, (count + ABREAST - 1) // ABREAST * ABREAST
    # Three rows of p with a column beside them, one row of A and one of the product: zeros follow the last column, and
    # expressions of nothing the last one.
    lines = wide // LANES
    near = room(3 * slots * abreast * (lines + 1)).reshape(3, slots, abreast, wide + LANES)
    coupled = room(slots * slots * 9 * lines).reshape(slots, slots, 9, wide)
    product = room(slots * abreast * lines).reshape(slots, abreast, wide)
    pap = np.zeros(count)
    for y in range(top, bottom):
        for ny in range(y - 1 if y == top else y + 1, y + 2):
            _read_row(p, ny, near)
        _read_couplings(a, y, coupled)
        for i in range(slots):
            for n in range(0, abreast, ABREAST):
                for x in range(0, wide, LANES):
                    _couple(y, i, n, x, near, coupled, product)
            for n in range(count):
                at, here = (i * abreast + n) * wide, ((y % 3 * slots + i) * abreast + n) * (wide + LANES) + 1
                total = all_of(np.float32(0))
                for x in range(0, wide, LANES):
                    total = plus_product(total, load(near, here + x), load(product, at + x))
                pap[n] += totals(total, total, total, total)[0]
                for x in range(w):
                    ap[y, i, n, x] = product[i, n, x]
    return pap


@inner()
def _read_row(p: NDArray[np.float32], y: int, near: NDArray[np.float32]) -> None:
    """A row of p into one of three, from the second column on; zeros beside the grid."""
    h, slots, count, w = p.shape
    for j in range(slots):
        for n in range(count):
            for x in range(w):
                near[y % 3, j, n, x + 1] = p[y, j, n, x] if 0 <= y < h else np.float32(0)


@inner()
def _read_couplings(a: NDArray[np.float32], y: int, coupled: NDArray[np.float32]) -> None:
    for i in range(a.shape[1]):
        for j in range(a.shape[2]):
            for cell in range(9):
                for x in range(a.shape[4]):
                    coupled[i, j, cell, x] = a[y, i, j, cell, x]


@inner()
def _couple(
    y: int, i: int, n: int, x: int, near: NDArray[np.float32], coupled: NDArray[np.float32], out: NDArray[np.float32]
) -> None:
    """What couples 16 texels to their neighbours, for four expressions from n on."""
    _, slots, all_rows, room = near.shape
    wide = out.shape[2]
    first = second = third = fourth = all_of(np.float32(0))
    for k in range(3):
        row = (y + k - 1) % 3
        for j in range(slots):
            for beside in range(3):
                factor = load(coupled, ((i * slots + j) * 9 + 3 * k + beside) * wide + x)
                at = ((row * slots + j) * all_rows + n) * room + x + beside
                first = plus_product(first, factor, load(near, at))
                second = plus_product(second, factor, load(near, at + room))
                third = plus_product(third, factor, load(near, at + 2 * room))
                fourth = plus_product(fourth, factor, load(near, at + 3 * room))
    there = (i * all_rows + n) * wide + x
    store(out, there, first)
    store(out, there + wide, second)
    store(out, there + 2 * wide, third)
    store(out, there + 3 * wide, fourth)


@inner(fastmath={"contract", "reassoc"})
def _dot(a: NDArray[np.float32], b: NDArray[np.float32]) -> np.float32:
    total = np.float32(0)
    for column in range(len(a)):
        total += a[column] * b[column]
    return total


@kernel(fastmath={"contract"})
def _advance(top: int, bottom: int, alpha: NDArray[np.float32], state: _State) -> NDArray[np.float64]:
    """``x += α p``, ``r -= α A·p``; returns rᵀz per expression, ``(N,)``."""
    x, r, p, ap, m_inverse = state
    _, slots, count, w = x.shape
    rz, z = np.zeros(count), np.empty(w, np.float32)
    for y in range(top, bottom):
        for i in range(slots):
            for n in range(count):
                for c in range(w):
                    x[y, i, n, c] += alpha[n] * p[y, i, n, c]
                    r[y, i, n, c] -= alpha[n] * ap[y, i, n, c]
        for n in range(count):
            for i in range(slots):
                z[:] = 0
                for j in range(slots):
                    for c in range(w):
                        z[c] += m_inverse[y, i, j, c] * r[y, j, n, c]
                rz[n] += _dot(r[y, i, n], z)
    return rz


@kernel(fastmath={"contract"})
def _turn(top: int, bottom: int, beta: NDArray[np.float32], state: _State) -> None:
    """``p = z + β p``."""
    _, r, p, _, m_inverse = state
    _, slots, count, w = p.shape
    for y in range(top, bottom):
        for i in range(slots):
            for n in range(count):
                for c in range(w):
                    p[y, i, n, c] *= beta[n]
                for j in range(slots):
                    for c in range(w):
                        p[y, i, n, c] += m_inverse[y, i, j, c] * r[y, j, n, c]
