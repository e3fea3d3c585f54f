"""A neutral made of all scans: their mean where nothing moved, with the sharpness and the detail of the neutral's scan.

Every registered scan shows the neutral again, but for what its expression changes, and somewhat blurred, as it was
resampled. So their mean, each cell weighted by how well a scan agrees there, is sharpened by the small filter that
brings it nearest to the scanned neutral; and what the scanned neutral has beyond that comes back, band by band, as far
as it is more than the neutral's own noise: pores, which no mean of moving scans keeps, and all places that moved.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from facezip.character.scans import Stack
from facezip.cleaning.cells import CELL, cells_of
from facezip.cleaning.exposure import stored
from facezip.cleaning.filters import Filter
from facezip.cleaning.noise import Noise
from facezip.files.images import to_float
from facezip.machine import memory
from facezip.machine.rows import by_rows, sum_rows, write_rows

# Noise below this many steps of stored texels is their rounding: then the neutral is as good as any mean.
ROUNDING = 0.5
# Bands lie between these standard deviations of Gaussians, in texels; the neighbourhood that tells detail from noise.
BANDS = (0.7, 1.5, 3.0)
WINDOW = 3.0
# The neighbourhood whose contrast is kept, and by what factor at most it is corrected.
REGION, MOST_GAIN = 5.0, 1.5
UNSURE = 0.3
TRUNCATED = 3.0
# Texels that a place sees: of the filter, all bands, and both neighbourhoods.
HALO = 44
# Floats that a texel takes while its block is worked on.
VALUES = 16

Values = NDArray[np.float32]


@dataclass(frozen=True)
class Fused:
    """A stack with a better neutral.

    Attributes
    ----------
    stack : the scans with what resampling took of the detail.
    noise : standard deviation of the scanned neutral's noise at its mean brightness, 0..255.
    scans : how many scans' worth the mean is of, in the mean over the face.
    removed : root mean square of what was taken from the neutral, 0..255.
    """

    stack: Stack
    noise: float
    scans: float = 0.0
    removed: float = 0.0


def fused(stack: Stack) -> Fused:
    """A registered stack with its neutral made of all scans; as it was where noise is no more than rounding."""
    memory.check(VALUES * np.dtype(np.float32).itemsize * stack.resolution[1] * stack.channels)
    cells = cells_of(stack)
    noise = Noise.of(cells)
    brightness = cells.neutral.mean(axis=2)
    level = float(np.sqrt(noise.at(brightness[cells.face]).mean())) if cells.face.any() else 0.0
    step = 0.0 if stack.neutral.dtype.kind == "f" else float(stack.scale)
    if level <= ROUNDING * step:
        return Fused(stack, 255 * level)
    variance = np.maximum(noise.at(brightness), np.finfo(np.float32).tiny)
    # The neutral's noise is in every gap.
    weights = (1 / np.maximum(cells.gaps - variance, variance)).astype(np.float32)
    mean = _mean(stack, weights)
    scanned = to_float(stack.neutral)
    sharp = Filter.towards(mean, scanned, stack.weight)
    better = _with_detail(mean, scanned, sharp, noise)
    result = _restored(stack, better, Filter.towards(better, mean, stack.weight))
    worth = (variance * weights.sum(axis=0))[cells.face].mean()
    return Fused(result, 255 * level, float(worth), 255 * _distance(better, scanned, stack.weight))


def _distance(one: Values, other: Values, weight: NDArray[np.float32]) -> float:
    """Root mean square under a weight."""

    def sums(top: int, bottom: int) -> NDArray[np.float64]:
        squares = np.square(one[top:bottom] - other[top:bottom]).mean(axis=2, dtype=np.float64)
        return np.array([np.sum(weight[top:bottom] * squares), weight[top:bottom].sum(dtype=np.float64)])

    square, total = sum_rows(sums, len(one))
    return float(np.sqrt(square / max(total, np.finfo(np.float32).tiny)))


def _mean(stack: Stack, weights: NDArray[np.float32]) -> Values:
    """The mean of the scans ``(H, W, C)`` under the weights of cells ``(N, h, w)``, which change smoothly."""
    height, width = stack.resolution
    columns = np.clip((np.arange(width) + 0.5) / CELL - 0.5, 0, weights.shape[2] - 1)
    places = np.clip((np.arange(height) + 0.5) / CELL - 0.5, 0, weights.shape[1] - 1)

    def between(values: NDArray[np.float32], rows: slice) -> NDArray[np.float32]:
        y, x = places[rows], columns
        upper, left = (np.minimum(at.astype(int), size - 1) for at, size in zip((y, x), values.shape, strict=True))
        lower, right = np.minimum(upper + 1, values.shape[0] - 1), np.minimum(left + 1, values.shape[1] - 1)
        across = values[:, left] + (x - left).astype(np.float32) * (values[:, right] - values[:, left])
        found: NDArray[np.float32] = across[upper] + (y - upper).astype(np.float32)[:, None] * (
            across[lower] - across[upper]
        )
        return found[..., None]

    def mean(rows: slice) -> Values:
        total, count = np.zeros((1, 1, 1), np.float32), np.zeros((1, 1, 1), np.float32)
        for n, texture in enumerate(stack.textures):
            weight = between(weights[n], rows)
            total, count = total + weight * to_float(texture[rows]), count + weight
        return total / count

    return by_rows(mean, stack.neutral.shape, np.float32)


def _with_detail(mean: Values, scanned: Values, sharp: Filter, noise: Noise) -> Values:
    """The sharpened mean with what the scanned neutral has beyond it and beyond its noise."""
    shares = _noise_shares()

    def values(rows: slice) -> Values:
        padded = slice(max(rows.start - HALO, 0), min(rows.stop + HALO, len(mean)))
        base, own = sharp(mean[padded]), scanned[padded]
        variance, total = noise.at(own.mean(axis=2)), np.zeros_like(own)
        for smooth, full, share in zip(_split(base), _split(own), shares, strict=True):
            total += _band(smooth, full, share * variance)
        return np.clip(total[rows.start - padded.start : rows.stop - padded.start], 0, 1)

    return by_rows(values, mean.shape, np.float32)


def _band(smooth: Values, own: Values, noise: Values) -> Values:
    """A band of the mean with the detail of the scanned neutral's, at whose contrast it comes out."""
    gap = own - smooth
    power = np.maximum(_power(gap, WINDOW), np.finfo(np.float32).tiny)
    kept = smooth + np.sqrt(np.maximum(1 - noise / power, 0))[..., None] * gap
    # Where there is nothing but noise, no contrast is known.
    contrast = np.maximum(_power(own, REGION) - noise, 0) + UNSURE * noise
    gain = np.sqrt(contrast / np.maximum(_power(kept, REGION) + UNSURE * noise, np.finfo(np.float32).tiny))
    return np.clip(gain, 1 / MOST_GAIN, MOST_GAIN)[..., None] * kept


def _power(values: Values, width: float) -> Values:
    """The mean square around every texel, ``(H, W)``."""
    return _blurred(np.square(values).mean(axis=2), width)


def _restored(stack: Stack, neutral: Values, blur: Filter) -> Stack:
    """The stack with this neutral, its scans with the detail that a blur takes from it."""
    dtype, scale = stack.neutral.dtype, float(stack.scale)
    step = np.float32(1 / stack.scale)

    def detail(rows: slice) -> Values:
        padded = slice(max(rows.start - blur.radius, 0), min(rows.stop + blur.radius, len(neutral)))
        inner = slice(rows.start - padded.start, rows.stop - padded.start)
        return step * (neutral[padded] - blur(neutral[padded]))[inner]

    textures = memory.empty(stack.textures.shape, dtype)
    lost = by_rows(detail, neutral.shape, np.float32)
    for texture, out in zip(stack.textures, textures, strict=True):
        write_rows(lambda rows, texels=texture: stored(texels[rows] + lost[rows], dtype, scale), out)  # type: ignore[misc]
    better = by_rows(lambda rows: stored(step * neutral[rows], dtype, scale), neutral.shape, dtype)
    return replace(stack, neutral=better, textures=textures)


def _split(values: Values) -> list[Values]:
    """Bands ``(H, W, C)``, the finest first, that add up to the values."""
    bands = []
    for width in BANDS:
        smooth = _blurred(values, width)
        bands.append(values - smooth)
        values = smooth
    return [*bands, values]


def _blurred(values: Values, width: float) -> Values:
    smooth: Values = gaussian_filter(values, (width, width), mode="nearest", truncate=TRUNCATED, axes=(0, 1))
    return smooth


def _noise_shares() -> list[np.float32]:
    """The part of white noise's variance that is in each band."""
    impulse = np.zeros((2 * HALO + 1, 2 * HALO + 1, 1), np.float32)
    impulse[HALO, HALO] = 1
    return [np.float32(np.square(band).sum()) for band in _split(impulse)]
