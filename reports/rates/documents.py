"""The document of ``facezip rates``."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from facezip.character.facts import CharacterFacts
from facezip.documents.document import Document
from facezip.machine.conditions import Conditions
from reports.findings import Finding
from reports.rates.points import Point


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """A point of a rival, and our best ones that cost no more.

    Attributes
    ----------
    rival, ours : points.
    ratio : of their errors.
    few, few_ratio : our best one of at most four differences, six fetches of one map; none where none costs so little.
    """

    rival: Point
    ours: Point
    ratio: float
    few: Point | None = None
    few_ratio: float | None = None


@dataclass(frozen=True, kw_only=True)
class Round:
    """Everything that was measured with one number of expressions.

    Attributes
    ----------
    expressions : how many.
    points : the measurements.
    comparison : by points of the rivals.
    """

    expressions: int
    points: Sequence[Point]
    comparison: Sequence[Comparison]


@dataclass(frozen=True, kw_only=True)
class RatesConditions(Conditions):
    """How errors, bytes and files were measured and what coded them, in words; the seed of the blends."""

    errors: str
    texture_region: str
    bytes: str
    files: str
    textures: str
    astc_effort: str
    bc: str
    seed: int


@dataclass(frozen=True, kw_only=True)
class Seconds:
    """Of the whole job."""

    total: float


@dataclass(frozen=True, kw_only=True)
class RatesDocument(Document):
    """Error against bytes of GPU memory, as it stands in ``rates.json``.

    Attributes
    ----------
    character, conditions : what was measured, and how.
    rounds : one, or two where blends were added.
    seconds : spent.
    findings : in words; in the file alone.
    command : which makes the report again.
    output, report : the folder and the page; not in the file.
    """

    format: Literal["facezip-rates/1"] = "facezip-rates/1"
    character: CharacterFacts
    conditions: RatesConditions
    rounds: Sequence[Round]
    seconds: Seconds
    findings: Sequence[Finding] | None = None
    command: str | None = None
    output: str | None = None
    report: str | None = None
