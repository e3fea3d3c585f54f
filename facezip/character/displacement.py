"""The smooth displacement between two images, in texels, and how sure it is.

The displacement u that minimises Σ_p w(p) (I_0(p) - I_n(p + u(p)))² is found by Gauss-Newton steps in windows, coarse
to fine (Lucas and Kanade 1981), on what remains of log luminance when its local mean is taken away: neither light nor
blood moves it. Wrinkles are structure that the neutral has not: robust weights leave out most of it, and as slopes are
the neutral's alone, the rest is uncorrelated with them.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, uniform_filter

from facezip.machine.kernels import inner, kernel
from facezip.machine.rows import by_rows

# Displacements are found on so many windows a side ...
GRID = 32
# ... in so many steps a level of the pyramid.
STEPS = 3
# A pyramid level: how much smaller its image is, and the standard deviation of its windows in cells of the grid.
LEVELS = ((8, 4.0), (4, 3.0), (2, 2.0), (1, 1.25))
# Images of fewer rows or columns than this tell nothing.
SMALLEST = 4
# A displacement counts as known where its expected error is well below this many texels of the reduced texture.
TOLERANCE = 0.25
# Residuals of neighbouring texels are not independent: so many count as one.
CORRELATED = 16
# Side of the neighbourhood whose mean is taken away, in texels of a level.
NEIGHBOURHOOD = 9
# Added to values in [0, 1] before the logarithm, so that the noise of black texels does not count.
DARK = 0.05


class Still(NamedTuple):
    """An image ``(H, W)`` that the others are laid on, and its slopes down and to the right."""

    image: NDArray[np.float32]
    down: NDArray[np.float32]
    across: NDArray[np.float32]


def pyramid(luminance: NDArray[np.float32], scale: np.float32) -> list[NDArray[np.float32]]:
    """Log luminance without its local mean, at every level: a gain of the exposure changes nothing."""
    levels = [means(luminance[:, :, None], step) for step in levels_of(luminance)]
    logs = [np.log(level * scale + np.float32(DARK)) for level in levels]
    return [log - uniform_filter(log, NEIGHBOURHOOD) for log in logs]


def levels_of(image: NDArray[np.float32]) -> list[int]:
    """How much smaller the levels of a pyramid are, the smallest first."""
    return [step for step, _ in LEVELS if min(image.shape) >= SMALLEST * step]


def displaced(
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


def reduced(texels: NDArray[Any], factor: int) -> NDArray[np.float32]:
    """The mean ``(H / factor, W / factor)`` over channels and blocks of factor x factor; a part block is left out.

    Of a texture that may live in a file, and goes by rows; :func:`means` is the same of what is in memory.
    """
    shape = texels.shape[0] // factor, texels.shape[1] // factor
    return by_rows(lambda rows: means(texels[rows.start * factor : rows.stop * factor], factor), shape, np.float32)


@kernel()
def means(texels: NDArray[np.uint8], factor: int) -> NDArray[np.float32]:
    """:func:`reduced` of texels ``(H, W, C)`` in memory."""
    height, width, channels = texels.shape
    out = np.empty((height // factor, width // factor), np.float32)
    share, many = np.float32(1 / (factor * factor * channels)), factor * channels
    # Sums of columns fill vector registers; those of blocks, a few values each, do not.
    columns = np.empty(out.shape[1] * many, np.float32)
    for y in range(out.shape[0]):
        columns[:] = 0
        for j in range(y * factor, (y + 1) * factor):
            row = texels[j].reshape(-1)
            for k in range(len(columns)):
                columns[k] += np.float32(row[k])
        for x in range(out.shape[1]):
            total = np.float32(0)
            for k in range(x * many, (x + 1) * many):
                total += columns[k]
            out[y, x] = total * share
    return out


def cells_of(weight: NDArray[np.float32]) -> NDArray[np.float32]:
    """The mean weight of every cell of the grid."""
    rows, columns = (np.arange(size) * GRID // size for size in weight.shape)
    cell = (rows[:, None] * GRID + columns).ravel()
    total, count = np.bincount(cell, weight.ravel(), GRID**2), np.bincount(cell, minlength=GRID**2)
    return (total / np.maximum(count, 1)).astype(np.float32).reshape(GRID, GRID)


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
