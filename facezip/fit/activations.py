"""The activations of fixed masks: the weight maps' side of an alternation, projected on the masks.

With W_in = Σ_k a_nki M_k the equations A W_n = b_n of the weight maps (:mod:`facezip.fit.sweep`) become, M the masks as
columns,

    Mᵀ A M a_n = Mᵀ b_n

of K·R unknowns, whose matrix all expressions share; those of several tiles add up. They are solved within bounds by
coordinate descent (Wright, Coordinate Descent Algorithms, 2015), from what the alternation before found.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from facezip.character.samples import Samples
from facezip.fit.momentum import accelerated
from facezip.fit.pca import larger_sides
from facezip.fit.refine import alternations
from facezip.fit.rounding import as_fitted
from facezip.fit.sweep import joint_system
from facezip.fit.weights import SMOOTHNESS, WeightSystem
from facezip.machine.progress import track
from facezip.machine.rows import map_rows
from facezip.pack.masked import STEP, expanded

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


def fit_activations(
    tiles: Mapping[int, Sequence[Samples]],
    masks: Mapping[int, NDArray[np.uint8]],
    components: NDArray[np.float32],
    bounds: Bounds,
) -> NDArray[np.float16]:
    """The activations ``(N, K, R)`` of masks that all tiles share, the largest of each layer scaled to 1.

    The size of a layer is free, since its difference textures are fitted to it: scaled so, activations that are not
    negative lie in 0..1. Of those the largest under each mask is near 1, so that no texture is larger than it need be.

    Parameters
    ----------
    tiles : the texels of each map on each tile. The error that is least is the sum over all of them.
    masks : by tile, ``(K, h, w)``.
    components : ``(N, R)`` uniform weights to start from.
    bounds : of the activations.
    """
    count = alternations(max(maps[0].importance.size for maps in tiles.values()))
    activations = _alternated(tiles, masks, _start(components, bounds), bounds, track(range(count), "Refining", count))
    if bounds.nonnegative:
        # Where one mask acts alone, its layers have a size of their own. At 1 each is a whole texture, I0 + D_i.
        activations, more = _scaled(activations, axis=0), count // 2
        activations = _alternated(tiles, masks, activations, bounds.at_most_one, track(range(more), "Clamping", more))
    return _scaled(activations, axis=(0, 1)).astype(np.float16)


def _scaled(activations: NDArray[np.float64], axis: int | tuple[int, ...]) -> NDArray[np.float64]:
    """With the largest along ``axis`` at 1."""
    largest = np.abs(activations).max(axis=axis)
    scaled: NDArray[np.float64] = activations / np.where(largest > 0, largest, 1)
    return scaled


def _alternated(
    tiles: Mapping[int, Sequence[Samples]],
    masks: Mapping[int, NDArray[np.uint8]],
    start: NDArray[np.float64],
    bounds: Bounds,
    steps: Iterable[int],
) -> NDArray[np.float64]:
    """Activations ``(N, K, R)`` after some alternations from ``start``."""
    units: dict[int, float] = {}

    def alternate(ahead: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
        return solve_activations(_joint(tiles, masks, ahead, units), ahead, bounds)

    return accelerated(
        start, steps, lambda here, before, share: bounds.clipped(here + share * (here - before)), alternate
    )


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
    _, slots, count, _ = system.right.shape
    values = STEP * masks.astype(np.float32)
    matrix, right = np.zeros((len(masks), slots, len(masks), slots)), np.zeros((len(masks), slots, count))
    active = _active(values)
    map_rows(lambda first, end: _project(first, end, *system, values, active, matrix, right), len(masks))
    unknowns = len(masks) * slots
    flat = matrix.reshape(unknowns, unknowns)
    return ActivationSystem((flat + flat.T) / 2, np.ascontiguousarray(right.reshape(unknowns, count).T))


def _joint(
    tiles: Mapping[int, Sequence[Samples]],
    masks: Mapping[int, NDArray[np.uint8]],
    activations: NDArray[np.float64],
    units: dict[int, float],
) -> ActivationSystem:
    """The equations of all tiles; ``units`` keeps the first unit of each one's regularisation."""
    parts = []
    for tile, maps in tiles.items():
        system = joint_system(maps, as_fitted(expanded(masks[tile], activations.astype(np.float32))))
        system.regularise(units.setdefault(tile, system.mean_diagonal), SMOOTHNESS)
        parts.append(project(system, masks[tile]))
    return ActivationSystem.joint(parts)


def _start(components: NDArray[np.float32], bounds: Bounds) -> NDArray[np.float64]:
    """The same weights ``(N, R)`` under every mask, ``(N, K, R)``."""
    weights = larger_sides(components) if bounds.nonnegative else components
    return bounds.clipped(np.repeat(weights[:, None].astype(np.float64), len(bounds.low), axis=1))


def _active(masks: NDArray[np.float32]) -> _Active:
    by_texel = masks.reshape(len(masks), -1).T
    texel, which = np.nonzero(by_texel)
    first = np.searchsorted(texel, np.arange(len(by_texel) + 1))
    return _Active(first, which, by_texel[texel, which])


@njit(cache=True, nogil=True, fastmath={"contract"})
def _project(
    begin: int,
    end: int,
    matrix: NDArray[np.float32],
    right: NDArray[np.float32],
    masks: NDArray[np.float32],
    active: _Active,
    projected: NDArray[np.float64],
    products: NDArray[np.float64],
) -> None:
    """Rows of Mᵀ A M and of Mᵀ b, those of masks ``begin`` to ``end``."""
    h, slots, count, w = right.shape
    coupled = np.empty((slots, slots))
    for k in range(begin, end):
        for y in range(h):
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


@njit(cache=True, nogil=True, fastmath={"contract"})
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


@njit(cache=True, nogil=True, fastmath={"contract"}, error_model="numpy")
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
