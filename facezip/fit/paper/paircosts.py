"""What it costs to put two clusters of neighbouring masks into one difference texture (paper §3.1, equation 3).

The cost of a stitching is a sum over pairs of overlapping masks and depends on R times R numbers a pair. One pass over
the texels makes this table; no search looks at anything else.
"""

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from facezip.character.samples import Stored, stored_texels
from facezip.character.scans import Stack
from facezip.fit.paper.fragments import differences_of_row
from facezip.fit.paper.masks import MaskLookup, Masks, masks_at
from facezip.machine.kernels import inner, kernel
from facezip.machine.rows import sum_rows


def pair_costs(stack: Stack, masks: Masks, labels: NDArray[np.int32], clusters: int) -> NDArray[np.float64]:
    """The table ``(K, K, R, R)``: Σ_p M_k²·M_l² ‖c_ak(p) - c_bl(p)‖², c_ak the mean difference of cluster a of mask k.

    These are the terms of equation (3): with the fragments' masks multiplied in, D''_akl = M_k·M_l·c_ak.
    """
    member = _membership(labels, clusters)
    stored, lookup = stored_texels(stack), masks.lookup
    pair, first, second = _overlapping(masks)

    def block(top: int, bottom: int) -> NDArray[np.float64]:
        return _pair_costs(top, bottom, stored, member, pair, len(first), lookup)

    costs = sum_rows(block, stack.resolution[0]).reshape(-1, clusters, clusters)
    table = np.zeros((masks.count, masks.count, clusters, clusters))
    table[first, second] = costs
    table[second, first] = costs.transpose(0, 2, 1)
    return table


def _membership(labels: NDArray[np.int32], clusters: int) -> NDArray[np.float32]:
    """``(K, R, N)``: 1 / size where expression n is in cluster a of mask k; an empty cluster has no members."""
    member = (labels[:, None, :] == np.arange(clusters)[None, :, None]).astype(np.float32)
    shares: NDArray[np.float32] = member / np.maximum(member.sum(axis=2, keepdims=True), 1)
    return shares


def _overlapping(masks: Masks) -> tuple[NDArray[np.int32], NDArray[np.int64], NDArray[np.int64]]:
    """The pairs ``first < second`` of masks that share a triangle, and the number ``(K, K)`` of each, else -1."""
    shape = len(masks.first) - 1, masks.count
    incidence = sparse.csr_matrix((np.ones(len(masks.active), np.float32), masks.active, masks.first), shape)
    first, second = sparse.triu(incidence.T @ incidence, k=1).nonzero()
    pair = np.full((masks.count, masks.count), -1, np.int32)
    pair[first, second] = np.arange(len(first))
    return pair, first.astype(np.int64), second.astype(np.int64)


@inner(inline="always")
def _spread_centres(
    x: int,
    share: NDArray[np.float32],
    differences: NDArray[np.float32],
    rows: NDArray[np.float32],
    columns: NDArray[np.float32],
) -> None:
    """The R cluster means of a texel as the rows and as the columns of ``(C, R·R)`` tables."""
    slots, count = share.shape
    for a in range(slots):
        for c in range(rows.shape[0]):
            mean = np.float32(0)
            for n in range(count):
                mean += share[a, n] * differences[x, c, n]
            for b in range(slots):
                rows[c, a * slots + b] = mean
                columns[c, b * slots + a] = mean


@kernel()
def _pair_costs(
    top: int,
    bottom: int,
    stored: Stored,
    member: NDArray[np.float32],
    pair: NDArray[np.int32],
    pairs: int,
    lookup: MaskLookup,
) -> NDArray[np.float64]:
    count, _, width, channels = stored.textures.shape
    masks, slots, _ = member.shape
    active = lookup.active
    cells = slots * slots
    total = np.zeros((pairs, cells))
    differences = np.empty((width, channels, count), np.float32)
    # All R·R combinations of a pair of masks side by side, so that the innermost loop fills vector registers.
    rows = np.empty((masks, channels, cells), np.float32)
    columns = np.empty((masks, channels, cells), np.float32)
    squared = np.empty(cells, np.float32)
    mask = np.empty(masks, np.float32)
    for y in range(top, bottom):
        differences_of_row(y, stored, differences)
        for x in range(width):
            begin, end = masks_at(lookup, y, x, mask)
            for j in range(end - begin):
                _spread_centres(x, member[active[begin + j]], differences, rows[j], columns[j])
                for other in range(j):
                    overlap = mask[j] * mask[other] * mask[j] * mask[other]
                    if overlap == 0:
                        continue
                    squared[:] = 0
                    for c in range(channels):
                        for q in range(cells):
                            gap = rows[other, c, q] - columns[j, c, q]
                            squared[q] += gap * gap
                    cell = total[pair[active[begin + other], active[begin + j]]]
                    for q in range(cells):
                        cell[q] += overlap * squared[q]
    return total
