"""A smooth displacement between images, and how sure it is.

The displacement u that minimises Σ_p w(p) (I_0(p) - I_n(p + u(p)))² is found by Gauss-Newton steps in windows, coarse
to fine (Lucas and Kanade 1981).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from facezip.character.alignment import GRID
from facezip.character.pyramids import LEVELS
from facezip.machine.kernels import inner, kernel

# Of each level.
STEPS = 3
# A displacement counts as known where its expected error is well below this many texels of the reduced texture.
TOLERANCE = 0.25
# Residuals of neighbouring texels are not independent: so many count as one.
CORRELATED = 16


class Still(NamedTuple):
    """An image ``(H, W)`` that the others are laid on, and its slopes down and to the right."""

    image: NDArray[np.float32]
    down: NDArray[np.float32]
    across: NDArray[np.float32]


def registered(
    fixed: list[Still],
    moving: list[NDArray[np.float32]],
    weights: list[NDArray[np.float32]],
) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
    """Displacement ``(GRID, GRID, 2)`` in texels of the finest level, and how far to trust it ``(GRID, GRID)``.

    ``fixed``, ``moving`` and ``weights`` are one a level.
    """
    displacement = np.zeros((GRID, GRID, 2), np.float32)
    certainty = np.zeros((GRID, GRID))
    levels = LEVELS[len(LEVELS) - len(fixed) :]
    for (step, window), still, other, weight in zip(levels, fixed, moving, weights, strict=True):
        spread = float(np.average((still.image - other) ** 2, weights=weight)) + 1e-12
        for _ in range(STEPS):
            sums = np.zeros((GRID, GRID, 7))
            _normal_equations(still, other, weight, displacement / step, spread, sums)
            sums = gaussian_filter(sums, (window, window, 0), mode="constant")
            move, certainty = _solved(sums)
            displacement += (step * np.clip(move, -1, 1)).astype(np.float32)
            spread = float(sums[..., 5].sum() / max(sums[..., 6].sum(), 1e-12)) + 1e-12
    return displacement, certainty


def _solved(sums: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """A Gauss-Newton step for every window ``(GRID, GRID, 2)``, and how far to trust it, 0..1.

    A little is added to the structure tensor: where it says nothing, nothing moves.
    """
    xx, xy, yy, bx, by, squares, count = np.moveaxis(sums, 2, 0)
    floor = 0.02 * (xx + yy).mean()
    xx, yy = xx + floor, yy + floor
    determinant = xx * yy - xy * xy + 1e-30
    move = np.stack([yy * bx - xy * by, xx * by - xy * bx], axis=2) / determinant[:, :, None]
    least = (xx + yy) / 2 - np.sqrt(((xx - yy) / 2) ** 2 + xy**2) - floor
    variance = squares / np.maximum(count, 1e-9) / np.maximum(least, 1e-12)
    return move, TOLERANCE**2 / (TOLERANCE**2 + CORRELATED * variance)


@kernel(error_model="numpy")
def _normal_equations(
    still: Still,
    other: NDArray[np.float32],
    weight: NDArray[np.float32],
    displacement: NDArray[np.float32],
    spread: float,
    sums: NDArray[np.float64],
) -> None:
    """Add to every cell: Σw gx², Σw gx gy, Σw gy², Σw gx r, Σw gy r, Σw r², Σw; w falls with the residual r."""
    height, width = still.image.shape
    cells = displacement.shape[0]
    for y in range(1, height - 1):
        gy = (y + 0.5) * cells / height - 0.5
        for x in range(1, width - 1):
            if weight[y, x] <= 0:
                continue
            gx = (x + 0.5) * cells / width - 0.5
            at_x = x + bilinear(displacement[:, :, 0], gx, gy)
            at_y = y + bilinear(displacement[:, :, 1], gx, gy)
            residual = still.image[y, x] - bilinear(other, at_x, at_y)
            trust = weight[y, x] * spread / (spread + residual * residual)
            across, down = still.across[y, x], still.down[y, x]
            cell = sums[y * cells // height, x * cells // width]
            cell[0] += trust * across * across
            cell[1] += trust * across * down
            cell[2] += trust * down * down
            cell[3] += trust * across * residual
            cell[4] += trust * down * residual
            cell[5] += trust * residual * residual
            cell[6] += trust


@inner(inline="always")
def bilinear(image: NDArray[np.float32], x: float, y: float) -> float:
    """The value of ``(H, W)`` at a place in texels, clamped to the edge."""
    x = min(max(x, 0.0), image.shape[1] - 1.0)
    y = min(max(y, 0.0), image.shape[0] - 1.0)
    left, top = min(int(x), image.shape[1] - 2), min(int(y), image.shape[0] - 2)
    fx, fy = x - left, y - top
    upper = (1 - fx) * image[top, left] + fx * image[top, left + 1]
    lower = (1 - fx) * image[top + 1, left] + fx * image[top + 1, left + 1]
    return (1 - fy) * upper + fy * lower
