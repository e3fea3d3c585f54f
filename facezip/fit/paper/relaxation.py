"""The semidefinite relaxation of equation (3): a lower bound of its cost, and what is left of the cost above it.

Let P_k be the permutation matrix of mask k. The cost is linear in the products X_kl = P_k' P_l, which are doubly
stochastic and, as blocks of one matrix X, positive semidefinite with X_kk = I. Forgetting that they are permutations
leaves a convex problem (as in Huang & Guibas, Consistent Shape Maps via Semidefinite Programming, 2013). Every point of
its dual is a lower bound; steps of the alternating direction method approach the best one (Wen, Goldfarb & Yin,
Alternating Direction Augmented Lagrangian Methods for Semidefinite Programming, 2010).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

STEPS = 200
# Of the augmented Lagrangian, for costs of unit deviation, and of the step of its multiplier.
PENALTY, RELAXATION = 3.0, 1.6
# By how much the slack is made definite, beyond what rounding may hide.
MARGIN = 1e-9
Blocks = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Relaxation:
    """A point of the dual: the cost of every stitching is ``bound`` + <entries, X> + <slack, X - 1/R>.

    Attributes
    ----------
    bound : a cost that no permutation is below, because neither of the two products is negative.
    entries : ``(K, K, R, R)`` ≥ 0, symmetric; zero within a mask.
    slack : ``(K·R, K·R)``, symmetric and positive definite.
    """

    bound: float
    entries: Blocks
    slack: NDArray[np.float64]


def relax(table: Blocks, steps: int = STEPS) -> Relaxation:
    """A point of the dual for the table ``(K, K, R, R)`` ≥ 0 of pairs' costs.

    Any number of steps gives a bound; more give a better one, down to the gap of the relaxation itself. Time is that of
    an eigendecomposition of ``(K·R, K·R)`` a step: seconds for 53 masks.
    """
    count, _, slots, _ = table.shape
    scale = float(table.std()) or 1.0
    cost = _centred(table / scale)
    with threadpool_limits(1):
        diagonal, entries = _dual(cost, steps)
        entries = (entries + entries.transpose(1, 0, 3, 2)) / 2
        slack = _flat(cost - _centred(entries) - diagonal)
        slack = (slack + slack.T) / 2
        # Not quite semidefinite yet. The trace of X - 1/R is known: what is added to the slack is taken from the bound.
        lift = MARGIN - min(float(np.linalg.eigvalsh(slack)[0]), 0.0)
    trace = float(np.einsum("kkaa->", diagonal))
    bound = table.sum() / slots + scale * (trace - entries.sum() / slots - count * (slots - 1) * lift)
    return Relaxation(float(bound), scale * entries, scale * (slack + lift * np.eye(len(slack))))


def _dual(cost: Blocks, steps: int) -> tuple[Blocks, Blocks]:
    """The multipliers of Y_kk = I - 1/R and of X ≥ 0, for costs whose rows and columns sum to zero.

    Y = X - 1/R takes the place of X, so that rows and columns of its blocks sum to zero as well. With the multiplier of
    Y being semidefinite (``curved``) they sum to the cost at the optimum.
    """
    count, _, slots, _ = cost.shape
    own = np.arange(count)
    centre = np.eye(slots) - 1 / slots
    diagonal, entries, curved, primal = (np.zeros_like(cost) for _ in range(4))
    primal[own, own] = centre
    free = cost
    for _ in range(steps):
        diagonal[own, own] = (free - curved)[own, own] + (centre - primal[own, own]) / PENALTY
        entries = np.maximum(entries + free - diagonal - curved - (primal + 1 / slots) / PENALTY, 0)
        entries[own, own] = 0
        free = cost - _centred(entries)
        curved = _semidefinite(free - diagonal - primal / PENALTY)
        primal += RELAXATION * PENALTY * (diagonal + curved - free)
    return diagonal, entries


def _centred(blocks: Blocks) -> Blocks:
    rows = blocks - blocks.mean(axis=3, keepdims=True)
    return rows - rows.mean(axis=2, keepdims=True)


def _semidefinite(blocks: Blocks) -> Blocks:
    """The nearest positive semidefinite matrix."""
    count, _, slots, _ = blocks.shape
    values, vectors = np.linalg.eigh(_flat(blocks))
    kept = vectors[:, values > 0]
    matrix = (kept * values[values > 0]) @ kept.T
    return matrix.reshape(count, slots, count, slots).transpose(0, 2, 1, 3)


def _flat(blocks: Blocks) -> Blocks:
    """``(K, K, R, R)`` as one matrix ``(K·R, K·R)``."""
    side = blocks.shape[0] * blocks.shape[2]
    return blocks.transpose(0, 2, 1, 3).reshape(side, side)
