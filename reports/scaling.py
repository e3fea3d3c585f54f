"""The report of ``facezip bench scaling``: what a megatexel costs at every size, part by part."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

from facezip.documents.document import Document
from facezip.fit.timing import CompressBench
from facezip.machine.conditions import Conditions
from reports.experiments import write_experiments
from reports.findings import Finding
from reports.metrics import number
from reports.plots import Axis, Mark, Plot, dot, line
from reports.sections import Section
from reports.tables import Cell, Row, Table

DATA = "scaling.json"
WIDE, NARROW = 1200.0, 380.0
LEFT, TOP, BOTTOM = 52.0, 36.0, 400.0
# By their keys in the JSON, from the sum down to its parts, and last what it is compared with.
PARTS = {
    "total": ("Whole run", "disc", "pack-0"),
    "fit": ("Fit", "square", "pack-1"),
    "load": ("Read images and meshes", "diamond", "rival-0"),
    "write": ("Write the pack", "triangle", "pack-2"),
    "measure": ("Read it back and measure", "open-disc", "pack-3"),
    "check": ("Check registration", "open-square", "rival-2"),
    "io": ("Its images alone", "open-diamond", "rival-1"),
}


@dataclass(frozen=True, kw_only=True)
class ScalingSize(CompressBench):
    """One size.

    Attributes
    ----------
    resolution : side of the textures.
    seconds_per_megatexel : of the whole run.
    alternations : of the fit.
    alternation_s : seconds of one.
    """

    resolution: int
    seconds_per_megatexel: float
    alternations: int
    alternation_s: float


@dataclass(frozen=True, kw_only=True)
class ScalingConditions(Conditions):
    """What was compressed, and how it was measured."""

    character: str
    expressions: int
    seed: int
    memory: str
    method: str
    statistic: str


@dataclass(frozen=True, kw_only=True)
class Heading:
    """What the page is called."""

    name: str


@dataclass(frozen=True, kw_only=True)
class ScalingDocument(Document):
    """How the time to compress grows with the size of the textures, as it stands in ``scaling.json``.

    Attributes
    ----------
    character : the heading of the page.
    sizes : ascending.
    factor : the dearest megatexel over the cheapest.
    conditions : how it was measured.
    findings : in words; in the file alone.
    command : which makes the report again.
    output, report : the folder and the page; not in the file.
    """

    format: Literal["facezip-scaling/1"] = "facezip-scaling/1"
    character: Heading
    sizes: Sequence[ScalingSize]
    factor: float
    conditions: ScalingConditions
    command: str
    findings: Sequence[Finding] | None = None
    output: str | None = None
    report: str | None = None


def write_scaling_report(document: ScalingDocument, folder: Path) -> Path:
    """Write ``scaling.json`` and the page ``index.html`` that shows the same numbers; returns the page's path.

    Parameters
    ----------
    document : as ``facezip bench scaling`` makes it.
    folder : where both files go, each whole or not at all.

    Raises
    ------
    FaceZipError
        ``CANNOT_WRITE`` for the output.
    """
    return write_experiments(
        folder,
        DATA,
        replace(document, findings=_findings(document)),
        lambda _: [_section(document.sizes)],
        kicker="How the time to compress grows with the size of the textures",
        title="Seconds per megatexel, by FaceZip",
    )


def _findings(document: ScalingDocument) -> list[Finding]:
    sizes = document.sizes
    costs = [one.seconds_per_megatexel for one in sizes]
    ratios = [one.ratio for one in sizes]
    rounds, small, large = [_cost(one, "alternation") for one in sizes], sizes[0], sizes[-1]
    return [
        Finding(
            title="An alternation of the fit",
            here=f"It costs {number(min(rounds), 3)} to {number(max(rounds), 3)} seconds a megatexel, a factor of "
            f"{number(max(rounds) / min(rounds), 2)}; there are {small.alternations} at {small.resolution}² and "
            f"{large.alternations} at {large.resolution}².",
        ),
        Finding(
            title=f"From {sizes[0].resolution}² to {sizes[-1].resolution}²",
            here=f"A megatexel of every texture costs {number(min(costs), 2)} to {number(max(costs), 2)} seconds: "
            f"the dearest {number(document.factor, 2)} times the cheapest.",
        ),
        Finding(
            title="Beside its images",
            here=f"The whole run takes {number(min(ratios), 2)} to {number(max(ratios), 2)} times as long as "
            "decoding and encoding the same images.",
        ),
    ]


def _section(sizes: Sequence[ScalingSize]) -> Section:
    intro = (
        "A level line is a cost that grows with the number of texels and no faster. Small textures have meshes as "
        "large as large ones have, and are fitted in more alternations: there it falls."
    )
    legend = tuple((_mark(key, (0, 0)), label, "") for key, (label, *_) in PARTS.items())
    return Section(
        "cost", "Cost", "Seconds per megatexel", intro, legend, ((_plot(sizes, WIDE), _plot(sizes, NARROW)),),
        tables=(_table(sizes),),
    )  # fmt: skip


def _mark(key: str, at: tuple[float, float], words: str = "") -> Mark:
    _, shape, tone = PARTS[key]
    return dot(at, shape, tone, words)


def _plot(sizes: Sequence[ScalingSize], width: float) -> Plot:
    right = width - 8
    # A step for every doubling of the side.
    steps = [math.log2(one.resolution) for one in sizes]
    across = Axis(min(steps) - 0.3, max(steps) + 0.3, LEFT, right, ())
    up = Axis.around([_cost(one, "total") for one in sizes], BOTTOM, TOP, 6, zero=True)
    marks = []
    for key in reversed(PARTS):
        places = [(across.at(step), up.at(_cost(one, key))) for step, one in zip(steps, sizes, strict=True)]
        marks.append(line(places, PARTS[key][2], PARTS[key][0], opacity=1 if key == "total" else 0.5))
        marks += [_mark(key, place, _words(one, key)) for place, one in zip(places, sizes, strict=True)]
    ticks = tuple((round(across.at(step), 2), f"{one.resolution}²") for step, one in zip(steps, sizes, strict=True))
    frame = (width, BOTTOM + 48, LEFT, right, TOP, BOTTOM)
    title = "Seconds per megatexel, by size"
    return Plot(title, *frame, ticks, up.marks(), "Texels of a texture", "Seconds per megatexel", tuple(marks))


def _cost(one: ScalingSize, key: str) -> float:
    return float(getattr(one, f"{key}_s") / (one.resolution**2 / 1e6))


def _words(one: ScalingSize, key: str) -> str:
    return f"{PARTS[key][0]}, {one.resolution}²: {number(_cost(one, key), 3)} s per megatexel"


def _table(sizes: Sequence[ScalingSize]) -> Table:
    rows = [
        Row(label, tuple(Cell(number(_cost(one, key), 3), f"{number(getattr(one, f'{key}_s'), 2)} s") for one in sizes))
        for key, (label, *_) in PARTS.items()
    ]
    each = tuple(
        Cell(number(_cost(one, "alternation"), 3), f"of {one.alternations}, start and end shared out") for one in sizes
    )
    extra = (
        Row("Fit, an alternation", each),
        Row("Whole run / images", tuple(Cell(number(one.ratio, 2)) for one in sizes)),
        Row("Peak memory, MB", tuple(Cell(f"{one.peak_memory_mb:.0f}") for one in sizes)),
        Row("RMSE, of 255", tuple(Cell(number(one.rmse, 2)) for one in sizes)),
    )
    columns = tuple(f"{one.resolution}²" for one in sizes)
    return Table("Seconds per megatexel, and in all", "Part", columns, (*rows, *extra))
