"""Which cluster of each mask goes to which difference texture, so that neighbours match (paper §3.1, equations 3-4).

The cost of a choice is a sum over pairs of overlapping masks and depends on four times four numbers a pair. One pass
over the texels makes this table; the search looks at nothing else.
"""

from dataclasses import dataclass
from itertools import permutations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from facezip.character import Character
from facezip.fragments import differences_of_row, texel_scale
from facezip.masks import Masks, masks_at
from facezip.rows import map_rows

SWEEPS = 10


@dataclass(frozen=True, eq=False)
class Stitching:
    """The outcome of a search.

    Attributes
    ----------
    permutation : ``(K, R)`` int, σ: difference texture i takes cluster ``permutation[k, i]`` of mask k.
    cost : C(σ), equation (3), in squared texel values.
    history : ``(restarts, SWEEPS + 1)`` costs at the start and after each sweep (the paper's Figure 7, left).
    """

    permutation: NDArray[np.int64]
    cost: float
    history: NDArray[np.float64]


def pair_costs(character: Character, masks: Masks, labels: NDArray[np.int32], clusters: int) -> NDArray[np.float64]:
    """The table ``(K, K, R, R)``: Σ_p M_k²·M_l² ‖c_ak(p) - c_bl(p)‖², c_ak the mean difference of cluster a of mask k.

    These are the terms of equation (3): with the fragments' masks multiplied in, D''_akl = M_k·M_l·c_ak.
    """
    member = _membership(labels, clusters)
    stored = character.textures, character.neutral, texel_scale(character)

    def block(top: int, bottom: int) -> NDArray[np.float64]:
        return _pair_costs(top, bottom, *stored, member, masks.first, masks.active, *masks.lookup)  # type: ignore[no-any-return]

    half: NDArray[np.float64] = np.sum(map_rows(block, character.resolution[0]), axis=0)
    table: NDArray[np.float64] = half + half.transpose(1, 0, 3, 2)
    return table


def search(table: NDArray[np.float64], restarts: int, seed: int) -> Stitching:
    """The paper's search: from random permutations, improve mask after mask, 10 sweeps; the best start wins."""
    count, _, slots, _ = table.shape
    orders = np.array(list(permutations(range(slots))), dtype=np.int64)
    begin = orders[np.random.default_rng(seed).integers(0, len(orders), (restarts, count))]
    history = np.empty((restarts, SWEEPS + 1))
    _descend(table, orders, begin, history)
    best = int(history[:, -1].argmin())
    return Stitching(begin[best], float(history[best, -1]), history)


def unpermuted(table: NDArray[np.float64]) -> Stitching:
    """Clusters in the order in which k-means numbers them: the paper's ablation."""
    count, _, slots, _ = table.shape
    permutation = np.tile(np.arange(slots), (count, 1))
    cost = stitching_cost(table, permutation)
    return Stitching(permutation, cost, np.array([[cost]]))


@njit(cache=True, nogil=True)
def stitching_cost(table: NDArray[np.float64], permutation: NDArray[np.int64]) -> float:
    """C(σ) of equation (3), over ordered pairs of masks as the paper sums it."""
    total = 0.0
    for k in range(len(permutation)):
        for other in range(len(permutation)):
            for i in range(permutation.shape[1]):
                total += table[k, other, permutation[k, i], permutation[other, i]]
    return total


@njit(cache=True, nogil=True)
def _descend(
    table: NDArray[np.float64],
    orders: NDArray[np.int64],
    permutations: NDArray[np.int64],
    history: NDArray[np.float64],
) -> None:
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
                        permutation[k] = order
            history[start, sweep + 1] = stitching_cost(table, permutation)


def _membership(labels: NDArray[np.int32], clusters: int) -> NDArray[np.float32]:
    """``(K, R, N)``: 1 / size where expression n is in cluster a of mask k; an empty cluster has no members."""
    member = (labels[:, None, :] == np.arange(clusters)[None, :, None]).astype(np.float32)
    shares: NDArray[np.float32] = member / np.maximum(member.sum(axis=2, keepdims=True), 1)
    return shares


@njit(cache=True, nogil=True)
def _pair_costs(
    top: int,
    bottom: int,
    textures: NDArray[np.uint8],
    neutral: NDArray[np.uint8],
    scale: np.float32,
    member: NDArray[np.float32],
    first: NDArray[np.int64],
    active: NDArray[np.int32],
    face: NDArray[np.int32],
    barycentric: NDArray[np.float32],
    faces: NDArray[np.int32],
    values: NDArray[np.float32],
) -> NDArray[np.float64]:
    count, _, width, channels = textures.shape
    masks, slots, _ = member.shape
    total = np.zeros((masks, masks, slots, slots))
    differences = np.empty((width, channels, count), np.float32)
    centre = np.empty((masks, slots, channels), np.float32)
    mask = np.empty(masks, np.float32)
    for y in range(top, bottom):
        differences_of_row(y, textures, neutral, scale, differences)
        for x in range(width):
            begin, end = masks_at(y, x, first, active, face, barycentric, faces, values, mask)
            for j in range(end - begin):
                share = member[active[begin + j]]
                for a in range(slots):
                    for c in range(channels):
                        mean = np.float32(0)
                        for n in range(count):
                            mean += share[a, n] * differences[x, c, n]
                        centre[j, a, c] = mean
            for j in range(end - begin):
                for other in range(j):
                    overlap = mask[j] * mask[other]
                    cell = total[active[begin + other], active[begin + j]]
                    for a in range(slots):
                        for b in range(slots):
                            squared = np.float32(0)
                            for c in range(channels):
                                gap = centre[other, a, c] - centre[j, b, c]
                                squared += gap * gap
                            cell[a, b] += overlap * overlap * squared
    return total
