"""An image against every reference that is accepted: it agrees if it agrees with one."""

from dataclasses import dataclass

from numpy import float32
from numpy.typing import NDArray

from render.plugin.baseline import Baseline
from render.plugin.call import Call
from render.plugin.ignoring import ignored_pixels
from render.plugin.reference import Comparison, Reference
from render.plugin.results import Compared
from render.plugin.sources import renders_of
from render.plugin.words import size, worst_place


@dataclass(frozen=True, eq=False)
class Judged:
    """The reference that an image is most like.

    Attributes
    ----------
    reference : itself.
    path : its file.
    comparison : with it, or None where the image has another size.
    level : probability below which the two differ.
    renders : independent renders of the image.
    accepted : how many references there are.
    mismatch : in words, why there is no comparison, or "".
    """

    reference: Reference
    path: str
    comparison: Comparison | None
    level: float
    renders: int
    accepted: int = 1
    mismatch: str = ""

    @property
    def probability(self) -> float:
        """That noise alone differs as much."""
        return self.comparison.probability if self.comparison else 0.0

    @property
    def differs(self) -> bool:
        """By more than noise."""
        return self.probability < self.level

    @property
    def compared(self) -> Compared | None:
        """What a result says of it; None where there is no comparison."""
        if self.comparison is None:
            return None
        return Compared(
            probability=self.probability,
            statistic=self.comparison.statistic,
            renders=self.renders,
            accepted=self.accepted,
            place=worst_place(self.comparison, self.reference),
        )


def judged(call: Call, baseline: Baseline, names: list[str]) -> Judged:
    """Compare the image of a call with the references of these names, the usual one first, until it agrees with one.

    Raises
    ------
    FaceZipError
        What reading references and rendering raise.
    """
    renders = renders_of(call.source, range(call.renders), call.spp)
    best: Judged | None = None
    for name in names:
        found = against(call, renders, baseline.read(name), str(baseline.path(name)), len(names))
        if best is None or found.probability > best.probability:
            best = found
        if not best.differs:
            break
    if best is None:
        raise ValueError("there is nothing to compare with")
    return best


def against(call: Call, renders: NDArray[float32], reference: Reference, path: str, accepted: int = 1) -> Judged:
    """``(n, H, W, C)`` renders of a call against one of ``accepted`` references, whose file is ``path``."""
    shape = renders.shape[1:]
    if shape != reference.mean.shape:
        words = f"the image has {size(shape)} pixels, its reference {size(reference.mean.shape)}"
        return Judged(reference, path, None, call.level, len(renders), accepted, words)
    comparison = reference.compare(renders, ignored_pixels(call.ignore, (shape[0], shape[1])))
    return Judged(reference, path, comparison, call.level, len(renders), accepted)
