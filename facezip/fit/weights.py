"""The weight maps' side of an alternation: a sparse system on the low-resolution grid, solved for all expressions.

Layout: a row of the grid holds ``(R, N, w)`` weights and ``(R, R, 9, w)`` couplings, columns innermost, so that the
kernels run along rows in vector registers.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from facezip.machine import memory
from facezip.machine.rows import by_rows, map_rows, sum_rows

# Warm started: more steps would solve exactly what the next alternation changes again.
STEPS = 4
# What ties a weight to its neighbours, and to zero, as a part of the system's mean diagonal. The first fills what no
# texel sees; both keep noise out of the weights.
SMOOTHNESS = 1e-3
RIDGE = 3e-3


@dataclass(frozen=True, eq=False)
class WeightSystem:
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


def solve_weights(system: WeightSystem, start: NDArray[np.float32]) -> tuple[NDArray[np.float32], float]:
    """A few conjugate gradients from ``start``, ``(h, R, N, w)``, each expression with its own step lengths.

    Returns
    -------
    weights : ``(h, R, N, w)``.
    explained : how much lower the system's squared error is at ``start`` than with all weights zero.
    """
    rows = len(start)
    # The preconditioner: the inverse of what each texel's weights have to do with themselves.
    inverse: NDArray[np.float32] = memory.empty((rows, *system.matrix.shape[1:3], start.shape[3]), np.float32)
    map_rows(lambda top, bottom: _invert(top, bottom, system.matrix, inverse), rows)
    image: NDArray[np.float32] = memory.empty(start.shape, np.float32)
    sum_rows(lambda top, bottom: _multiply(top, bottom, system.matrix, start, image), rows)
    residual = by_rows(lambda some: system.right[some] - image[some], start.shape, np.float32)
    explained = sum(map_rows(lambda top, bottom: _explained(start, system.right, residual, top, bottom), rows))
    weights = by_rows(lambda some: start[some], start.shape, np.float32)
    direction: NDArray[np.float32] = memory.zeros(start.shape, np.float32)
    length, turn = np.zeros((2, start.shape[2]), np.float32)

    def advanced() -> NDArray[np.float64]:
        step = length, direction, image, inverse, weights, residual
        return sum_rows(lambda top, bottom: _advance(top, bottom, *step), rows)

    energy = advanced()
    for _ in range(STEPS):
        map_rows(lambda top, bottom: _turn(top, bottom, turn, inverse, residual, direction), rows)
        length[:] = _ratio(
            energy, sum_rows(lambda top, bottom: _multiply(top, bottom, system.matrix, direction, image), rows)
        )
        before, energy = energy, advanced()
        turn[:] = _ratio(energy, before)
    return weights, explained


def _explained(
    start: NDArray[np.float32], right: NDArray[np.float32], residual: NDArray[np.float32], top: int, bottom: int
) -> float:
    return float(np.vdot(start[top:bottom], right[top:bottom] + residual[top:bottom]))


def _ratio(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float32]:
    return np.divide(a, b, out=np.zeros_like(a), where=b > 0).astype(np.float32)


@njit(cache=True, nogil=True)
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


@njit(cache=True, nogil=True, fastmath={"contract"}, error_model="numpy")
def _invert(top: int, bottom: int, matrix: NDArray[np.float32], out: NDArray[np.float32]) -> None:
    """The inverse of every texel's coupling with itself, by Gauss and Jordan: they are positive definite."""
    _, slots, _, _, w = matrix.shape
    for y in range(top, bottom):
        out[y] = matrix[y, :, :, 4]
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


@njit(cache=True, nogil=True, fastmath={"contract"})
def _multiply(
    top: int, bottom: int, matrix: NDArray[np.float32], x: NDArray[np.float32], out: NDArray[np.float32]
) -> NDArray[np.float64]:
    """``out = matrix · x``; returns ``x · out`` per expression, ``(N,)``."""
    h, slots, count, _ = x.shape
    dots = np.zeros(count)
    for y in range(top, bottom):
        out[y] = 0
        for i in range(slots):
            for ny in range(max(y - 1, 0), min(y + 2, h)):
                for j in range(slots):
                    _add_row(matrix, y, i, j, x, ny, out)
            for n in range(count):
                dots[n] += _dot(x[y, i, n], out[y, i, n])
    return dots


@njit(cache=True, nogil=True, fastmath={"contract"})
def _add_row(
    matrix: NDArray[np.float32], y: int, i: int, j: int, x: NDArray[np.float32], ny: int, out: NDArray[np.float32]
) -> None:
    """Add to ``out[y, i]`` what couples its texels to those of row ``ny`` in slot j, for all expressions."""
    first, last = 3 * (ny - y + 1), x.shape[3] - 1
    for n in range(x.shape[2]):
        out[y, i, n, 0] += matrix[y, i, j, first + 1, 0] * x[ny, j, n, 0]
        if last > 0:
            out[y, i, n, 0] += matrix[y, i, j, first + 2, 0] * x[ny, j, n, 1]
            for c in range(1, last):
                out[y, i, n, c] += (
                    matrix[y, i, j, first, c] * x[ny, j, n, c - 1]
                    + matrix[y, i, j, first + 1, c] * x[ny, j, n, c]
                    + matrix[y, i, j, first + 2, c] * x[ny, j, n, c + 1]
                )
            out[y, i, n, last] += matrix[y, i, j, first, last] * x[ny, j, n, last - 1]
            out[y, i, n, last] += matrix[y, i, j, first + 1, last] * x[ny, j, n, last]


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc"})
def _dot(a: NDArray[np.float32], b: NDArray[np.float32]) -> np.float32:
    total = np.float32(0)
    for column in range(len(a)):
        total += a[column] * b[column]
    return total


@njit(cache=True, nogil=True, fastmath={"contract"})
def _advance(
    top: int,
    bottom: int,
    step: NDArray[np.float32],
    direction: NDArray[np.float32],
    image: NDArray[np.float32],
    inverse: NDArray[np.float32],
    weights: NDArray[np.float32],
    residual: NDArray[np.float32],
) -> NDArray[np.float64]:
    """Go a step along the direction; returns ``residual · inverse · residual`` per expression, ``(N,)``."""
    _, slots, count, w = weights.shape
    energy, conditioned = np.zeros(count), np.empty(w, np.float32)
    for y in range(top, bottom):
        for i in range(slots):
            for n in range(count):
                for x in range(w):
                    weights[y, i, n, x] += step[n] * direction[y, i, n, x]
                    residual[y, i, n, x] -= step[n] * image[y, i, n, x]
        for n in range(count):
            for i in range(slots):
                conditioned[:] = 0
                for j in range(slots):
                    for x in range(w):
                        conditioned[x] += inverse[y, i, j, x] * residual[y, j, n, x]
                energy[n] += _dot(residual[y, i, n], conditioned)
    return energy


@njit(cache=True, nogil=True, fastmath={"contract"})
def _turn(
    top: int,
    bottom: int,
    turn: NDArray[np.float32],
    inverse: NDArray[np.float32],
    residual: NDArray[np.float32],
    direction: NDArray[np.float32],
) -> None:
    """The next direction: ``inverse · residual + turn · direction``."""
    _, slots, count, w = direction.shape
    for y in range(top, bottom):
        for i in range(slots):
            for n in range(count):
                for x in range(w):
                    direction[y, i, n, x] *= turn[n]
                for j in range(slots):
                    for x in range(w):
                        direction[y, i, n, x] += inverse[y, i, j, x] * residual[y, j, n, x]
