"""New references, and what they change: every change that is accepted is shown with what was there before."""

from dataclasses import dataclass
from pathlib import Path

from numpy import float32
from numpy.typing import NDArray

from facezip.errors import FaceZipError
from render.plugin.baseline import Baseline
from render.plugin.call import Call
from render.plugin.ignoring import ignored_pixels
from render.plugin.judging import Judged, against
from render.plugin.labels import labelled
from render.plugin.reference import Reference
from render.plugin.results import Change, Written
from render.plugin.sources import renders_of

# References and tests never share a seed: their renders have to be independent.
REFERENCE_SEED = 1_000_000


@dataclass(frozen=True, eq=False)
class Made:
    """A reference that was written.

    Attributes
    ----------
    path : its file.
    written : what a result says of it.
    before : the new image against the reference that was there, where it changed and can be read.
    """

    path: Path
    written: Written
    before: Judged | None


def generate(call: Call, baseline: Baseline, names: list[str], label: str, test: str, found: Judged | None) -> Made:
    """Write the reference of an image.

    Parameters
    ----------
    call : the image.
    baseline : where references are.
    names : of the references that the image may have now, the usual one first.
    label : what the new one stands for; see :func:`render.plugin.labels.labelled`.
    test : node id of the test.
    found : the image as it was compared, where it was.

    Raises
    ------
    FaceZipError
        ``CANNOT_WRITE``, and what rendering raises.
    """
    renders = renders_of(call.source, range(REFERENCE_SEED, REFERENCE_SEED + call.reference_renders), call.spp)
    height, width = renders.shape[1:3]
    reference = Reference.of(renders, ignored_pixels(call.ignore, (height, width)))
    target = labelled(names[0] if names else call.stem, label, call.variant)
    was = target if target in baseline.names() else next(iter(names), None)
    before = _digest(baseline, was)
    if found is None and was is not None:
        found = _compared(call, baseline, was, renders)
    path = baseline.write(target, reference, "" if call.shared else test)
    after = baseline.digest(target)
    change: Change = "new" if was is None else "added" if was != target else "same" if before == after else "changed"
    shown = before if before and change != "same" else None
    written = Written(change=change, renders=reference.renders, before=shown, after=after)
    return Made(path, written, found if change in ("added", "changed") else None)


def _digest(baseline: Baseline, name: str | None) -> str:
    """Of the image that was there, if it can be read."""
    try:
        return baseline.digest(name) if name else ""
    except FaceZipError:
        return ""


def _compared(call: Call, baseline: Baseline, name: str, renders: NDArray[float32]) -> Judged | None:
    """The first of the new renders against what was there."""
    try:
        return against(call, renders[: call.renders], baseline.read(name), str(baseline.path(name)))
    except FaceZipError:
        # What cannot be read, or compared, is being replaced.
        return None
