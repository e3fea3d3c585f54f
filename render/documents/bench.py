"""What benchmarks of the renderer and of metrics measure."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class BothWays:
    """One run of both ways.

    Attributes
    ----------
    naive_s, paired_s : seconds of each.
    speedup : of the paired way.
    pairs_per_second : of original and pack, the paired way.
    """

    naive_s: float
    paired_s: float
    speedup: float
    pairs_per_second: float


@dataclass(frozen=True, kw_only=True)
class RenderBench(BothWays):
    """The run of median speedup.

    Attributes
    ----------
    images : that each way renders.
    runs : all of them.
    """

    images: int
    runs: Sequence[BothWays]


@dataclass(frozen=True, kw_only=True)
class Deviation:
    """Of a metric from the converged one, over all renders and packs: the mean, and the largest."""

    mean: float
    largest: float


@dataclass(frozen=True, kw_only=True)
class MetricsBench:
    """How true the metrics of few samples are.

    Attributes
    ----------
    deviation : by metric; relative for RMSE, FLIP and ΔE, absolute for SSIM. ``delta_e_p95_plain`` is the 95th
        percentile with the bias of noise.
    render_s, metrics_s : seconds a render with the fewer samples.
    """

    deviation: Mapping[str, Deviation]
    render_s: float
    metrics_s: float
