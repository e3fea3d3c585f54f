"""What a user would pick instead: principal components with the neutral as mean (the paper's baseline)."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from facezip.character.samples import Samples, Stored, stored_texels
from facezip.character.scans import Stack
from facezip.fit.paper.fragments import differences_of_row
from facezip.machine import memory
from facezip.machine.kernels import kernel
from facezip.machine.rows import map_rows, sum_rows


def principal_weights(maps: Sequence[Samples], count: int) -> NDArray[np.float32]:
    """Weights ``(N, k)`` of the ``count`` leading components: orthonormal columns, the most important first.

    Several maps, or tiles, have their components together: Gram matrices add.
    """
    _, vectors = np.linalg.eigh(sum(difference_gram(samples) for samples in maps))
    leading = vectors[:, ::-1][:, :count].astype(np.float32)
    # The sign of an eigenvector is free: make its largest entry positive, so that every machine agrees.
    signs: NDArray[np.float32] = np.sign(leading[np.abs(leading).argmax(axis=0), np.arange(leading.shape[1])])
    return np.ascontiguousarray(leading * signs)


def larger_sides(components: NDArray[np.float32]) -> NDArray[np.float32]:
    """Weights ``(N, k)`` ≥ 0 to start from: the positive or the negative side of each component, whichever is larger.

    As in Boutsidis & Gallopoulos, SVD based initialization: A head start for nonnegative matrix factorization, 2008.
    """
    sides = np.stack([np.maximum(components, 0), np.maximum(-components, 0)])
    larger = np.square(sides).sum(axis=1).argmax(axis=0)
    weights: NDArray[np.float32] = np.take_along_axis(sides, larger[None, None], axis=0)[0]
    return weights


def difference_gram(samples: Samples) -> NDArray[np.float64]:
    """``(N, N)``: Σ_p m(p) ⟨D_n(p), D_m(p)⟩ with D_n = I_n - I_0 in [0, 1] and the texels' importance m."""

    def block(top: int, bottom: int) -> NDArray[np.float64]:
        return _gram(top, bottom, samples.stored, samples.importance)

    lower = sum_rows(block, len(samples.neutral))
    gram: NDArray[np.float64] = np.tril(lower) + np.tril(lower, -1).T
    return gram


def combine_differences(stack: Stack, mixture: NDArray[np.float32]) -> NDArray[np.float32]:
    """Linear combinations of the differences: ``(R, H, W, C)`` from ``(R, N)`` coefficients."""
    height, width = stack.resolution
    out: NDArray[np.float32] = memory.empty((len(mixture), height, width, stack.neutral.shape[2]), np.float32)
    stored, mixture = stored_texels(stack), np.ascontiguousarray(mixture)

    def block(top: int, bottom: int) -> None:
        _combine(top, bottom, stored, mixture, out)

    map_rows(block, height)
    return out


@kernel()
def _gram(top: int, bottom: int, stored: Stored, importance: NDArray[np.float32]) -> NDArray[np.float64]:
    count, _, width, channels = stored.textures.shape
    total = np.zeros((count, count))
    differences = np.empty((width, channels, count), np.float32)
    for y in range(top, bottom):
        differences_of_row(y, stored, differences)
        for x in range(width):
            for c in range(channels):
                d = differences[x, c]
                for n in range(count):
                    weighted = importance[y, x] * d[n]
                    for m in range(n + 1):
                        total[n, m] += weighted * d[m]
    return total


@kernel()
def _combine(top: int, bottom: int, stored: Stored, mixture: NDArray[np.float32], out: NDArray[np.float32]) -> None:
    count, _, width, channels = stored.textures.shape
    differences = np.empty((width, channels, count), np.float32)
    for y in range(top, bottom):
        differences_of_row(y, stored, differences)
        for x in range(width):
            for i in range(len(mixture)):
                for c in range(channels):
                    total = np.float32(0)
                    for n in range(count):
                        total += mixture[i, n] * differences[x, c, n]
                    out[i, y, x, c] = total
