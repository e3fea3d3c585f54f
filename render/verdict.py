"""From errors to a sentence that a person acts on. What the limits mean and where they come from: docs/verdict.md."""

from collections.abc import Sequence

from render.documents.images import PackRender, Render
from render.limits import LEVELS, Level, Thresholds


def verdict(k: int, renders: Sequence[Render], thresholds: Thresholds) -> tuple[Level, str]:
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
    numbers = worst.packs[k]
    level = numbers.level
    if level == "identical":
        return level, "Identical: every rendered pixel is the same."
    place = f"{worst.expression}, {worst.view.replace('_', ' ')} view, {worst.light} light"
    where = f", most on the {numbers.where.region}" if numbers.where else ""
    doubt = "" if numbers.decided else f"; too close to the limit to tell with {worst.spp} samples a pixel"
    if level == "indistinguishable":
        most = [max(each) for each in zip(*(deciding(render.packs[k]) for render in renders), strict=True)]
        return (
            level,
            f"Indistinguishable: at most {_figures(most)} in {len(renders)} renders (worst {place}{where}){doubt}.",
        )
    figures = _figures(deciding(numbers))
    word, limit = ("Visible", thresholds.indistinguishable) if level == "visible" else ("Fails", thresholds.visible)
    often = sum(LEVELS.index(render.packs[k].level) >= LEVELS.index(level) for render in renders)
    allowed = f"limits {limit.delta_e:g}, {limit.local:g} and {limit.flip:g}"
    return (
        level,
        f"{word} at {place}{where}: {figures} ({allowed}); so in {often} of {len(renders)} renders{doubt}.",
    )


def deciding(numbers: PackRender) -> tuple[float, ...]:
    """The metrics of a render that a level is made of, in the order of :data:`render.limits.DECIDING`."""
    return numbers.delta_e_p95, numbers.delta_e_local, numbers.flip


def _figures(numbers: Sequence[float]) -> str:
    p95, local, flip = (f"{number:.2g}" for number in numbers)
    return f"dE2000 {p95} at the 95th percentile and {local} in the worst place, FLIP {flip}"


def worst_render(k: int, renders: Sequence[Render], thresholds: Thresholds) -> Render:
    """The render with the highest level, and of those the highest severity, of pack ``k``."""

    def badness(render: Render) -> tuple[int, float]:
        numbers = render.packs[k]
        return LEVELS.index(numbers.level), thresholds.severity(*deciding(numbers))

    return max(renders, key=badness)
