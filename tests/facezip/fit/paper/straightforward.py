"""The paper's method as it is written down: dense masks, k-means on pixels, cost (3) evaluated on pixels.

Slow and plain, to test the fast version against. ``python -m tests.facezip.fit.paper.straightforward`` times
both on the same character and prints their seconds, their ratio and whether their results are the same.
"""

import argparse
import warnings
from dataclasses import dataclass
from itertools import permutations
from time import perf_counter

import numpy as np
from scipy.sparse.linalg import spsolve
from scipy.spatial.distance import cdist
from sklearn.cluster import KMeans, kmeans_plusplus
from sklearn.exceptions import ConvergenceWarning

from facezip import compress
from facezip.character.raster import rasterise
from facezip.fit.paper.factorise import cluster_shares, difference_textures
from facezip.fit.paper.fragments import best_of, cluster_fragments, masked_gram
from facezip.fit.paper.masks import RINGING, _laplacian, compute_masks, face_region, poisson_disk_samples
from facezip.fit.paper.paircosts import pair_costs
from facezip.fit.paper.stitching import search
from tests.facezip.conftest import ALBEDO_KEY, random_character

STARTS = 10
SWEEPS = 10


@dataclass
class Solution:
    masks: np.ndarray  # (K, H, W)
    labels: np.ndarray  # (K, N)
    permutation: np.ndarray  # (K, 4)
    cost: float
    differences: np.ndarray  # (4, H, W, C)
    weights: np.ndarray  # (N, H, W, 4)


def paper(character, count, restarts, seed, clusters=4):
    masks = dense_masks(character, count, seed)
    labels = np.stack([cluster(fragments(character, mask), clusters, seed, k) for k, mask in enumerate(masks)])
    pairs = pair_pixels(character, masks, labels, clusters)
    permutation, cost = stitch(pairs, count, clusters, restarts, seed)
    return Solution(masks, labels, permutation, cost, *factorise(character, masks, labels, permutation))


def dense_masks(character, count, seed):
    """One solve a mask, kept at full resolution, normalised to sum to one."""
    raster = rasterise(character.meshes.topology, character.first.resolution)
    region = face_region(character, character.first, raster)
    samples = poisson_disk_samples(character.meshes.neutral, region, count, seed)
    faces = character.meshes.topology.faces
    laplacian = _laplacian(faces[region[faces].all(axis=1)], len(region))
    bilaplacian = (laplacian.T @ laplacian).tocsc()
    free = np.setdiff1d(np.flatnonzero(region), samples)
    masks = []
    for sample in samples:
        phi = np.zeros(len(region))
        phi[sample] = 1
        phi[free] = spsolve(bilaplacian[free][:, free], -bilaplacian[free][:, [sample]].toarray().ravel())
        masks.append(raster.interpolate(np.where(phi > RINGING, phi, 0)))
    total = np.sum(masks, axis=0)
    return np.divide(masks, total, out=np.zeros((count, *total.shape)), where=total > 0)


def differences_to_neutral(character):
    return np.stack([character.texture(name) for name in character.expressions]) - character.texture("neutral")


def fragments(character, mask):
    """Equation (2), the texels where the mask is not zero: (N, P * C)."""
    inside = mask > 0
    return (differences_to_neutral(character)[:, inside] * mask[inside][:, None]).reshape(
        len(character.first.textures), -1
    )


def cluster(pixels, clusters, seed, number):
    random = np.random.RandomState(seed)
    fits = [cluster_from(pixels, kmeans_plusplus(pixels, clusters, random_state=random)[1]) for _ in range(STARTS)]
    return best_of(fits, pixels, np.random.default_rng([seed, number]))


def cluster_from(pixels, start):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        return KMeans(len(start), init=pixels[start], n_init=1, algorithm="lloyd").fit(pixels)


def centres(character, mask, labels, clusters):
    """The four fragments of a mask, the means of its clusters: (4, H, W, C)."""
    masked = differences_to_neutral(character) * mask[:, :, None]
    empty = np.zeros_like(masked[0])
    return np.stack([masked[labels == a].mean(axis=0) if (labels == a).any() else empty for a in range(clusters)])


def pair_pixels(character, masks, labels, clusters):
    """Equation (4) for every pair of masks that overlap: the four fragments of either, times the other's mask."""
    parts = [centres(character, mask, label, clusters) for mask, label in zip(masks, labels, strict=True)]
    pairs = {}
    for k in range(len(masks)):
        for other in range(len(masks)):
            overlap = (masks[k] > 0) & (masks[other] > 0)
            if k != other and overlap.any():
                seen = parts[k][:, overlap] * masks[other][overlap][:, None]
                pairs[k, other] = seen.reshape(clusters, -1)
    return pairs


def stitching_cost(pairs, permutation):
    """Equation (3)."""
    return sum(
        np.sum((pairs[k, other][permutation[k]] - pairs[other, k][permutation[other]]) ** 2) for k, other in pairs
    )


def stitch(pairs, count, slots, restarts, seed):
    """Coordinate descent over all permutations of a mask, on pixels; stops early where a sweep changes nothing."""
    orders = np.array(list(permutations(range(slots))))
    begin = orders[np.random.default_rng(seed).integers(0, len(orders), (restarts, count))]
    neighbours = [[other for other in range(count) if (k, other) in pairs] for k in range(count)]
    best, lowest = None, np.inf
    for permutation in begin:
        for _ in range(SWEEPS):
            before = permutation.copy()
            for k in range(count):
                apart = np.zeros((slots, slots))
                for other in neighbours[k]:
                    apart += cdist(pairs[other, k][permutation[other]], pairs[k, other], "sqeuclidean")
                permutation[k] = orders[np.argmin([apart[np.arange(slots), order].sum() for order in orders])]
            if (permutation == before).all():
                break
        cost = stitching_cost(pairs, permutation)
        if cost < lowest:
            best, lowest = permutation, cost
    return best, lowest


def factorise(character, masks, labels, permutation):
    """Equations (5) and (6), weight maps at full resolution."""
    slots = permutation.shape[1]
    textures = np.zeros((slots, *character.first.neutral.shape))
    weights = np.zeros((len(character.first.textures), *character.first.resolution, slots))
    for mask, label, order in zip(masks, labels, permutation, strict=True):
        textures += centres(character, mask, label, slots)[order]
        for i in range(slots):
            weights[label == order[i], :, :, i] += mask
    return textures, weights


def fast(character, count, restarts, seed):
    stack, masks = character.first, compute_masks(character, count, seed)[ALBEDO_KEY]
    labels = cluster_fragments(masked_gram(stack, masks), 4, seed)
    stitching = search(pair_costs(stack, masks, labels, 4), restarts, seed)
    shares, _ = cluster_shares(labels, stitching.permutation)
    return labels, stitching, difference_textures(stack, masks, shares)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--resolution", type=int, default=512)
    parser.add_argument("--expressions", type=int, default=20)
    parser.add_argument("--masks", type=int, default=53)
    parser.add_argument("--restarts", type=int, default=100)
    asked = parser.parse_args()
    compress(random_character(grid=20), masks=5, restarts=2)  # compiles the kernels
    character = random_character(expressions=asked.expressions, side=asked.resolution, grid=60)
    start = perf_counter()
    labels, stitching, textures = fast(character, asked.masks, asked.restarts, 0)
    middle = perf_counter()
    plain = paper(character, asked.masks, asked.restarts, 0)
    end = perf_counter()
    print(f"fast             {middle - start:8.2f} s   cost {stitching.cost:.6f}")
    print(f"straightforward  {end - middle:8.2f} s   cost {plain.cost:.6f}")
    print(f"ratio            {(end - middle) / (middle - start):8.1f}")
    print(f"same clusters    {np.array_equal(labels, plain.labels)}")
    print(f"same permutation {np.array_equal(stitching.permutation, plain.permutation)}")
    print(f"textures differ by at most {np.abs(textures - plain.differences).max():.2e} of 1")


if __name__ == "__main__":
    main()
