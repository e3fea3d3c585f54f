"""Is a render the one that the reference shows, but for noise? Statistics on pixels and blocks of pixels.

The difference of two means is divided by its standard error, for pixels and for the means of blocks: a gross error in
few pixels shows in the largest of these ratios, a small error in many pixels in the sum of their squares, and a small
error over a region in the ratios of the blocks that it covers.

Render noise is neither Gaussian nor independent from pixel to pixel: edges, fireflies, reconstruction filters. So every
probability is taken twice: from theory, and from how the statistic came out for each render of the reference against
all others. The larger of the two counts.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage, stats

# Sides of the blocks in pixels; blocks overlap by half.
SCALES = (1, 4, 8, 16)
STATISTICS = tuple(f"{kind}_{scale}" for kind in ("largest", "sum") for scale in SCALES)
# References are stored as half floats: eleven bits of numbers from 2^-14 on, and the same steps below.
HALF_BITS, HALF_SMALLEST = 11, 2.0**-14
# A ratio beyond this adds no more to a sum: single outliers are the business of the largest ratio.
OUTLIER = 4.0


@dataclass(frozen=True, eq=False)
class Ratios:
    """Differences over their standard errors at one scale.

    Attributes
    ----------
    values : ``(h, w, C)`` float64, one for every block and channel.
    freedom : ``(h, w, C)`` degrees of freedom of the standard errors.
    """

    values: NDArray[np.float64]
    freedom: NDArray[np.float64]


def rounding_of(mean: NDArray[np.floating]) -> NDArray[np.float64]:
    """Half the distance to the next half float: how far the value that was rounded may lie from ``mean``."""
    _, exponent = np.frexp(np.maximum(np.abs(mean), HALF_SMALLEST))
    return np.exp2(exponent - HALF_BITS - 1.0)


def noise_ratios(
    test: NDArray[np.floating],
    mean: NDArray[np.float64],
    variance: NDArray[np.float64],
    renders: int,
    reach: NDArray[np.float64] | None = None,
    ignored: NDArray[np.bool_] | None = None,
) -> dict[int, Ratios]:
    """The ratios at every scale.

    Parameters
    ----------
    test : ``(n, H, W, C)``, n ≥ 1 independent renders.
    mean, variance : ``(H, W, C)``: the reference, and the variance of a single render, as ``renders`` renders estimate
        them, at least 3.
    reach : ``(H, W, C)``: how far the true means of those renders may lie from ``mean``; None where they are it. Over
        a region of one value that is one error for all, so that a block's reach is the sum of its pixels'.
    ignored : ``(H, W)``: pixels that count for nothing, neither by their difference nor by their noise; blocks that
        hold no others have a ratio of 0.
    """
    kept = np.ones((*mean.shape[:2], 1))
    if ignored is not None:
        kept[ignored] = 0
    # A pixel is not trusted to be quieter than its neighbourhood: what it has not shown yet, its neighbours may have.
    smooth = ndimage.uniform_filter(kept * variance, (3, 3, 0), mode="nearest")
    share = 1 / len(test) + 1 / renders
    rounding = kept * np.square(rounding_of(mean))
    of_pixels = kept * share * np.maximum(variance, smooth) + rounding
    moved = kept * (test - mean)
    # Both say how noisy a block is: a rare event that the reference lacks is known by being in few renders of the test.
    weight, weight_test = (np.array([renders - 1, len(test) - 1]) / (renders + len(test) - 2)).tolist()
    ratios = {}
    for scale in SCALES:
        empty = block_sums(kept, scale) == 0
        total, squares = block_sums(of_pixels, scale) + empty, block_sums(np.square(of_pixels), scale) + empty
        sums = block_sums(moved, scale)
        own = share * sums.var(axis=0, ddof=1) + block_sums(rounding, scale) if len(test) > 1 else np.zeros_like(total)
        pooled = weight * total + weight_test * own
        # Welch and Satterthwaite: a sum of variances of unlike size counts as fewer estimates than it has terms.
        freedom = np.square(pooled) / (
            weight**2 * squares / (renders - 1) + weight_test**2 * np.square(own) / max(len(test) - 1, 1)
        )
        difference = sums.mean(axis=0)
        if reach is not None:
            difference -= np.clip(difference, -(within := block_sums(kept * reach, scale)), within)
        ratios[scale] = Ratios(difference / np.sqrt(pooled), freedom)
    return ratios


def block_sums(image: NDArray[np.float64], scale: int) -> NDArray[np.float64]:
    """Sums of ``(…, H, W, C)`` over blocks of ``scale`` pixels a side, one every half side; smaller at their ends."""
    step = max(scale // 2, 1)
    sums = image
    for axis in (-3, -2):
        sums = np.add.reduceat(sums, np.arange(0, image.shape[axis], step), axis=axis)
        if step < scale and sums.shape[axis] > 1:
            sums = sums.take(np.arange(sums.shape[axis] - 1), axis) + sums.take(np.arange(1, sums.shape[axis]), axis)
    return sums


def statistics(ratios: dict[int, Ratios]) -> dict[str, float]:
    """The largest ratio, and the mean square with outliers cut off, at every scale."""
    largest = {f"largest_{scale}": float(np.abs(of.values).max()) for scale, of in ratios.items()}
    sums = {
        f"sum_{scale}": float(np.square(np.clip(of.values, -OUTLIER, OUTLIER)).mean()) for scale, of in ratios.items()
    }
    return largest | sums


def normalised(name: str, values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Sums are made nearly Gaussian by a cube root (Wilson and Hilferty 1931); largest ratios stay."""
    return np.cbrt(values) if name.startswith("sum") else values


@dataclass(frozen=True)
class Spread:
    """Mean and standard deviation of a normalised statistic over ``count`` renders against all others."""

    mean: float
    deviation: float
    count: int

    def tail(self, name: str, value: float) -> float:
        """Probability of at least ``value``: a prediction by Gumbel's law for the largest, Student's for sums."""
        if self.deviation == 0:
            # Nothing varied: there is nothing to learn from.
            return 0.0
        score = (float(normalised(name, np.array(value))) - self.mean) / self.deviation
        score /= np.sqrt(1 + 1 / self.count)
        if name.startswith("sum"):
            return float(stats.t.sf(score, self.count - 1))
        # Bounded, lest its double exponential overflow.
        return float(stats.gumbel_r.sf(max(score * np.pi / np.sqrt(6) + np.euler_gamma, -100.0)))


def leave_one_out(renders: NDArray[np.float32], ignored: NDArray[np.bool_] | None = None) -> dict[str, Spread]:
    """How each statistic spreads when nothing differs: every one of ``(N, H, W, C)`` renders against the others."""
    count = len(renders)
    centre = renders.mean(axis=0, dtype=np.float64)
    moved = renders - centre
    total, squares = moved.sum(axis=0), np.square(moved).sum(axis=0)
    found = []
    for one in moved:
        mean = (total - one) / (count - 1)
        variance = np.maximum((squares - np.square(one)) / (count - 1) - np.square(mean), 0) * (count - 1) / (count - 2)
        ratios = noise_ratios((one + centre)[None], centre + mean, variance, count - 1, ignored=ignored)
        found.append(statistics(ratios))
    spreads = {}
    for name in STATISTICS:
        values = normalised(name, np.array([one[name] for one in found]))
        spreads[name] = Spread(float(values.mean()), float(values.std(ddof=1)), count)
    return spreads


def theoretical_tail(name: str, value: float, ratios: Ratios) -> float:
    """Probability of at least ``value`` if noise were Gaussian and independent: Šidák's for the largest, chi-square."""
    if name.startswith("sum"):
        # Where nothing is drawn both images are exactly equal: that is no noise that happened to be small.
        terms = max(int(np.count_nonzero(ratios.values)), 1)
        return float(stats.chi2.sf(value * ratios.values.size, terms))
    return float(ratio_probabilities(ratios).min())


def ratio_probabilities(ratios: Ratios) -> NDArray[np.float64]:
    """Two-sided probability ``(h, w, C)`` of each ratio by Student's law, corrected for their number (Šidák 1967)."""
    single = 2 * stats.t.sf(np.abs(ratios.values), ratios.freedom)
    return np.asarray(-np.expm1(ratios.values.size * np.log1p(-np.minimum(single, 1 - 1e-16))))


def probability(ratios: dict[int, Ratios], spreads: dict[str, Spread]) -> tuple[float, str]:
    """Probability that noise alone differs as much, corrected for the number of statistics; the least likely one.

    Of the statistics that ``spreads`` knows.
    """
    tails = {}
    for name, value in statistics(ratios).items():
        if name not in spreads:
            continue
        theory = theoretical_tail(name, value, ratios[int(name.rpartition("_")[2])])
        tails[name] = max(theory, spreads[name].tail(name, value))
    least = min(tails, key=lambda name: tails[name])
    return min(1.0, len(tails) * tails[least]), least
