"""How much a render may differ: levels, and where one ends and the next begins (docs/verdict.md)."""

from dataclasses import dataclass
from typing import Literal, get_args

# The metrics that a level is made of.
DECIDING = ("delta_e_p95", "delta_e_local", "flip")
Level = Literal["identical", "indistinguishable", "visible", "fails"]
LEVELS: tuple[Level, ...] = get_args(Level)


@dataclass(frozen=True)
class Limit:
    """The most that a render may differ.

    Attributes
    ----------
    delta_e, flip : 95th percentile of ΔE2000 and mean FLIP over head pixels.
    local : largest mean of ΔE2000 over a small window: a spoilt mouth is less than 5 % of a head.
    """

    delta_e: float
    local: float
    flip: float


@dataclass(frozen=True)
class Thresholds:
    """Where one level ends and the next begins.

    Attributes
    ----------
    indistinguishable : up to here nobody tells the images apart side by side.
    visible : up to here it takes a comparison to see the difference; beyond, it is plain.
    """

    indistinguishable: Limit = Limit(1.0, 2.0, 0.05)
    visible: Limit = Limit(3.0, 6.0, 0.10)

    def level(self, delta_e: float, local: float, flip: float) -> Level:
        """The level of a render with these errors."""
        if delta_e == local == flip == 0:
            return "identical"
        if self.severity(delta_e, local, flip) <= 1:
            return "indistinguishable"
        return "visible" if _excess(self.visible, delta_e, local, flip) <= 1 else "fails"

    def severity(self, delta_e: float, local: float, flip: float) -> float:
        """The largest of the errors over its limit of indistinguishability."""
        return _excess(self.indistinguishable, delta_e, local, flip)


def _excess(limit: Limit, delta_e: float, local: float, flip: float) -> float:
    return max(delta_e / limit.delta_e, flip / limit.flip, local / limit.local)


DEFAULT_THRESHOLDS = Thresholds()
