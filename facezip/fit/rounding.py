"""How a fit ends: weights rounded to what a pack stores, and textures fitted, and rounded, to those."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from facezip.character.samples import Samples, thinned
from facezip.fit.sweep import solve_textures
from facezip.machine.rows import by_rows
from facezip.pack.quantise import STEPS, best_ranges, quantise_weights

# Of more texels a quarter tells the ranges of difference textures; of fewer, they depend on which.
MANY_TEXELS = 2**20


def as_stored(weights: NDArray[np.float32], ranges: NDArray[np.float32] | None = None) -> NDArray[np.float32]:
    """Weight maps ``(h, R, N, w)`` as a pack gives them back, ``(N, h, w, R)``; ``ranges`` as of
    :func:`facezip.pack.quantise.quantise_weights`.
    """
    turned = weights.transpose(2, 0, 3, 1)
    return quantise_weights(by_rows(lambda rows: turned[:, rows], turned.shape, np.float32, axis=1), ranges).values


def as_fitted(weights: NDArray[np.float32]) -> NDArray[np.float32]:
    """Weight maps ``(N, h, w, R)`` as fits have them, ``(h, R, N, w)``."""
    turned = weights.transpose(1, 3, 0, 2)
    return by_rows(lambda rows: turned[rows], turned.shape, np.float32)


def best_differences(
    samples: Samples, stored: NDArray[np.float32], locked: Mapping[int, NDArray[np.float32]] | None = None
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """The difference textures, rounded to what a pack stores, that fit best to stored weight maps ``(N, h, w, R)``.

    Textures ``(H, W, C)`` of ``locked`` slots stay as they are; their range says nothing.

    Returns
    -------
    differences : ``(R, H, W, C)``.
    ranges : ``(R, C)``, the largest value that each may take.
    """
    weights, locked = as_fitted(stored), locked or {}
    many = samples.importance.size > MANY_TEXELS
    some = thinned(samples, 2) if many else samples
    fewer = {slot: texture[1::2, 1::2] if many else texture for slot, texture in locked.items()}
    ranges = best_ranges(solve_textures(some, weights, locked=fewer), some.importance)
    return solve_textures(samples, weights, ranges / np.float32(STEPS), locked), ranges
