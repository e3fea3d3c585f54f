"""The one pass over the texels of an alternation: solve every texel's textures, add it to the weights' equations.

Minimised is Σ_p m(p) Σ_n ‖d_n(p) - Σ_i D_i(p) w_in(p)‖²: texels p of importance m, expressions n with differences d_n
from the neutral, textures D_i, and weights w_in(p) = Σ_q s_q(p) W_in(q), the bilinear mean of the four weight texels q
about p, with shares s_q(p) = (1-u)(1-v), u (1-v), (1-u) v and u v. It is quadratic in D and in W, and its normal
equations are linear.

Weights fixed, each texel has a system of its own, R x R, the same for all channels (m cancels)::

    Σ_j [Σ_n w_in w_jn + ρ δ_ij] D_j = Σ_n w_in d_n

Textures fixed, the weight maps have one sparse system, the same for all expressions n. Two weight texels q and r have a
term in common only where texels lie between both, so each has 9 blocks, R x R, one for each of its 3 x 3 neighbours::

    Σ_r Σ_j [Σ_p m s_q s_r ⟨D_i, D_j⟩] W_jn(r) = Σ_p m s_q ⟨D_i, d_n⟩

In an alternation the first solution is at once a term of the second system, and is not kept. Texels are handled in runs
along a row (:mod:`facezip.pack.strips`), top to bottom, so that what lies between two rows of weight texels is summed
before it is shared out.
"""

from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from facezip.character.samples import Samples
from facezip.fit.equations import Equations, add_equations, complete, no_equations
from facezip.fit.passes import accumulate, solve
from facezip.fit.weights import WeightSystem
from facezip.machine import memory
from facezip.machine.rows import by_rows, each_block, map_rows
from facezip.pack.sampling import Grid, bilinear_grid
from facezip.pack.strips import looked_at, most_columns

# ρ as a part of the mean trace of a texel's system: bounds a texture where all weights are small.
RIDGE = 1e-3
# Of the most that a texel counts: of texels that all count no more, such as those beside the face, some stand for all.
LITTLE = 0.05


def weight_system(
    samples: Samples,
    weights: NDArray[np.float32],
    textures: NDArray[np.float32] | None = None,
    moving: NDArray[np.bool_] | None = None,
) -> WeightSystem:
    """The system that the weight maps solve under ``textures``, or under those that fit best to ``weights``.

    Parameters
    ----------
    samples : the texels.
    weights : ``(h, R, N, w)``, sampled bilinearly.
    textures : ``(R, H, W, C)``, or None.
    moving : ``(h, w)``, the weight texels whose equations have to be whole, where others may lack terms; None for all.
    """
    grid, ridge = _sampling(samples, weights), _ridge(weights)
    system, columns = WeightSystem.zeros(weights.shape), most_columns(grid.columns)
    little = np.float32(LITTLE * samples.importance.max())
    given = np.empty((0,) * 4, np.float32) if textures is None else textures
    looked = looked_at(np.ones((len(weights), weights.shape[3]), np.bool_) if moving is None else moving, grid)

    def block(top: int, bottom: int) -> tuple[slice, Equations] | None:
        begin, last = int(grid.rows.first[top]), bottom - 1
        some = looked[begin : int(grid.rows.first[last]) + 1]
        if not some.any():
            return None
        rows = slice(begin, int(grid.rows.second[last]) + 1)
        part = no_equations(system.right[rows].shape, columns)
        texels = samples.stored, samples.importance, little
        accumulate(top, bottom, *texels, weights, grid, ridge, given, some, part)
        return rows, part

    for found in each_block(block, len(samples.neutral)):
        if found is not None:
            rows, part = found
            add_equations(part, samples.scale, system.matrix[rows], system.right[rows])
    map_rows(partial(complete, system.matrix), len(weights))
    return system


def joint_system(
    maps: Sequence[Samples],
    weights: NDArray[np.float32],
    textures: Sequence[NDArray[np.float32]] | None = None,
    moving: NDArray[np.bool_] | None = None,
) -> WeightSystem:
    """The equations of weight maps that several maps share: the sum of each one's (:func:`weight_system`)."""
    total, *others = (
        weight_system(samples, weights, textures[k] if textures else None, moving) for k, samples in enumerate(maps)
    )
    for other in others:
        map_rows(partial(_add, total, other), len(total.right))
    return total


def _add(total: WeightSystem, other: WeightSystem, top: int, bottom: int) -> None:
    total.matrix[top:bottom] += other.matrix[top:bottom]
    total.right[top:bottom] += other.right[top:bottom]


def solve_textures(
    samples: Samples,
    weights: NDArray[np.float32],
    steps: NDArray[np.float32] | None = None,
    locked: Mapping[int, NDArray[np.float32]] | None = None,
) -> NDArray[np.float32]:
    """The difference textures ``(R, H, W, C)`` that fit best under given weights ``(h, R, N, w)``.

    Parameters
    ----------
    samples, weights : as in :func:`weight_system`.
    steps : ``(R, C)``; where given, values are multiples of it within ±127, rounded one texture after the other so
        that those that follow make up for the rounding (Babai's nearest plane).
    locked : textures ``(H, W, C)`` of some slots, which stay as they are.
    """
    slots, channels = weights.shape[1], samples.neutral.shape[2]
    textures: NDArray[np.float32] = memory.empty((slots, *samples.neutral.shape), np.float32)
    steps = np.zeros((slots, channels), np.float32) if steps is None else steps
    if not locked:
        _solve_rows(samples, weights, textures, 0, steps, textures)
        return textures
    # Those that are given come last, since a texel's system is solved from the last slot to the first.
    free = [slot for slot in range(slots) if slot not in locked]
    order = [*free, *locked]
    for place, texture in enumerate(locked.values(), len(free)):
        textures[place] = texture
    turned = by_rows(lambda rows: weights[rows][:, order], weights.shape, np.float32)
    if free:
        _solve_rows(samples, turned, textures, 0, steps[order], textures[: len(free)])
    back = np.argsort(order)
    return by_rows(lambda rows: textures[back, rows], textures.shape, np.float32, axis=1)


def solve_texture(
    samples: Samples, weights: NDArray[np.float32], textures: NDArray[np.float32], slot: int
) -> NDArray[np.float32]:
    """The difference texture ``(H, W, C)`` of one slot that fits best given those of later slots, earlier ones free.

    So textures can be stored one after the other, from the last slot to the first, each making up for what storing
    lost before.

    Parameters
    ----------
    samples, weights : as in :func:`weight_system`.
    textures : ``(R, H, W, C)``, of which those after ``slot`` are read.
    """
    texture: NDArray[np.float32] = memory.empty(textures.shape[1:], np.float32)
    exact = np.zeros((len(textures), texture.shape[2]), np.float32)
    _solve_rows(samples, weights, textures, slot, exact, texture[None])
    return texture


def _solve_rows(
    samples: Samples,
    weights: NDArray[np.float32],
    given: NDArray[np.float32],
    slot: int,
    steps: NDArray[np.float32],
    out: NDArray[np.float32],
) -> None:
    """Solve ``len(out)`` textures from ``slot`` on, under those of later slots as ``given``."""
    shared = samples.stored, weights, _sampling(samples, weights), _ridge(weights), given, slot, steps, out
    map_rows(lambda top, bottom: solve(top, bottom, *shared), len(samples.neutral))


def _sampling(samples: Samples, weights: NDArray[np.float32]) -> Grid:
    height, width, _ = samples.neutral.shape
    return bilinear_grid((height, width), (weights.shape[0], weights.shape[3]))


def _ridge(weights: NDArray[np.float32]) -> np.float32:
    h, _, _, w = weights.shape
    squares = map_rows(lambda top, bottom: np.square(weights[top:bottom]).sum(dtype=np.float64), h)
    return max(np.float32(RIDGE * np.sum(squares) / (h * w)), np.float32(1e-30))
