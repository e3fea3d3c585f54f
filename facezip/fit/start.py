"""Where a refined fit starts: uniform weights, or principal components in a gauge that uses 8 bits well."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from facezip.character.samples import Samples
from facezip.fit.sweep import joint_system
from facezip.machine.rows import by_rows
from facezip.pack.sampling import bilinear_grid

# The gauge changes slowly: one is found for so many weight texels each way.
GAUGE = 4


def balanced_start(
    maps: Sequence[Samples], components: NDArray[np.float32], grid: tuple[int, int]
) -> NDArray[np.float32]:
    """Uniform weights ``(N, R)`` on a grid, in the gauge where W Wᵀ and D Dᵀ are alike at every place.

    Any invertible mixture of the slots changes nothing in equation (1); in this one neither weights nor textures have
    large values where the other is small, so that both use the few steps of 8 bits well. The fit stays near it.
    """
    count, slots = components.shape
    coarse = -(-grid[0] // GAUGE), -(-grid[1] // GAUGE)
    shape, flat = (coarse[0], slots, count, coarse[1]), uniform(components, coarse)
    energies = joint_system(maps, flat).matrix
    # How much the texels about each place count: the diagonal of one texture of ones.
    first = np.ascontiguousarray(flat[:, :1])
    texels = joint_system(maps, first, [_ones(samples) for samples in maps]).matrix[:, 0, 0, 4]
    floored = np.maximum(texels, 1e-3 * texels.max())

    def energy(rows: slice) -> NDArray[np.float32]:
        here: NDArray[np.float32] = energies[rows, :, :, 4].transpose(0, 3, 1, 2) / floored[rows, :, None, None]
        return here

    traces = by_rows(lambda rows: np.trace(energy(rows), axis1=2, axis2=3), coarse, np.float32)
    floor = max(1e-3 * traces.mean() / slots, 1e-30)

    def balanced(rows: slice) -> NDArray[np.float32]:
        values, vectors = np.linalg.eigh(energy(rows).astype(np.float64))
        root = np.power(np.maximum(values, 0) + floor, 0.25)
        gauge = (vectors * root[:, :, None, :]) @ vectors.swapaxes(2, 3)
        mixed: NDArray[np.float32] = np.einsum("hwij,hjnw->hinw", gauge.astype(np.float32), flat[rows])
        return mixed

    return _resampled(by_rows(balanced, shape, np.float32), grid)


def uniform(components: NDArray[np.float32], grid: tuple[int, int]) -> NDArray[np.float32]:
    """Uniform weights ``(N, R)`` on a grid, ``(h, R, N, w)``."""
    count, slots = components.shape
    row = components.T[None, :, :, None]
    return by_rows(lambda rows: row, (grid[0], slots, count, grid[1]), np.float32)


def _resampled(weights: NDArray[np.float32], grid: tuple[int, int]) -> NDArray[np.float32]:
    """Weights ``(h, R, N, w)`` on another grid, by bilinear sampling."""
    h, slots, count, w = weights.shape
    down, across = bilinear_grid(grid, (h, w))

    def sampled(rows: slice) -> NDArray[np.float32]:
        upper, lower = weights[down.first[rows]], weights[down.second[rows]]
        mixed = upper + down.fraction[rows, None, None, None] * (lower - upper)
        near: NDArray[np.float32] = mixed[..., across.first]
        return near + across.fraction * (mixed[..., across.second] - near)

    return by_rows(sampled, (grid[0], slots, count, grid[1]), np.float32)


def _ones(samples: Samples) -> NDArray[np.float32]:
    one, shape = np.ones(1, np.float32), (1, *samples.neutral.shape)
    return by_rows(lambda rows: one, shape, np.float32, axis=1)
