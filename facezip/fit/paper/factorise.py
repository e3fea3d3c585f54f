"""Difference textures and weight maps from clusters and their permutation (paper §3.1, equations 5-6)."""

import numpy as np
from numpy.typing import NDArray

from facezip.character.samples import Stored, stored_texels
from facezip.character.scans import Stack
from facezip.fit.paper.fragments import differences_of_row
from facezip.fit.paper.masks import MaskLookup, Masks, masks_at
from facezip.machine import memory
from facezip.machine.kernels import kernel
from facezip.machine.rows import map_rows


def difference_textures(stack: Stack, masks: Masks, shares: NDArray[np.float32]) -> NDArray[np.float32]:
    """Equation (5): ``(R, H, W, C)``, D_i = Σ_k M_k Σ_n shares[k, i, n] (I_n - I_0).

    Parameters
    ----------
    stack : the textures.
    masks : K masks.
    shares : ``(K, R, N)``, the part of expression n in the fragment of mask k that texture i takes.
    """
    height, width = stack.resolution
    out = memory.empty((shares.shape[1], height, width, stack.neutral.shape[2]), np.float32)
    stored, lookup = stored_texels(stack), masks.lookup
    map_rows(lambda top, bottom: _stitch(top, bottom, stored, shares, lookup, out), height)
    return out


def cluster_shares(
    labels: NDArray[np.int32], permutation: NDArray[np.int64]
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Which expressions make each stitched fragment.

    Returns
    -------
    shares : ``(K, R, N)`` float32, 1 / size for the members of cluster σ(i, k): their mean is its centre.
    alpha : ``(K, R, N)`` float32, α of equation (6): 1 for members, else 0.
    """
    alpha = (labels[:, None, :] == permutation[:, :, None]).astype(np.float32)
    return alpha / np.maximum(alpha.sum(axis=2, keepdims=True), 1), alpha


def weight_maps(masks: Masks, alpha: NDArray[np.float32], scale: int) -> NDArray[np.float32]:
    """Equation (6) at 1/``scale`` of the resolution: ``(N, h, w, R)``, W_in = Σ_k α_ink M_k."""
    small = masks.downsampled(scale)
    weights: NDArray[np.float32] = np.einsum("kin,khw->nhwi", alpha, small, optimize=True)
    return np.ascontiguousarray(weights)


@kernel()
def _stitch(
    top: int,
    bottom: int,
    stored: Stored,
    shares: NDArray[np.float32],
    lookup: MaskLookup,
    out: NDArray[np.float32],
) -> None:
    count, _, width, channels = stored.textures.shape
    masks, slots, _ = shares.shape
    differences = np.empty((width, channels, count), np.float32)
    mixture = np.empty((slots, count), np.float32)
    mask = np.empty(masks, np.float32)
    for y in range(top, bottom):
        differences_of_row(y, stored, differences)
        for x in range(width):
            begin, end = masks_at(lookup, y, x, mask)
            mixture[:] = 0
            for j in range(end - begin):
                share = shares[lookup.active[begin + j]]
                for i in range(slots):
                    for n in range(count):
                        mixture[i, n] += mask[j] * share[i, n]
            for i in range(slots):
                for c in range(channels):
                    total = np.float32(0)
                    for n in range(count):
                        total += mixture[i, n] * differences[x, c, n]
                    out[i, y, x, c] = total
