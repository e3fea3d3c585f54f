"""How sure a verdict is: intervals for its deciding metrics, from two independent halves of the samples.

Noise scatters a metric and biases it. A bias falls with the number of samples, so twice the metric of the whole minus
the mean of its halves is free of it to first order (Quenouille's jackknife), and the halves' difference tells the
scatter. Both are small where original and compressed textures are shaded on the same paths.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from render.metrics import Picture, delta_e_local, delta_e_p95, mean_flip
from render.verdict import DECIDING, Thresholds

# Student's t for a two-sided interval of 95 % from two values.
_REACH = 12.706


def interval(whole: float, halves: Sequence[float]) -> tuple[float, float]:
    """Where a metric of converged images lies with 95 % confidence, given it with all and with each half's samples."""
    first, second = halves
    centre, reach = 2 * whole - (first + second) / 2, _REACH * abs(first - second) / 2
    return max(centre - reach, 0.0), max(centre + reach, 0.0)


def judge(
    metrics: dict[str, Any], originals: Sequence[Picture], others: Sequence[Picture], thresholds: Thresholds
) -> dict[str, Any]:
    """The level of a render, the intervals of its deciding metrics, and whether both ends of them agree on the level.

    Parameters
    ----------
    metrics : of the render with all samples.
    originals, others : the halves, of the original and of a candidate.
    """
    measures = {"delta_e_p95": delta_e_p95, "flip": mean_flip, "delta_e_local": delta_e_local}
    found = {
        name: interval(metrics[name], [measure(a, b) for a, b in zip(originals, others, strict=True)])
        for name, measure in measures.items()
    }
    ends = [thresholds.level(*(found[name][end] for name in DECIDING)) for end in range(2)]
    return {
        "level": thresholds.level(*(metrics[name] for name in DECIDING)),
        "decided": _acceptable(ends[0]) == _acceptable(ends[1]),
        "interval": {name: list(map(float, ends)) for name, ends in found.items()},
    }


def _acceptable(level: str) -> str:
    """No limit divides identical from indistinguishable."""
    return "indistinguishable" if level == "identical" else level


def stream(seed: int, *position: int) -> int:
    """The random seed at a position (round, half, repeat) of a run: the same each time, unlike all others."""
    return int(np.random.SeedSequence([seed, *position]).generate_state(1)[0])
