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
    explained = sum(map_rows(lambda top, bottom: _explained(start, b, state.r, top, bottom), height))
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


def _explained(
    start: NDArray[np.float32], b: NDArray[np.float32], r: NDArray[np.float32], top: int, bottom: int
) -> float:
    return float(np.vdot(start[top:bottom], b[top:bottom] + r[top:bottom]))


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


@kernel(fastmath={"contract"})
def multiply(
    top: int, bottom: int, a: NDArray[np.float32], p: NDArray[np.float32], ap: NDArray[np.float32]
) -> NDArray[np.float64]:
    """A·p of rows; returns pᵀ A·p per expression, ``(N,)``."""
    h, slots, count, _ = p.shape
    pap = np.zeros(count)
    for y in range(top, bottom):
        ap[y] = 0
        for i in range(slots):
            for ny in range(max(y - 1, 0), min(y + 2, h)):
                for j in range(slots):
                    _add_row(a, y, i, j, p, ny, ap)
            for n in range(count):
                pap[n] += _dot(p[y, i, n], ap[y, i, n])
    return pap


@inner(fastmath={"contract"})
def _add_row(
    a: NDArray[np.float32], y: int, i: int, j: int, p: NDArray[np.float32], ny: int, ap: NDArray[np.float32]
) -> None:
    """Add to ``ap[y, i]`` what couples its texels to those of row ``ny`` in slot j, for all expressions."""
    left, last = 3 * (ny - y + 1), p.shape[3] - 1
    for n in range(p.shape[2]):
        ap[y, i, n, 0] += a[y, i, j, left + 1, 0] * p[ny, j, n, 0]
        if last > 0:
            ap[y, i, n, 0] += a[y, i, j, left + 2, 0] * p[ny, j, n, 1]
            for c in range(1, last):
                ap[y, i, n, c] += (
                    a[y, i, j, left, c] * p[ny, j, n, c - 1]
                    + a[y, i, j, left + 1, c] * p[ny, j, n, c]
                    + a[y, i, j, left + 2, c] * p[ny, j, n, c + 1]
                )
            ap[y, i, n, last] += a[y, i, j, left, last] * p[ny, j, n, last - 1]
            ap[y, i, n, last] += a[y, i, j, left + 1, last] * p[ny, j, n, last]


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
