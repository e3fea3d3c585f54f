"""The best textures and weight maps that equation (1) can hold: alternating least squares under bilinear sampling.

Minimises Σ_n Σ_p m(p) ‖D_n(p) - Σ_i D_i(p) (U W_in)(p)‖² plus a little smoothness, U the bilinear upsampling that a GPU
sampler does. Weights fixed, the R values of every texel are a small linear solve; textures fixed, the weights are a
sparse system whose matrix all expressions share. PCA is the special case of constant weights, and the start.

At the end the weights are rounded to what a pack stores, and the textures fitted, and rounded, to those.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from facezip.character.samples import Samples, thinned
from facezip.fit.nonnegative import solve_bounded, solve_nonnegative
from facezip.fit.pca import larger_sides, principal_weights
from facezip.fit.sweep import solve_around, solve_textures, weight_system
from facezip.fit.weights import SMOOTHNESS, WeightSystem, solve_weights
from facezip.machine import memory
from facezip.machine.progress import track
from facezip.machine.rows import by_rows, map_rows
from facezip.pack.quantise import STEPS, best_ranges, quantise_weights
from facezip.pack.sampling import bilinear_grid

# Many texels tell the weights in few alternations: that many texels are visited, in 4 to 16 alternations.
TEXELS_VISITED = 2**24
# The gauge in which a fit starts changes slowly: one is found for so many weight texels each way.
GAUGE = 4
# Of more texels a quarter tells the ranges of difference textures; of fewer, they depend on which.
MANY_TEXELS = 2**20

Solve = Callable[[WeightSystem, NDArray[np.float32]], tuple[NDArray[np.float32], float]]


def as_stored(weights: NDArray[np.float32]) -> NDArray[np.float32]:
    """Weight maps ``(h, R, N, w)`` as a pack gives them back, ``(N, h, w, R)``."""
    turned = weights.transpose(2, 0, 3, 1)
    return quantise_weights(by_rows(lambda rows: turned[:, rows], turned.shape, np.float32, axis=1)).values


def best_differences(
    samples: Samples, stored: NDArray[np.float32], locked: Mapping[int, NDArray[np.float32]] | None = None
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """The difference textures, rounded to what a pack stores, that fit best to stored weight maps ``(N, h, w, R)``.

    Textures ``(H, W, C)`` of ``locked`` slots stay as they are; their range says nothing.

    Returns
    -------
    differences : ``(R, H, W, C)``.
    ranges : ``(R, C)``, the largest value that each may take.
    """
    turned = stored.transpose(1, 3, 0, 2)
    weights = by_rows(lambda rows: turned[rows], turned.shape, np.float32)
    many, locked = samples.importance.size > MANY_TEXELS, locked or {}
    some = thinned(samples, 2) if many else samples
    fewer = {slot: texture[1::2, 1::2] if many else texture for slot, texture in locked.items()}
    ranges = best_ranges(_solved(some, weights, fewer), some.importance)
    return _solved(samples, weights, locked, ranges / np.float32(STEPS)), ranges


def _solved(
    samples: Samples,
    weights: NDArray[np.float32],
    locked: Mapping[int, NDArray[np.float32]],
    steps: NDArray[np.float32] | None = None,
) -> NDArray[np.float32]:
    return solve_around(samples, weights, locked, steps) if locked else solve_textures(samples, weights, steps)


def fit_weights(
    maps: Sequence[Samples],
    slots: int,
    weight_scale: int,
    smoothness: float = SMOOTHNESS,
    components: NDArray[np.float32] | None = None,
    nonnegative: bool = False,
    locked: Sequence[Mapping[int, NDArray[np.float32]]] | None = None,
    sparse: int | None = None,
) -> NDArray[np.float32]:
    """Weight maps ``(h, R, N, w)`` of the refined fit, in floating point, shared by several maps of one tile.

    Parameters
    ----------
    maps : the texels of each map; the first one's size says how fine weights are. The error that is least is the sum
        over maps, each weighted by its importance.
    slots : R.
    weight_scale : how many times smaller weight maps are.
    smoothness : of the weights, as a part of the system's mean diagonal.
    components : ``(N, R)`` uniform weights to start from; None for PCA's of these maps.
    nonnegative : whether weights lie in 0..1, the largest of each slot at 1; otherwise they are free.
    locked : of each map, the textures ``(H, W, C)`` of some slots that stay as they are. Weights that are not negative
        are then left as large as they are. A fit without those slots is the start: none is lost by them.
    sparse : how many slots an expression may use; all where None.
    """
    height, width, _ = maps[0].neutral.shape
    few = [thinned(samples, weight_scale // 2) for samples in maps]
    grid = -(-height // weight_scale), -(-width // weight_scale)
    if components is None:
        components = principal_weights(few, slots)
    if locked and any(locked):
        weights = _started(maps, slots, weight_scale, smoothness, components, nonnegative, locked)
    elif nonnegative:
        weights = uniform(larger_sides(components), grid)
    else:
        weights = balanced_start(few, components, grid)
    count = alternations(height * width)
    solve = solve_nonnegative if nonnegative else solve_weights
    weights = _alternated(maps, weights, count, solve, smoothness, nonnegative, locked)
    if sparse is not None:
        weights = _sparse(maps, weights, sparse, count, smoothness, nonnegative, locked)
    return at_most_one(weights)[0] if nonnegative and not locked else weights


def _alternated(
    maps: Sequence[Samples],
    weights: NDArray[np.float32],
    count: int,
    solve: Solve,
    smoothness: float,
    nonnegative: bool,
    locked: Sequence[Mapping[int, NDArray[np.float32]]] | None,
) -> NDArray[np.float32]:
    """Textures and weights in turn, ``count`` times, from ``weights``."""
    previous, unit, explained_before, age = weights, 0.0, -np.inf, 0
    for _ in track(range(count), "Refining", count):
        # Nesterov's momentum: far fewer alternations reach the same error.
        ahead = _extrapolated(weights, previous, age / (age + 2), 0 if nonnegative else -np.inf)
        age += 1
        system = _system(maps, ahead, locked)
        unit = unit or system.mean_diagonal
        system.regularise(unit, smoothness)
        previous = weights
        weights, explained = solve(system, ahead)
        if explained < explained_before:
            # Momentum went past the goal: forget it.
            previous, age = weights, 0
        explained_before = explained
    return weights


def _system(
    maps: Sequence[Samples],
    weights: NDArray[np.float32],
    locked: Sequence[Mapping[int, NDArray[np.float32]]] | None,
) -> WeightSystem:
    """The weights' equations under the best textures, those that are locked among them."""
    if not locked:
        return joint_system(maps, weights)
    around = [_solved(samples, weights, fixed) for samples, fixed in zip(maps, locked, strict=True)]
    return joint_system(maps, weights, around)


def _sparse(
    maps: Sequence[Samples],
    weights: NDArray[np.float32],
    most: int,
    count: int,
    smoothness: float,
    nonnegative: bool,
    locked: Sequence[Mapping[int, NDArray[np.float32]]] | None,
) -> NDArray[np.float32]:
    """Weights that use ``most`` slots an expression: each gives up the one that does least in it, and is refined again,
    until no more are left.
    """
    _, slots, expressions, _ = weights.shape
    used = np.ones((slots, expressions), bool)
    for _ in range(slots - most):
        diagonal = np.einsum("hiiw->hiw", _system(maps, weights, locked).matrix[:, :, :, 4])
        energy = np.einsum("hiw,hinw->in", diagonal, np.square(weights), dtype=np.float64)
        used[np.where(used, energy, np.inf).argmin(axis=0), np.arange(expressions)] = False
        high = np.where(used, np.float32(np.inf), np.float32(0))
        low = np.zeros_like(high) if nonnegative else -high
        weights = by_rows(partial(_kept, weights, used), weights.shape, np.float32)
        weights = _alternated(
            maps, weights, count, partial(solve_bounded, low=low, high=high), smoothness, nonnegative, locked
        )
    return weights


def _kept(weights: NDArray[np.float32], used: NDArray[np.bool_], rows: slice) -> NDArray[np.float32]:
    return weights[rows] * used[:, :, None]


def _started(
    maps: Sequence[Samples],
    slots: int,
    weight_scale: int,
    smoothness: float,
    components: NDArray[np.float32],
    nonnegative: bool,
    locked: Sequence[Mapping[int, NDArray[np.float32]]],
) -> NDArray[np.float32]:
    """The weights of a fit without the slots in which something is locked; there they are zero."""
    taken = {slot for each in locked for slot in each}
    free = [slot for slot in range(slots) if slot not in taken]
    height, width, _ = maps[0].neutral.shape
    shape = (-(-height // weight_scale), slots, len(components), -(-width // weight_scale))
    weights: NDArray[np.float32] = memory.zeros(shape, np.float32)
    if free:
        first = np.ascontiguousarray(components[:, : len(free)])
        weights[:, free] = fit_weights(maps, len(free), weight_scale, smoothness, first, nonnegative)
    return weights


def alternations(texels: int) -> int:
    """How many of them a fit of so many texels makes."""
    return min(max(TEXELS_VISITED // texels, 4), 16)


def joint_system(
    maps: Sequence[Samples], weights: NDArray[np.float32], textures: Sequence[NDArray[np.float32]] | None = None
) -> WeightSystem:
    """The equations of weight maps that several maps share: the sum of each one's (:func:`weight_system`)."""
    total, *others = (
        weight_system(samples, weights, textures[k] if textures else None) for k, samples in enumerate(maps)
    )
    for other in others:
        map_rows(partial(_add, total, other), len(total.right))
    return total


def _add(total: WeightSystem, other: WeightSystem, top: int, bottom: int) -> None:
    total.matrix[top:bottom] += other.matrix[top:bottom]
    total.right[top:bottom] += other.right[top:bottom]


def balanced_start(
    maps: Sequence[Samples], components: NDArray[np.float32], grid: tuple[int, int]
) -> NDArray[np.float32]:
    """Uniform weights ``(N, R)`` on a grid, in the gauge where W Wᵀ and D Dᵀ are alike at every place.

    Any invertible mixture of the slots changes nothing in equation (1); in this one neither weights nor textures have
    large values where the other is small, so that both use the few steps of 8 bits well. The fit stays near it.
    """
    count, slots = components.shape
    coarse = -(-grid[0] // GAUGE), -(-grid[1] // GAUGE)
    shape, flat = (coarse[0], slots, count, coarse[1]), uniform(components, coarse)
    energies = joint_system(maps, flat).matrix
    # How much the texels about each place count: the diagonal of one texture of ones.
    first = np.ascontiguousarray(flat[:, :1])
    texels = joint_system(maps, first, [_ones(samples) for samples in maps]).matrix[:, 0, 0, 4]
    floored = np.maximum(texels, 1e-3 * texels.max())

    def energy(rows: slice) -> NDArray[np.float32]:
        here: NDArray[np.float32] = energies[rows, :, :, 4].transpose(0, 3, 1, 2) / floored[rows, :, None, None]
        return here

    traces = by_rows(lambda rows: np.trace(energy(rows), axis1=2, axis2=3), coarse, np.float32)
    floor = max(1e-3 * traces.mean() / slots, 1e-30)

    def balanced(rows: slice) -> NDArray[np.float32]:
        values, vectors = np.linalg.eigh(energy(rows).astype(np.float64))
        root = np.power(np.maximum(values, 0) + floor, 0.25)
        gauge = (vectors * root[:, :, None, :]) @ vectors.swapaxes(2, 3)
        mixed: NDArray[np.float32] = np.einsum("hwij,hjnw->hinw", gauge.astype(np.float32), flat[rows])
        return mixed

    return _resampled(by_rows(balanced, shape, np.float32), grid)


def uniform(components: NDArray[np.float32], grid: tuple[int, int]) -> NDArray[np.float32]:
    """Uniform weights ``(N, R)`` on a grid, ``(h, R, N, w)``."""
    count, slots = components.shape
    row = components.T[None, :, :, None]
    return by_rows(lambda rows: row, (grid[0], slots, count, grid[1]), np.float32)


def _resampled(weights: NDArray[np.float32], grid: tuple[int, int]) -> NDArray[np.float32]:
    """Weights ``(h, R, N, w)`` on another grid, by bilinear sampling."""
    h, slots, count, w = weights.shape
    down, across = bilinear_grid(grid, (h, w))

    def sampled(rows: slice) -> NDArray[np.float32]:
        upper, lower = weights[down.first[rows]], weights[down.second[rows]]
        mixed = upper + down.fraction[rows, None, None, None] * (lower - upper)
        near: NDArray[np.float32] = mixed[..., across.first]
        return near + across.fraction * (mixed[..., across.second] - near)

    return by_rows(sampled, (grid[0], slots, count, grid[1]), np.float32)


def _ones(samples: Samples) -> NDArray[np.float32]:
    one, shape = np.ones(1, np.float32), (1, *samples.neutral.shape)
    return by_rows(lambda rows: one, shape, np.float32, axis=1)


def _extrapolated(
    weights: NDArray[np.float32], previous: NDArray[np.float32], momentum: float, low: float
) -> NDArray[np.float32]:
    def ahead(rows: slice) -> NDArray[np.float32]:
        here: NDArray[np.float32] = weights[rows]
        return np.maximum(here + np.float32(momentum) * (here - previous[rows]), np.float32(low))

    return by_rows(ahead, weights.shape, np.float32)


def at_most_one(weights: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Each slot of weights ≥ 0 scaled until its largest is 1, for textures that are fitted to that; and what it was."""
    largest = np.max(map_rows(lambda top, bottom: weights[top:bottom].max(axis=(0, 2, 3)), len(weights)), axis=0)
    unit = np.where(largest > 0, largest, np.float32(1))
    return by_rows(lambda rows: weights[rows] / unit[:, None, None], weights.shape, np.float32), unit
