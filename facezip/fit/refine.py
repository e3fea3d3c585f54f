"""The best textures and weight maps that equation (1) can hold: alternating least squares under bilinear sampling.

Minimises Σ_n Σ_p m(p) ‖D_n(p) - Σ_i D_i(p) (U W_in)(p)‖² plus a little smoothness, U the bilinear upsampling that a GPU
sampler does. Weights fixed, the R values of every texel are a small linear solve; textures fixed, the weights are a
sparse system whose matrix all expressions share. PCA is the special case of constant weights, and the start.

At the end the weights are rounded to what a pack stores, and the textures fitted, and rounded, to those
(:mod:`facezip.fit.rounding`).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from facezip.character.samples import Samples, thinned
from facezip.fit.descent import Descent
from facezip.fit.held import Held
from facezip.fit.nonnegative import Limits, improve_bounded
from facezip.fit.pca import larger_sides, principal_weights
from facezip.fit.start import balanced_start, uniform
from facezip.fit.sweep import joint_system, solve_textures
from facezip.fit.weights import SMOOTHNESS, WeightSystem, improve_weights
from facezip.machine import memory
from facezip.machine.progress import track
from facezip.machine.rows import by_rows, map_rows

# Many texels tell the weights in few alternations: by effort, the texels of all alternations together, and how few and
# how many alternations there are at all. :meth:`facezip.fit.descent.Descent.steps` says what is made of them.
# "start" is for fits that go on with a codec in the loop: after more of them it would lose more of the slots.
VISITS = {"start": (2**21, 4, 8), "fast": (2**24, 4, 16), "default": (20 * 2**20, 10, 24), "best": (2**26, 64, 64)}

Locked = Mapping[int, NDArray[np.float32]]
# The textures of a map under weights ``(h, R, N, w)``, where some of them stay as they are.
Textures = Callable[[Samples, NDArray[np.float32]], NDArray[np.float32]]


def fit_weights(
    maps: Sequence[Samples],
    slots: int,
    weight_scale: int,
    smoothness: float = SMOOTHNESS,
    components: NDArray[np.float32] | None = None,
    nonnegative: bool = False,
    locked: Sequence[Locked] = (),
    sparse: int | None = None,
    effort: str = "default",
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
    nonnegative : whether weights are ≥ 0 (:func:`at_most_one` scales them); otherwise they are free.
    locked : of each map, the textures ``(H, W, C)`` of some slots that stay as they are. A fit without those slots is
        the start: none is lost by them.
    sparse : how many slots an expression may use; all where None.
    effort : one of :data:`facezip.fit.settings.EFFORTS`.
    """
    height, width, _ = maps[0].neutral.shape
    few = [thinned(samples, weight_scale // 2) for samples in maps]
    grid = -(-height // weight_scale), -(-width // weight_scale)
    if components is None:
        components = principal_weights(few, slots)
    taken = {slot for each in locked for slot in each}
    if taken:
        weights: NDArray[np.float32] = memory.zeros((grid[0], slots, len(components), grid[1]), np.float32)
        free = [slot for slot in range(slots) if slot not in taken]
        if free:
            first = np.ascontiguousarray(components[:, : len(free)])
            alone = fit_weights(maps, len(free), weight_scale, smoothness, first, nonnegative, effort=effort)
            weights[:, free] = at_most_one(alone)[0] if nonnegative else alone
    elif nonnegative:
        weights = uniform(larger_sides(components), grid)
    else:
        weights = balanced_start(few, components, grid)
    fit = _Fit(maps, smoothness, nonnegative, around(locked) if taken else (), effort)
    weights = fit.alternated(weights, Limits.nonnegative(weights) if nonnegative else None)
    return weights if sparse is None else fit.sparse(weights, sparse)


def around(locked: Sequence[Locked]) -> list[Textures]:
    """How the textures of each map are solved around those that are locked."""
    return [partial(solve_textures, locked=fixed) for fixed in locked]


def fit_around(
    maps: Sequence[Samples], weights: NDArray[np.float32], held: Held, textures: Sequence[Textures], effort: str
) -> NDArray[np.float32]:
    """The weight maps ``(h, R, N, w)`` of a fit of which some stay as they are.

    Parameters
    ----------
    maps : as in :func:`fit_weights`.
    weights : to start from.
    held : what stays, and the bounds of the others.
    textures : of each map, how its textures are solved; none where they are free.
    effort : as in :func:`fit_weights`.
    """
    limits = Limits(held.low, held.high, held.where)
    return _Fit(maps, SMOOTHNESS, False, textures, effort).alternated(held.put(weights), limits)


@dataclass(frozen=True, eq=False)
class _Fit:
    """What all alternations of a fit have in common."""

    maps: Sequence[Samples]
    smoothness: float
    nonnegative: bool
    textures: Sequence[Textures]
    effort: str

    def alternated(self, weights: NDArray[np.float32], limits: Limits | None = None) -> NDArray[np.float32]:
        """Textures and weights in turn, from ``weights``."""
        count, unit = alternations(self.maps[0].importance.size, self.effort), 0.0
        # Around what is locked textures are solved whole, which no choice of texels would shorten.
        descent = Descent(weights, limits, choosing=not self.textures)
        steps = descent.steps(count)
        for _ in track(range(steps), "Refining", steps):
            moves = descent.ahead()
            system = self.system(descent.weights, moves.moving)
            unit = unit or system.mean_diagonal
            system.regularise(unit, self.smoothness)
            if limits is None:
                improve_weights(system, descent.weights, moves)
            else:
                improve_bounded(system, descent.weights, moves, limits)
            descent.settle(moves)
        return descent.weights

    def system(self, weights: NDArray[np.float32], moving: NDArray[np.bool_] | None = None) -> WeightSystem:
        """The weights' equations under the best textures, those that are locked among them: at least of the texels that
        move.
        """
        if not self.textures:
            return joint_system(self.maps, weights, moving=moving)
        pairs = zip(self.maps, self.textures, strict=True)
        return joint_system(self.maps, weights, [solved(some, weights) for some, solved in pairs])

    def sparse(self, weights: NDArray[np.float32], most: int) -> NDArray[np.float32]:
        """Weights that use ``most`` slots an expression: each gives up the one that does least in it, and is refined
        again, until no more are left.
        """
        _, slots, expressions, _ = weights.shape
        used = np.ones((slots, expressions), bool)
        for _ in range(slots - most):
            diagonal = np.einsum("hiiw->hiw", self.system(weights).matrix[:, :, :, 4])
            energy = np.einsum("hiw,hinw->in", diagonal, np.square(weights), dtype=np.float64)
            used[np.where(used, energy, np.inf).argmin(axis=0), np.arange(expressions)] = False
            high = np.where(used, np.float32(np.inf), np.float32(0))
            low = np.zeros_like(high) if self.nonnegative else -high
            weights = by_rows(partial(_kept, weights, used), weights.shape, np.float32)
            weights = self.alternated(weights, Limits(low, high))
        return weights


def alternations(texels: int, effort: str = "default") -> int:
    """How many of them a fit of so many texels is asked for."""
    visited, fewest, most = VISITS[effort]
    return min(max(visited // texels, fewest), most)


def at_most_one(
    weights: NDArray[np.float32], units: Mapping[int, np.float32] | None = None
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Each slot of weights ≥ 0 scaled until its largest is 1, for textures that are fitted to that; and what it was.

    Of a slot that is named among ``units`` that one becomes 1, and no weight is larger.
    """
    largest = np.max(map_rows(lambda top, bottom: weights[top:bottom].max(axis=(0, 2, 3)), len(weights)), axis=0)
    unit = np.where(largest > 0, largest, np.float32(1))
    for slot, one in (units or {}).items():
        unit[slot] = one
    return by_rows(lambda rows: weights[rows] / unit[:, None, None], weights.shape, np.float32), unit


def _kept(weights: NDArray[np.float32], used: NDArray[np.bool_], rows: slice) -> NDArray[np.float32]:
    return weights[rows] * used[:, :, None]
