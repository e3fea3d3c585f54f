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
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from facezip.character.samples import Samples, Stored
from facezip.files.images import Texels
from facezip.fit.accumulation import accumulate_rows, no_sums
from facezip.fit.cholesky import add_up, factor, no_normal, round_strip, substitute
from facezip.fit.equations import (
    Equations,
    add_equations,
    collect_row,
    complete,
    no_equations,
    no_shared,
    spread_shares,
)
from facezip.fit.weights import WeightSystem
from facezip.machine import memory
from facezip.machine.kernels import inner, kernel
from facezip.machine.rows import by_rows, each_block, map_rows
from facezip.machine.vectors import LANES, load, minus, room, store
from facezip.pack.sampling import Grid, bilinear_grid, rows_between
from facezip.pack.strips import (
    WIDE,
    expand_strip,
    find_shares,
    looked_at,
    most_columns,
    no_tile,
    read_importance,
    read_textures,
    read_tile,
    says_anything,
    start_of,
    write_textures,
)

# Rows of texels that are taken together: their sums stay in registers.
AT_ONCE = 8
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

    def block(top: int, bottom: int) -> tuple[int, Equations] | None:
        begin, end = int(grid.rows.first[top]), int(grid.rows.second[bottom - 1]) + 1
        if not looked[begin:end].any():
            return None
        part = no_equations(end - begin, weights.shape, columns)
        texels = samples.stored, samples.importance, little
        _accumulate(top, bottom, *texels, weights, grid, ridge, given, looked, begin, part)
        return begin, part

    for found in each_block(block, len(samples.neutral)):
        if found is not None:
            begin, part = found
            add_equations(part, begin, samples.scale, system)
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
    map_rows(lambda top, bottom: _solve(top, bottom, *shared), len(samples.neutral))


def _sampling(samples: Samples, weights: NDArray[np.float32]) -> Grid:
    height, width, _ = samples.neutral.shape
    return bilinear_grid((height, width), (weights.shape[0], weights.shape[3]))


def _ridge(weights: NDArray[np.float32]) -> np.float32:
    h, _, _, w = weights.shape
    squares = map_rows(lambda top, bottom: np.square(weights[top:bottom]).sum(dtype=np.float64), h)
    return max(np.float32(RIDGE * np.sum(squares) / (h * w)), np.float32(1e-30))


class _Strip(NamedTuple):
    """What a sweep holds of a strip (:mod:`facezip.pack.strips`): of up to :data:`AT_ONCE` rows of texels between two
    rows of weight texels.

    Attributes
    ----------
    upper, lower, change : ``(N, P, LANES)``, weights of both rows, and how much larger the lower one's are.
    starts : ``(AT_ONCE,)``, where each row's texels start in the tile.
    fractions : ``(AT_ONCE,)``, the share v of the lower row of weight texels.
    importances : ``(AT_ONCE, LANES)``.
    normal : ``(AT_ONCE, P, K, LANES)`` (:mod:`facezip.fit.cholesky`).
    """

    upper: NDArray[np.float32]
    lower: NDArray[np.float32]
    change: NDArray[np.float32]
    starts: NDArray[np.int64]
    fractions: NDArray[np.float32]
    importances: NDArray[np.float32]
    normal: NDArray[np.float32]


@inner()
def _strip(slots: int, channels: int, count: int) -> _Strip:
    normal = no_normal(AT_ONCE, slots, channels)
    padded = normal.shape[1]
    return _Strip(
        room(count * padded).reshape(count, padded, LANES),
        room(count * padded).reshape(count, padded, LANES),
        room(count * padded).reshape(count, padded, LANES),
        np.zeros(AT_ONCE, np.int64),
        np.zeros(AT_ONCE, np.float32),
        room(AT_ONCE).reshape(AT_ONCE, LANES),
        normal,
    )


@kernel()
def _accumulate(
    top: int,
    bottom: int,
    stored: Stored,
    importance: NDArray[np.float32],
    little: np.float32,
    weights: NDArray[np.float32],
    grid: Grid,
    ridge: np.float32,
    textures: NDArray[np.float32],
    looked: NDArray[np.bool_],
    begin: int,
    equations: Equations,
) -> None:
    """Add rows of texels to a part of the system, from row ``begin`` on: under ``textures``, or those that fit best
    where there are none. Strips that are not ``looked`` at (:func:`facezip.pack.strips.looked_at`) are left out.
    """
    (_, slots, count, _), (_, _, width, channels) = weights.shape, stored.textures.shape
    columns, tile = most_columns(grid.columns), no_tile(stored, bottom - top)
    above, below, fraction = grid.rows
    here = looked[above[top] : above[bottom - 1] + 1]
    shares, shared = room(columns).reshape(columns, LANES), no_shared(columns)
    # Taken apart once: that counts references, which takes longer than a row of texels.
    upper, lower, change, starts, fractions, importances, normal = _strip(slots, channels, count)
    squares, products, weighted = no_sums(AT_ONCE, slots, count, channels)
    for left in range(0, width, LANES):
        if left % WIDE == 0 and here[:, left // LANES : (left + WIDE) // LANES].any():
            read_tile(stored, top, bottom, left, tile)
        find_shares(grid.columns, left, shares)
        spread_shares(shares, shared)
        y, first, open_row, before = top, grid.columns.first[left], -1, -1
        while y < bottom:
            end, row, visited = rows_between(above, below, y, bottom), above[y] - begin, False
            for start in range(y, end if looked[above[y], left // LANES] else y, AT_ONCE):
                many = top, start, min(start + AT_ONCE, end), bottom
                rows = _read_rows(
                    many,
                    tile,
                    importance,
                    little,
                    fraction,
                    left,
                    textures,
                    starts,
                    fractions,
                    importances,
                    normal,
                )
                if rows > 0 and not visited:
                    visited = True
                    if open_row >= 0 and open_row != row:
                        collect_row(open_row, first, shared, squares, products, equations)
                    if len(textures) == 0:
                        between = above[y], below[y]
                        before = _expand(weights, between, before, first, shares, upper, lower, change)
                if rows > 0 and len(textures) == 0:
                    add_up(rows, upper, change, fractions, tile, starts, stored.scale, normal)
                    factor(rows, slots, ridge, normal)
                    for i in range(slots - 1, -1, -1):
                        substitute(rows, i, slots, channels, normal)
                if rows > 0:
                    accumulate_rows(
                        rows, slots, normal, tile, starts, importances, fractions, squares, products, weighted
                    )
            if visited:
                collect_row(row, first, shared, squares, products, equations)
                open_row = below[y] - begin
            y = end
        if open_row >= 0:
            collect_row(open_row, first, shared, squares, products, equations)


@inner()
def _read_rows(
    many: tuple[int, int, int, int],
    tile: Texels,
    importance: NDArray[np.float32],
    little: np.float32,
    fraction: NDArray[np.float32],
    left: int,
    textures: NDArray[np.float32],
    starts: NDArray[np.int64],
    fractions: NDArray[np.float32],
    importances: NDArray[np.float32],
    normal: NDArray[np.float32],
) -> int:
    """Find those of some rows that say anything, and how many they are.

    Parameters
    ----------
    many : the first row of the tile, the first and the end of those to look at, and the end of the tile.
    """
    (top, first, end, bottom), rows = many, 0
    for y in range(first, end):
        if read_importance(importance, y, bottom, left, little, rows, importances) > 0:
            if len(textures) > 0:
                read_textures(textures, y, left, 0, rows, normal)
            starts[rows], fractions[rows] = start_of(tile, y - top, left), fraction[y]
            # The best textures are zero where nothing is to be said.
            if len(textures) > 0 or says_anything(tile, starts[rows]):
                rows += 1
    return rows


@inner()
def _expand(
    weights: NDArray[np.float32],
    rows: tuple[int, int],
    before: int,
    first: int,
    shares: NDArray[np.float32],
    upper: NDArray[np.float32],
    lower: NDArray[np.float32],
    change: NDArray[np.float32],
) -> int:
    """The weights of two rows of weight texels, between which texels lie; the lower one, to be given with the next
    ones as ``before``.
    """
    if rows[0] == before:
        for at in range(0, upper.size, LANES):
            store(upper, at, load(lower, at))
    else:
        expand_strip(weights, rows[0], first, shares, upper)
    expand_strip(weights, rows[1], first, shares, lower)
    for at in range(0, upper.size, LANES):
        store(change, at, minus(load(lower, at), load(upper, at)))
    return rows[1]


@kernel()
def _solve(
    top: int,
    bottom: int,
    stored: Stored,
    weights: NDArray[np.float32],
    grid: Grid,
    ridge: np.float32,
    given: NDArray[np.float32],
    slot: int,
    steps: NDArray[np.float32],
    out: NDArray[np.float32],
) -> None:
    """Rows of :func:`_solve_rows`; where a step ``(R, C)`` is above 0, values are rounded to multiples of it."""
    (_, slots, count, _), (_, _, width, channels) = weights.shape, stored.textures.shape
    columns, tile = most_columns(grid.columns), no_tile(stored, bottom - top)
    above, below, fraction = grid.rows
    shares, end = room(columns).reshape(columns, LANES), slot + len(out)
    upper, lower, change, starts, fractions, _, normal = _strip(slots, channels, count)
    for left in range(0, width, LANES):
        if left % WIDE == 0:
            read_tile(stored, top, bottom, left, tile)
        find_shares(grid.columns, left, shares)
        y, first, before = top, grid.columns.first[left], -1
        while y < bottom:
            after = rows_between(above, below, y, bottom)
            between = above[y], below[y]
            before = _expand(weights, between, before, first, shares, upper, lower, change)
            for start in range(y, after, AT_ONCE):
                rows = min(after - start, AT_ONCE)
                for row in range(rows):
                    starts[row] = start_of(tile, start + row - top, left)
                    fractions[row] = fraction[start + row]
                add_up(rows, upper, change, fractions, tile, starts, stored.scale, normal)
                factor(rows, slots, ridge, normal)
                for row in range(rows):
                    read_textures(given, start + row, left, end, row, normal)
                _substitute_rounded(rows, slot, end, slots, steps, normal)
                for row in range(rows):
                    write_textures(normal, row, slot, start + row, left, out)
            y = after


@inner()
def _substitute_rounded(
    rows: int, slot: int, end: int, slots: int, steps: NDArray[np.float32], normal: NDArray[np.float32]
) -> None:
    channels = steps.shape[1]
    for i in range(end - 1, slot - 1, -1):
        substitute(rows, i, slots, channels, normal)
        # Rounded before those that follow are solved, so that they make up for it (Babai's nearest plane).
        for c in range(channels):
            for row in range(rows if steps[i, c] > 0 else 0):
                round_strip(steps[i, c], normal[row, i, normal.shape[1] + c])
