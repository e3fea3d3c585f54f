"""From errors to a sentence that a person acts on. What the limits mean and where they come from: docs/verdict.md."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

# The metrics that a level is made of.
DECIDING = ("delta_e_p95", "delta_e_local", "flip")
LEVELS = ("identical", "indistinguishable", "visible", "fails")


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

    def level(self, delta_e: float, local: float, flip: float) -> str:
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


def verdict(k: int, renders: Sequence[dict[str, Any]], thresholds: Thresholds) -> tuple[str, str]:
    """Judge pack ``k`` by its worst render.

    Parameters
    ----------
    renders : as in the validation document.

    Returns
    -------
    level : one of :data:`LEVELS`.
    sentence : the same for a person: at which expression, view and light, where on the face, by how much, how often.
    """
    worst = worst_render(k, renders, thresholds)
    numbers = worst["packs"][k]
    level = numbers["level"]
    if level == "identical":
        return level, "Identical: every rendered pixel is the same."
    place = f"{worst['expression']}, {worst['view'].replace('_', ' ')} view, {worst['light']} light"
    where = f", most on the {numbers['where']['region']}" if numbers["where"] else ""
    doubt = "" if numbers["decided"] else f"; too close to the limit to tell with {worst['spp']} samples a pixel"
    if level == "indistinguishable":
        most = {name: max(render["packs"][k][name] for render in renders) for name in DECIDING}
        return (
            level,
            f"Indistinguishable: at most {_figures(most)} in {len(renders)} renders (worst {place}{where}){doubt}.",
        )
    word, limit = ("Visible", thresholds.indistinguishable) if level == "visible" else ("Fails", thresholds.visible)
    often = sum(LEVELS.index(render["packs"][k]["level"]) >= LEVELS.index(level) for render in renders)
    allowed = f"limits {limit.delta_e:g}, {limit.local:g} and {limit.flip:g}"
    return (
        level,
        f"{word} at {place}{where}: {_figures(numbers)} ({allowed}); so in {often} of {len(renders)} renders{doubt}.",
    )


def _figures(numbers: Mapping[str, float]) -> str:
    p95, local, flip = (f"{numbers[name]:.2g}" for name in DECIDING)
    return f"dE2000 {p95} at the 95th percentile and {local} in the worst place, FLIP {flip}"


def worst_render(k: int, renders: Sequence[dict[str, Any]], thresholds: Thresholds) -> dict[str, Any]:
    """The render with the highest level, and of those the highest severity, of pack ``k``."""

    def badness(render: dict[str, Any]) -> tuple[int, float]:
        numbers = render["packs"][k]
        return LEVELS.index(numbers["level"]), thresholds.severity(*(numbers[name] for name in DECIDING))

    return max(renders, key=badness)
