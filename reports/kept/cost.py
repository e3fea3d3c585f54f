"""Processor time as a multiple of a yardstick that runs before and after it, so that what else runs hits both."""

from collections.abc import Callable
from dataclasses import dataclass
from statistics import median
from time import process_time

REPEATS = 3
# A yardstick shorter than this is passed again.
SECONDS = 1.0


@dataclass(frozen=True)
class Cost:
    """What some work takes.

    Attributes
    ----------
    ratio : the median over repeats.
    spread : half of what lies between the least and the largest ratio, as a share of the median.
    """

    ratio: float
    spread: float


def cost(work: Callable[[], object], yardstick: Callable[[], object]) -> Cost:
    """Yardstick and work in turn; each ratio is to the yardsticks on both sides of it."""
    before, ratios = _mean(yardstick), []
    for _ in range(REPEATS):
        begin = process_time()
        work()
        seconds, after = process_time() - begin, _mean(yardstick)
        ratios.append(2 * seconds / (before + after))
        before = after
    ratio = median(ratios)
    return Cost(ratio, (max(ratios) - min(ratios)) / 2 / ratio)


def _mean(yardstick: Callable[[], object]) -> float:
    """Processor time of a pass."""
    begin, passes = process_time(), 0
    while passes == 0 or process_time() - begin < SECONDS:
        yardstick()
        passes += 1
    return (process_time() - begin) / passes
