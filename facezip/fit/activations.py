"""The activations of fixed masks: the weight maps' side of an alternation, projected on the masks.

With W_in = Σ_k a_nki M_k the equations A W_n = b_n of the weight maps (:mod:`facezip.fit.sweep`) become, M the masks as
columns,

    Mᵀ A M a_n = Mᵀ b_n

of K·R unknowns, whose matrix all expressions share; those of several tiles add up. They are solved within bounds by
coordinate descent (Wright, Coordinate Descent Algorithms, 2015), from what the alternation before found.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from facezip.fit.weights import WeightSystem
from facezip.machine import memory
from facezip.machine.kernels import inner, kernel
from facezip.machine.rows import BLOCK, by_rows, map_rows
from facezip.pack.masked import STEP

# Warm started: more would solve exactly what the next alternation changes again.
SWEEPS = 20


class ActivationSystem(NamedTuple):
    """Normal equations of all activations: ``matrix · a_n = right[n]``, unknown k·R + i being mask k in layer i.

    Attributes
    ----------
    matrix : ``(K·R, K·R)`` float64, symmetric.
    right : ``(N, K·R)`` float64.
    """

    matrix: NDArray[np.float64]
    right: NDArray[np.float64]

    @classmethod
    def joint(cls, parts: Iterable["ActivationSystem"]) -> "ActivationSystem":
        """The sum of the equations of several tiles."""
        return cls(*(np.sum(part, axis=0) for part in zip(*parts, strict=True)))


@dataclass(frozen=True, eq=False)
class Bounds:
    """Between what every activation lies: ``(K, R)`` float64 each."""

    low: NDArray[np.float64]
    high: NDArray[np.float64]

    @classmethod
    def of(cls, allowed: NDArray[np.bool_], nonnegative: bool) -> "Bounds":
        """Zero where a mask may not act in a layer ``(K, R)``; elsewhere any number, or any that is not negative."""
        high = np.where(allowed, np.inf, 0.0)
        return cls(np.zeros_like(high) if nonnegative else -high, high)

    @property
    def at_most_one(self) -> "Bounds":
        """The same, and no activation above 1."""
        return Bounds(self.low, np.minimum(self.high, 1))

    @property
    def nonnegative(self) -> bool:
        """Whether no activation may be negative."""
        return bool((self.low == 0).all())

    def clipped(self, activations: NDArray[np.float64]) -> NDArray[np.float64]:
        """The nearest activations ``(N, K, R)`` within them."""
        return np.clip(activations, self.low, self.high)


class _Active(NamedTuple):
    """The masks of a tile by texel: texel q = y·w + x has ``which[first[q]:first[q + 1]]``, with ``value`` > 0."""

    first: NDArray[np.int64]
    which: NDArray[np.int64]
    value: NDArray[np.float32]


def solve_activations(
    system: ActivationSystem, start: NDArray[np.float64], bounds: Bounds, sweeps: int = SWEEPS
) -> tuple[NDArray[np.float64], float]:
    """Sweeps of coordinate descent from ``start``, ``(N, K, R)``, which lies within the bounds.

    Returns
    -------
    activations : ``(N, K, R)``.
    explained : how much lower the system's squared error is at ``start`` than with all activations zero.
    """
    found = start.reshape(len(start), -1).copy()
    explained = float(np.einsum("ni,ni->", found, 2 * system.right - np.einsum("ij,nj->ni", system.matrix, found)))
    low, high = bounds.low.ravel(), bounds.high.ravel()
    map_rows(lambda first, end: _descend(first, end, *system, low, high, sweeps, found), len(found))
    return found.reshape(start.shape), explained


def project(system: WeightSystem, masks: NDArray[np.uint8]) -> ActivationSystem:
    """The equations of the activations of masks ``(K, h, w)``, from those of the weight maps of a tile."""
    height, slots, count, _ = system.right.shape
    values = by_rows(lambda rows: STEP * masks[:, rows].astype(np.float32), masks.shape, np.float32, axis=1)
    matrix, right = np.zeros((len(masks), slots, len(masks), slots)), np.zeros((len(masks), slots, count))
    active = _active(values)
    for top in range(0, height, BLOCK):
        rows = top, min(top + BLOCK, height)
        project = partial(_project, rows=rows, masks=values, active=active, projected=matrix, products=right)
        map_rows(partial(project, matrix=system.matrix, right=system.right), len(masks))
    unknowns = len(masks) * slots
    flat = matrix.reshape(unknowns, unknowns)
    return ActivationSystem((flat + flat.T) / 2, np.ascontiguousarray(right.reshape(unknowns, count).T))


def _active(masks: NDArray[np.float32]) -> _Active:
    _, height, width = masks.shape
    counts = by_rows(lambda rows: np.count_nonzero(masks[:, rows], axis=0), (height, width), np.int64)
    first = np.concatenate([[0], np.cumsum(counts)])
    which: NDArray[np.int64] = memory.empty((first[-1],), np.int64)
    value: NDArray[np.float32] = memory.empty((first[-1],), np.float32)

    def fill(top: int, bottom: int) -> None:
        by_texel = masks[:, top:bottom].reshape(len(masks), -1).T
        texel, mask = np.nonzero(by_texel)
        some = slice(first[top * width], first[bottom * width])
        which[some], value[some] = mask, by_texel[texel, mask]

    map_rows(fill, height)
    return _Active(first, which, value)


@kernel(fastmath={"contract"})
def _project(
    begin: int,
    end: int,
    rows: tuple[int, int],
    matrix: NDArray[np.float32],
    right: NDArray[np.float32],
    masks: NDArray[np.float32],
    active: _Active,
    projected: NDArray[np.float64],
    products: NDArray[np.float64],
) -> None:
    """Add texels of some rows to Mᵀ A M and to Mᵀ b, of masks ``begin`` to ``end``."""
    _, slots, count, w = right.shape
    coupled = np.empty((slots, slots))
    for k in range(begin, end):
        for y in range(rows[0], rows[1]):
            for x in range(w):
                if _couple(k, y, x, matrix, masks, coupled):
                    for e in range(active.first[y * w + x], active.first[y * w + x + 1]):
                        other, value = active.which[e], active.value[e]
                        for i in range(slots):
                            for j in range(slots):
                                projected[k, i, other, j] += value * coupled[i, j]
                if masks[k, y, x] > 0:
                    for i in range(slots):
                        for n in range(count):
                            products[k, i, n] += masks[k, y, x] * right[y, i, n, x]


@inner(fastmath={"contract"})
def _couple(
    k: int, y: int, x: int, matrix: NDArray[np.float32], masks: NDArray[np.float32], out: NDArray[np.float64]
) -> bool:
    """How mask k is coupled to a texel, ``(R, R)``; whether it is at all."""
    h, slots, _, _, w = matrix.shape
    out[:] = 0
    found = False
    for near in range(max(y - 1, 0), min(y + 2, h)):
        for beside in range(max(x - 1, 0), min(x + 2, w)):
            value = masks[k, near, beside]
            if value > 0:
                found = True
                cell = 3 * (y - near + 1) + x - beside + 1
                for i in range(slots):
                    for j in range(slots):
                        out[i, j] += value * matrix[near, i, j, cell, beside]
    return found


@kernel(fastmath={"contract"}, error_model="numpy")
def _descend(
    begin: int,
    end: int,
    matrix: NDArray[np.float64],
    right: NDArray[np.float64],
    low: NDArray[np.float64],
    high: NDArray[np.float64],
    sweeps: int,
    found: NDArray[np.float64],
) -> None:
    """Each unknown in turn takes the best value that its bounds allow; an unknown that no texel sees stays."""
    unknowns = len(matrix)
    rest = np.empty(unknowns)
    for n in range(begin, end):
        for i in range(unknowns):
            rest[i] = right[n, i]
        for i in range(unknowns):
            for j in range(unknowns):
                rest[j] -= matrix[i, j] * found[n, i]
        for _ in range(sweeps):
            for i in range(unknowns):
                if matrix[i, i] > 0:
                    value = min(max(found[n, i] + rest[i] / matrix[i, i], low[i]), high[i])
                    step = value - found[n, i]
                    found[n, i] = value
                    for j in range(unknowns):
                        rest[j] -= matrix[i, j] * step
