"""The textures of a run of texels: a system of R equations a texel, by Cholesky's factorisation.

For every texel ``(Σ_n w_n w_nᵀ + ρ 1) D = Σ_n w_n d_n`` with w_n the R weights and d_n the difference of expression n.
Arrays are ``(…, RUN)``, one texel of the run beside the other (:mod:`facezip.pack.sampling`).
"""

import numpy as np
from numpy.typing import NDArray

from facezip.machine.kernels import inner


@inner(fastmath={"contract"})
def factor_run(
    weight: NDArray[np.float32],
    differences: NDArray[np.float32],
    ridge: np.float32,
    run: int,
    factor: NDArray[np.float32],
    out: NDArray[np.float32],
) -> None:
    """Every texel's factor L, and L⁻¹ Σ_n w_n d_n, which :func:`substitute_run` turns into textures.

    Parameters
    ----------
    weight : ``(R, N, RUN)``.
    differences : ``(C, N, RUN)``.
    ridge : ρ > 0.
    run : how many texels there are.
    factor : ``(R, R, RUN)``, where L goes, with the reciprocals of its diagonal in their place.
    out : ``(R, C, RUN)``, where L⁻¹ Σ_n w_n d_n goes.
    """
    slots = len(weight)
    for i in range(slots):
        for j in range(i + 1):
            _dot(weight, i, weight, j, run, factor)
        for x in range(run):
            factor[i, i, x] += ridge
        for c in range(len(differences)):
            _dot(weight, i, differences, c, run, out)
    for i in range(slots):
        _eliminate(i, ridge, run, factor, out)


@inner(fastmath={"contract"})
def substitute_run(i: int, factor: NDArray[np.float32], run: int, out: NDArray[np.float32]) -> None:
    """The best texture ``out[i]`` given those of all k > i, the rest of them free: a step of back substitution."""
    for c in range(out.shape[1]):
        for k in range(i + 1, len(out)):
            _subtract(factor[k, i], out[k, c], run, out[i, c])
        _scale(factor[i, i], run, out[i, c])


@inner(fastmath={"contract"}, error_model="numpy")
def _eliminate(i: int, ridge: np.float32, run: int, factor: NDArray[np.float32], out: NDArray[np.float32]) -> None:
    """Row i of the Cholesky factor in place, with the reciprocal on its diagonal, and forward substitution."""
    diagonal = factor[i, i]
    for j in range(i):
        for k in range(j):
            _subtract(factor[i, k], factor[j, k], run, factor[i, j])
        _scale(factor[j, j], run, factor[i, j])
        _subtract(factor[i, j], factor[i, j], run, diagonal)
    for x in range(run):
        diagonal[x] = np.float32(1) / np.sqrt(max(diagonal[x], ridge))
    for c in range(out.shape[1]):
        for k in range(i):
            _subtract(factor[i, k], out[k, c], run, out[i, c])
        _scale(diagonal, run, out[i, c])


@inner(error_model="numpy")
def round_run(step: np.float32, run: int, values: NDArray[np.float32]) -> None:
    """Round to multiples of ``step`` within ±127 of them."""
    per_step = np.float32(1) / step
    for x in range(run):
        values[x] = step * min(max(np.rint(values[x] * per_step), np.float32(-127)), np.float32(127))


@inner()
def _scale(factors: NDArray[np.float32], run: int, values: NDArray[np.float32]) -> None:
    for x in range(run):
        values[x] *= factors[x]


@inner(fastmath={"contract"})
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


@inner(fastmath={"contract"})
def _subtract(a: NDArray[np.float32], b: NDArray[np.float32], run: int, out: NDArray[np.float32]) -> None:
    for x in range(run):
        out[x] -= a[x] * b[x]
