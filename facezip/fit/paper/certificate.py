"""Proof that a stitching is the best there is, or a better one: branch and bound on the semidefinite relaxation.

The relaxation splits the cost of equation (3) into a constant, costs of pairs of masks and a quadratic form, the last
two never negative. With the form's matrix factored as U U', U upper triangular by blocks, it is a sum of squares, one
block a mask, and each depends on that mask and those before it alone: what a mask adds is known when it is placed.
The beam then sees far sooner which partial stitchings cannot become cheap, and often drops none that could.
"""

import numpy as np
from numpy.typing import NDArray

from facezip.fit.paper.beam import beam, polished, relative_costs, strongest_first
from facezip.fit.paper.relaxation import relax
from facezip.fit.paper.stitching import Stitching, all_orders

WIDTH = 5000


def certify(table: NDArray[np.float64], known: Stitching, width: int = WIDTH) -> Stitching:
    """``known`` or a cheaper stitching, with a lower bound; a gap of zero (up to rounding) proves it optimal.

    Parameters
    ----------
    table : ``(K, K, R, R)`` ≥ 0 from :func:`facezip.fit.paper.paircosts.pair_costs`.
    known : a good stitching of this table, from :func:`facezip.fit.paper.beam.beam_search`.
    width : number of partial stitchings kept, ≥ 1; the proof fails where more of them might become cheaper.

    Returns
    -------
    A stitching whose cost is at most that of ``known``. For 53 masks of 4 clusters this takes seconds.
    """
    orders = all_orders(table.shape[2])
    sequence = strongest_first(relative_costs(table, orders))
    relaxation = relax(table[np.ix_(sequence, sequence)])
    squares = _Squares(relaxation.slack, orders)
    base = relaxation.bound + squares.first
    chosen, bound = beam(relative_costs(relaxation.entries, orders), orders, width, known.cost - base, squares)
    bound = max(bound + base, known.lower_bound or 0.0)
    if len(chosen):
        found = polished(table, orders[chosen][np.argsort(sequence)], bound)
        if found.cost < known.cost:
            return found
    return Stitching(known.permutation, known.cost, known.history, min(bound, known.cost))


class _Squares:
    """The quadratic form of partial stitchings as squares that masks add, for :func:`facezip.fit.paper.beam.beam`."""

    def __init__(self, slack: NDArray[np.float64], orders: NDArray[np.int64]) -> None:
        slots = orders.shape[1]
        count = len(slack) // slots
        factor = np.linalg.cholesky(slack[::-1, ::-1])[::-1, ::-1].reshape(count, slots, count, slots)
        # A cluster stands for its indicator minus 1/R.
        self._factor = factor - factor.mean(axis=1, keepdims=True)
        self._orders = orders
        self._placed = 1
        own = self._factor[0, :, 0]
        self.first = float((own * own).sum())
        # Of each partial stitching: for every mask to come, the R rows to be squared, but for the mask's own part.
        self._rows = self._factor[0, :, 1:].transpose(1, 0, 2)[None]

    def of_next(self) -> NDArray[np.float64]:
        own = self._factor[self._placed, :, self._placed][self._orders]
        rows = self._rows[:, None, 0] + own
        return np.einsum("npic,npic->np", rows, rows)

    def extend(self, parents: NDArray[np.int64], added: NDArray[np.int64]) -> None:
        later = self._factor[self._placed, :, self._placed + 1 :].transpose(1, 0, 2)
        self._rows = self._rows[parents, 1:] + later[:, self._orders].transpose(1, 0, 2, 3)[added]
        self._placed += 1
