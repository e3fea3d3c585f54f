"""Which cluster of each mask goes to which difference texture, so that neighbours match (paper §3.1, equations 3-4).

Here are the paper's own search and its ablation; :mod:`facezip.fit.paper.beam` finds lower costs in less time, and
:mod:`facezip.fit.paper.certificate` proves them. All see only the table of pair costs.
"""

from dataclasses import dataclass
from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from facezip.machine.kernels import kernel

SWEEPS = 10


@dataclass(frozen=True, eq=False)
class Stitching:
    """The outcome of a search.

    Attributes
    ----------
    permutation : ``(K, R)`` int, σ: difference texture i takes cluster ``permutation[k, i]`` of mask k.
    cost : C(σ), equation (3), in squared texel values.
    history : ``(restarts, SWEEPS + 1)`` costs at the start and after each sweep (the paper's Figure 7, left).
    lower_bound : a cost that no permutation is below, at most ``cost``; None from a search that knows none.
    """

    permutation: NDArray[np.int64]
    cost: float
    history: NDArray[np.float64]
    lower_bound: float | None = None

    @property
    def gap(self) -> float | None:
        """(cost - lower_bound) / cost, 0..1: the share that no search can gain; 0 is a proof of optimality."""
        if self.lower_bound is None:
            return None
        return (self.cost - self.lower_bound) / self.cost if self.cost > 0 else 0.0


def all_orders(slots: int) -> NDArray[np.int64]:
    """``(R!, R)``: all permutations of R clusters, the identity first."""
    return np.array(list(permutations(range(slots))), dtype=np.int64)


def search(table: NDArray[np.float64], restarts: int, seed: int) -> Stitching:
    """The paper's search: from random permutations, improve mask after mask, 10 sweeps; the best start wins."""
    count, _, slots, _ = table.shape
    orders = all_orders(slots)
    begin = orders[np.random.default_rng(seed).integers(0, len(orders), (restarts, count))]
    history = np.empty((restarts, SWEEPS + 1))
    descend(table, orders, begin, history)
    final = history[:, -1]
    # Rounding does not say which of several equal ends counts.
    best = int(np.flatnonzero(final <= final.min() * (1 + 1e-9))[0])
    return Stitching(begin[best], float(history[best, -1]), history)


def unpermuted(table: NDArray[np.float64]) -> Stitching:
    """Clusters in the order in which k-means numbers them: the paper's ablation."""
    count, _, slots, _ = table.shape
    permutation = np.tile(np.arange(slots), (count, 1))
    cost = stitching_cost(table, permutation)
    return Stitching(permutation, cost, np.array([[cost]]))


@kernel()
def stitching_cost(table: NDArray[np.float64], permutation: NDArray[np.int64]) -> float:
    """C(σ) of equation (3), over ordered pairs of masks as the paper sums it."""
    total = 0.0
    for k in range(len(permutation)):
        for other in range(len(permutation)):
            for i in range(permutation.shape[1]):
                total += table[k, other, permutation[k, i], permutation[other, i]]
    return total


@kernel()
def descend(
    table: NDArray[np.float64],
    orders: NDArray[np.int64],
    permutations: NDArray[np.int64],
    history: NDArray[np.float64],
) -> None:
    """Improve every ``permutations[start]`` in place, mask after mask, sweep by sweep; fill its row of the history."""
    slots = orders.shape[1]
    placing = np.empty((slots, slots))
    for start in range(len(permutations)):
        permutation = permutations[start]
        history[start, 0] = stitching_cost(table, permutation)
        for sweep in range(history.shape[1] - 1):
            for k in range(len(permutation)):
                placing[:] = 0
                for other in range(len(permutation)):
                    for i in range(slots):
                        for a in range(slots):
                            placing[i, a] += table[k, other, a, permutation[other, i]]
                best = np.inf
                for order in orders:
                    cost = 0.0
                    for i in range(slots):
                        cost += placing[i, order[i]]
                    if cost < best:
                        best = cost
                        # Not by a slice: its check of shapes takes longer to compile than all else here.
                        for i in range(slots):
                            permutation[k, i] = order[i]
            history[start, sweep + 1] = stitching_cost(table, permutation)
