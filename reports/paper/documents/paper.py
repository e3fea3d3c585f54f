"""What ``facezip paper`` answers, and ``paper.json``."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from facezip.character.facts import CharacterFacts
from facezip.documents.document import Document
from facezip.machine.conditions import Conditions
from reports.findings import Finding
from reports.paper.documents.figures import (
    ConvergenceFigure,
    ErrorFigure,
    MasksFigure,
    Numbers,
    ShapesFigure,
    Size,
    TableRow,
)


@dataclass(frozen=True, kw_only=True)
class PublishedRow:
    """One row of the paper's own Table 1."""

    resolution: Size
    seconds: Numbers
    megabytes: Numbers


@dataclass(frozen=True, kw_only=True)
class PublishedFacts:
    """What the paper states: its table, machine, expressions, and those that its memory is stated for."""

    table_1: Sequence[PublishedRow]
    machine: str
    expressions: int
    expressions_in_memory: int


@dataclass(frozen=True, kw_only=True)
class PaperConditions(Conditions):
    """How times and errors were measured, in words, and what the experiments were told."""

    times: str
    errors: str
    maps: str
    texture_region: str
    texture_sizes: str
    weight_scale: int
    masks: int
    restarts: int
    starts: int
    mask_counts: Sequence[int]
    seed: int


@dataclass(frozen=True, kw_only=True)
class PaperSeconds:
    """Of the whole job."""

    total: float


@dataclass(frozen=True, kw_only=True)
class PaperDocument(Document):
    """The paper's table and figures with our methods beside its own, as it stands in ``paper.json``.

    Attributes
    ----------
    character, conditions : what was measured, and how.
    published : what the paper states.
    table_1 : one row a size, ascending.
    figure_6, figure_7_convergence, figure_7_masks : at the first size.
    figure_8 : null where there are no shapes to generate.
    findings : in words.
    seconds : spent.
    command : which makes the report again.
    output, report : the folder and the page; not in the file.
    """

    format: Literal["facezip-paper/1"] = "facezip-paper/1"
    character: CharacterFacts
    conditions: PaperConditions
    published: PublishedFacts
    table_1: Sequence[TableRow]
    figure_6: ErrorFigure
    figure_7_convergence: ConvergenceFigure
    figure_7_masks: MasksFigure
    figure_8: ShapesFigure | None
    findings: Sequence[Finding] = ()
    seconds: PaperSeconds
    command: str | None = None
    output: str | None = None
    report: str | None = None
