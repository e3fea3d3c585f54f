"""What ``facezip validate`` answers, and ``report.json``."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from facezip.character.facts import CharacterFacts
from facezip.documents.document import Document
from render.documents.conditions import RenderConditions, RenderSeconds
from render.documents.images import Render
from render.documents.judged import Judged
from render.limits import Thresholds


@dataclass(frozen=True, kw_only=True)
class ValidationConditions(RenderConditions):
    """How a validation was made.

    Attributes
    ----------
    max_spp : samples a pixel where the verdict is close.
    thresholds : the limits of the verdict.
    sampler, display, region, texture_region, confidence : in words.
    pixels_per_degree : of FLIP's display.
    debiased : metrics that are free of the bias of noise.
    """

    max_spp: int
    thresholds: Thresholds
    sampler: str
    pixels_per_degree: float
    display: str
    region: str
    texture_region: str
    confidence: str
    debiased: Sequence[str]


@dataclass(frozen=True, kw_only=True)
class Baseline:
    """Texture errors of another method.

    Attributes
    ----------
    name : of the method.
    texture_rmse, texture_rmse_per_expression : of the albedo, 0..255, inside the mask.
    bytes_on_gpu, fetches : what it costs.
    """

    name: str
    texture_rmse: float
    texture_rmse_per_expression: Mapping[str, float]
    bytes_on_gpu: int
    fetches: int


@dataclass(frozen=True, kw_only=True)
class ValidationDocument(Document):
    """A character rendered with its own and with each pack's textures, as it stands in ``report.json``.

    Attributes
    ----------
    character, conditions : what was rendered, and how.
    packs : in the order of the command line.
    renders : every expression in every view and light.
    rendered : how many of them were made now; others were taken over.
    seconds : spent.
    pairs_per_second : of original and pack.
    baselines : other methods, where a demo measured them.
    command : which makes the report again.
    """

    format: Literal["facezip-validation/3"] = "facezip-validation/3"
    character: CharacterFacts
    conditions: ValidationConditions
    packs: Sequence[Judged]
    renders: Sequence[Render]
    rendered: int
    seconds: RenderSeconds
    pairs_per_second: float
    baselines: Sequence[Baseline] | None = None
    command: str | None = None
