"""A stitching at or near the least cost of equation (3): beam search over the masks, with a lower bound.

Masks get their permutations one after the other, each time the one that the masks before it determine most. Of all
partial stitchings the most promising are kept: least cost so far plus, for every mask to come, the least that it can
still add. That promise is never above the cost of what a partial stitching may become, so the least promise among all
that were dropped is a lower bound. The paper's sweeps polish the result. Nothing is random.
"""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from facezip.fit.paper.stitching import SWEEPS, Stitching, all_orders, descend
from facezip.machine.kernels import kernel

WIDTH = 300


class Surcharge(Protocol):
    """What partial stitchings cost besides the sum over pairs of masks; it never falls as they grow."""

    def of_next(self) -> NDArray[np.float64]:
        """``(partial, R!)`` ≥ 0: what the next mask adds by each order."""

    def extend(self, parents: NDArray[np.int64], added: NDArray[np.int64]) -> None:
        """Go on with ``parents``, the next mask of each in the order ``added``."""


def beam_search(table: NDArray[np.float64], width: int = WIDTH) -> Stitching:
    """The best stitching among ``width`` partial ones at a time.

    Parameters
    ----------
    table : ``(K, K, R, R)`` ≥ 0 from :func:`facezip.fit.paper.paircosts.pair_costs`.
    width : number of partial stitchings kept, ≥ 1. Time and memory grow in proportion; the gap narrows.

    Returns
    -------
    A stitching with a lower bound. Its history has one row: the paper's sweeps from the end of the beam.
    """
    orders = all_orders(table.shape[2])
    relative = relative_costs(table, orders)
    sequence = strongest_first(relative)
    chosen, bound = beam(relative[np.ix_(sequence, sequence)], orders, width)
    return polished(table, orders[chosen][np.argsort(sequence)], bound)


def polished(table: NDArray[np.float64], permutation: NDArray[np.int64], bound: float) -> Stitching:
    """The paper's sweeps from a permutation ``(K, R)``, with a lower bound that is known already."""
    permutations, history = permutation[None].copy(), np.empty((1, SWEEPS + 1))
    descend(table, all_orders(table.shape[2]), permutations, history)
    cost = float(history[0, -1])
    return Stitching(permutations[0], cost, history, min(bound, cost))


def relative_costs(table: NDArray[np.float64], orders: NDArray[np.int64]) -> NDArray[np.float64]:
    """``(K, K, R!)``: both terms of a pair of masks if cluster a of the first goes with ``orders[r, a]`` of the second.

    Renaming the textures changes no cost, so a pair has R! costs, not R! times R!.
    """
    relative = np.zeros((*table.shape[:2], len(orders)))
    for a, matches in enumerate(orders.T):
        relative += 2 * table[:, :, a, matches]
    return relative


def strongest_first(relative: NDArray[np.float64]) -> NDArray[np.int64]:
    """The masks, each time the one that matters most to those before it; the one that matters most to all begins."""
    weight = relative.max(axis=2) - relative.min(axis=2)
    tie = weight.sum(axis=1)
    sequence: list[int] = []
    while len(sequence) < len(weight):
        tie[sequence] = -1
        sequence.append(int(tie.argmax()))
        tie = weight[sequence].sum(axis=0)
    return np.array(sequence)


def beam(
    relative: NDArray[np.float64],
    orders: NDArray[np.int64],
    width: int,
    limit: float = np.inf,
    surcharge: Surcharge | None = None,
) -> tuple[NDArray[np.int64], float]:
    """The order ``(K,)`` of every mask, the first in order 0, and a lower bound of the cost, at most ``limit``.

    Only costs below ``limit`` are looked for; if there is none among those kept, no orders ``(0,)`` come back.
    """
    relations, least = _relations(orders), relative.min(axis=2)
    relative = relative - least[:, :, None]
    limit -= np.triu(least, 1).sum()
    # Of each partial stitching: its orders, its cost, what every order of every mask to come would add, and the least.
    chosen, spent = np.zeros((1, 1), np.int64), np.zeros(1)
    fields = relative[0, 1:].T[None, relations[0]]
    to_come, bound = fields[:, :, 1:].min(axis=1).sum(axis=1), limit
    for k in range(1, len(relative)):
        addition = fields[:, :, 0] if surcharge is None else fields[:, :, 0] + surcharge.of_next()
        hopes = ((spent + to_come)[:, None] + addition).ravel()
        kept, dropped = _least(hopes, width)
        bound = min(bound, dropped)
        parents, added = np.divmod(kept[hopes[kept] < limit], len(orders))
        if len(parents) == 0:
            return np.empty(0, np.int64), float(bound + np.triu(least, 1).sum())
        chosen = np.column_stack([chosen[parents], added])
        spent = spent[parents] + addition[parents, added]
        fields, to_come = _extended(fields, parents, added, relative[k, k + 1 :].T[relations])
        if surcharge is not None:
            surcharge.extend(parents, added)
    return chosen[0], float(min(bound, spent[0]) + np.triu(least, 1).sum())


def _relations(orders: NDArray[np.int64]) -> NDArray[np.int64]:
    """``(R!, R!)``: which order takes the clusters of a mask under order p to those of a mask under order q."""
    number = {tuple(order): index for index, order in enumerate(orders.tolist())}
    inverses = np.argsort(orders, axis=1)
    return np.array([[number[tuple(order[inverse].tolist())] for order in orders] for inverse in inverses])


def _least(values: NDArray[np.float64], count: int) -> tuple[NDArray[np.int64], float]:
    """Where the least values are, in rising order and the first among equals first, and the least of all others."""
    if len(values) <= count:
        return np.argsort(values, kind="stable"), np.inf
    limit = np.partition(values, count)[count]
    candidates = np.flatnonzero(values <= limit)
    return candidates[np.argsort(values[candidates], kind="stable")[:count]], float(limit)


@kernel()
def _extended(
    fields: NDArray[np.float64], parents: NDArray[np.int64], added: NDArray[np.int64], costs: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The fields of partial stitchings with one more mask, and the sum of the least of all masks after the next."""
    _, count, later = costs.shape
    extended = np.empty((len(parents), count, later))
    to_come = np.empty(len(parents))
    least = np.empty(later)
    for child, parent in enumerate(parents):
        least[:] = np.inf
        for order in range(count):
            for mask in range(later):
                cost = fields[parent, order, mask + 1] + costs[added[child], order, mask]
                extended[child, order, mask] = cost
                least[mask] = min(least[mask], cost)
        to_come[child] = least[1:].sum()
    return extended, to_come
