"""Masked differences and their clusters, in Gram coordinates (paper §3.1, equation 2 and Clustering).

K-means needs nothing of the fragments but their distances, and those are in the N x N Gram matrix of each mask. One
pass over the texels makes all of them; the clustering itself never sees a texel.
"""

import warnings
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from facezip.character.samples import Stored, stored_texels
from facezip.character.scans import Stack
from facezip.fit.paper.masks import MaskLookup, Masks, masks_at
from facezip.machine.kernels import inner, kernel
from facezip.machine.progress import track
from facezip.machine.rows import sum_rows

# scikit-learn takes half of a command's start to import, and only the paper's method needs it.
if TYPE_CHECKING:
    from sklearn.cluster import KMeans

STARTS = 10
# Inertias that differ by less than this part of all squares are equal.
TIED = 1e-9


def masked_gram(stack: Stack, masks: Masks) -> NDArray[np.float64]:
    """Gram matrices of the fragments of every mask: ``(K, N, N)``, G_k[n, m] = Σ_p M_k(p)² ⟨D_n(p), D_m(p)⟩.

    ``D_n = I_n - I_0`` in [0, 1]; the fragments are those of equation (2).
    """
    stored, lookup = stored_texels(stack), masks.lookup
    packed = sum_rows(lambda top, bottom: _masked_gram(top, bottom, stored, lookup), stack.resolution[0])
    return _unpack(packed, len(stack.textures))


def cluster_fragments(grams: NDArray[np.float64], clusters: int, seed: int) -> NDArray[np.int32]:
    """K-means of the N fragments of each mask: labels ``(K, N)`` in ``[0, clusters)``.

    The best of ten starts by k-means++, as scikit-learn does by default on the fragments' pixels.
    """
    with threadpool_limits(1):
        masks = track(grams, "Clustering", len(grams))
        return np.stack([best_clusters(gram, clusters, seed, k) for k, gram in enumerate(masks)])


def best_clusters(gram: NDArray[np.float64], clusters: int, seed: int, mask: int) -> NDArray[np.int32]:
    """Labels ``(N,)`` of the rows whose Gram matrix is given, the fragments of one mask."""
    rows = gram_rows(gram)
    fits = [lloyd(rows, start) for start in starts(rows, clusters, seed)]
    return best_of(fits, rows, np.random.default_rng([seed, mask]))


def best_of(fits: Sequence["KMeans"], rows: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.int32]:
    """The labels ``(N,)`` of the fit of least inertia, in an order that is drawn.

    K-means numbers clusters as it meets them, and breaks ties by rounding, which differs between processors. So the
    clusters are numbered by their first members here, and of partitions that are equally good the first is taken. The
    stitching is about the order of clusters from mask to mask: what it begins with has to be arbitrary.
    """
    limit = min(fit.inertia_ for fit in fits) + TIED * np.square(rows).sum()
    best = min(_in_order(fit.labels_) for fit in fits if fit.inertia_ <= limit)
    return rng.permutation(len(fits[0].cluster_centers_)).astype(np.int32)[list(best)]


def _in_order(labels: NDArray[np.int32]) -> tuple[int, ...]:
    numbers = {label: number for number, label in enumerate(dict.fromkeys(labels.tolist()))}
    return tuple(numbers[label] for label in labels.tolist())


def starts(rows: NDArray[np.float64], clusters: int, seed: int) -> list[NDArray[np.int64]]:
    """Indices of the rows with which each k-means start begins, ``STARTS`` times ``(clusters,)``."""
    from sklearn.cluster import kmeans_plusplus

    random = np.random.RandomState(seed)
    return [kmeans_plusplus(rows, clusters, random_state=random)[1] for _ in range(STARTS)]


def lloyd(rows: NDArray[np.float64], start: NDArray[np.int64]) -> "KMeans":
    """K-means from the given rows as first centres."""
    from sklearn.cluster import KMeans
    from sklearn.exceptions import ConvergenceWarning

    with warnings.catch_warnings():
        # Fewer different fragments than clusters: a region that hardly moves. Empty clusters are fine then.
        warnings.simplefilter("ignore", ConvergenceWarning)
        # The tolerance is a share of the variance per coordinate, of which pixels have more than Gram rows: none.
        return KMeans(len(start), init=rows[start], n_init=1, tol=0, algorithm="lloyd").fit(rows)


def gram_rows(gram: NDArray[np.float64]) -> NDArray[np.float64]:
    """N points ``(N, N)`` with the given inner products: rows of a square root of the Gram matrix."""
    values, vectors = np.linalg.eigh(gram)
    rows: NDArray[np.float64] = vectors * np.sqrt(np.maximum(values, 0))
    return rows


def _unpack(packed: NDArray[np.float64], n: int) -> NDArray[np.float64]:
    """Lower triangles ``(..., N(N+1)/2)`` as symmetric matrices."""
    grams = np.zeros((*packed.shape[:-1], n, n))
    rows, columns = np.tril_indices(n)
    grams[..., rows, columns] = packed
    grams[..., columns, rows] = packed
    return grams


@inner()
def differences_of_row(y: int, stored: Stored, out: NDArray[np.float32]) -> None:
    """Write D_n = I_n - I_0 of one row of texels to ``out``, ``(W, C, N)``, so that a texel's N values lie together."""
    textures, neutral, scale = stored
    count, _, width, channels = textures.shape
    for n in range(count):
        for x in range(width):
            for c in range(channels):
                out[x, c, n] = scale * (np.float32(textures[n, y, x, c]) - np.float32(neutral[y, x, c]))


@kernel()
def _masked_gram(top: int, bottom: int, stored: Stored, lookup: MaskLookup) -> NDArray[np.float64]:
    count, _, width, channels = stored.textures.shape
    masks = lookup.values.shape[1]
    total = np.zeros((masks, count * (count + 1) // 2))
    differences = np.empty((width, channels, count), np.float32)
    mask = np.empty(masks, np.float32)
    products = np.empty(total.shape[1], np.float32)
    for y in range(top, bottom):
        differences_of_row(y, stored, differences)
        for x in range(width):
            begin, end = masks_at(lookup, y, x, mask)
            if begin == end:
                continue
            products[:] = 0
            for c in range(channels):
                d = differences[x, c]
                for n in range(count):
                    for m in range(n + 1):
                        products[n * (n + 1) // 2 + m] += d[n] * d[m]
            for j in range(begin, end):
                squared = mask[j - begin] * mask[j - begin]
                row = total[lookup.active[j]]
                for q in range(len(products)):
                    row[q] += squared * products[q]
    return total
