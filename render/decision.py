"""What a verdict is made of, and how sure it is: deciding metrics without the bias of noise, and their intervals.

Noise scatters a metric and biases it. A bias falls with the number of samples, so twice the metric of the whole minus
the mean of its halves is free of it to first order (Quenouille's jackknife), and the halves' difference tells the
scatter. Both are small where original and compressed textures are shaded on the same paths.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from render.documents.images import ImageMetrics, Judgement
from render.limits import DECIDING, Level, Thresholds
from render.metrics import Picture, perceived

# Student's t for a two-sided interval of 95 % from two values.
_REACH = 12.706

# A picture of the original and one of a candidate, from the same half of the samples.
Half = tuple[Picture, Picture]


def unbiased(whole: float, halves: Sequence[float]) -> float:
    """A metric as converged images would have it, given it with all and with each half's samples; may fall below 0."""
    return 2 * whole - sum(halves) / 2


def interval(whole: float, halves: Sequence[float]) -> tuple[float, float]:
    """Where a metric of converged images lies with 95 % confidence, around :func:`unbiased`."""
    centre, reach = unbiased(whole, halves), _REACH * abs(halves[0] - halves[1]) / 2
    return max(centre - reach, 0.0), max(centre + reach, 0.0)


def of_halves(halves: Sequence[Half]) -> dict[str, list[float]]:
    """Every deciding metric of each half."""
    found = [perceived(*half) for half in halves]
    return {name: [each[name] for each in found] for name in DECIDING}


def without_bias(metrics: ImageMetrics, of_each: Mapping[str, Sequence[float]]) -> dict[str, float]:
    """The deciding metrics of a render, :func:`unbiased` and at least 0."""
    return {name: max(unbiased(getattr(metrics, name), halves), 0.0) for name, halves in of_each.items()}


def judge(metrics: ImageMetrics, halves: Sequence[Half], thresholds: Thresholds) -> Judgement:
    """The deciding metrics without bias, the level that they have, their intervals, and whether both ends agree.

    Parameters
    ----------
    metrics : of the render with all samples.
    halves : of the same render.
    """
    of_each = of_halves(halves)
    values = without_bias(metrics, of_each)
    found = {name: interval(getattr(metrics, name), each) for name, each in of_each.items()}
    ends = [thresholds.level(*(found[name][end] for name in DECIDING)) for end in range(2)]
    level = thresholds.level(*(values[name] for name in DECIDING))
    same = all(getattr(metrics, name) == 0 for name in DECIDING)
    return Judgement(
        **values,
        level=level if same else _acceptable(level),
        decided=_acceptable(ends[0]) == _acceptable(ends[1]),
        interval={name: (float(low), float(high)) for name, (low, high) in found.items()},
    )


def _acceptable(level: Level) -> Level:
    """No limit divides identical from indistinguishable."""
    return "indistinguishable" if level == "identical" else level


def stream(seed: int, *position: int) -> int:
    """The random seed at a position (round, half, repeat) of a run: the same each time, unlike all others."""
    return int(np.random.SeedSequence([seed, *position]).generate_state(1)[0])
