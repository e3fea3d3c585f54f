"""The documents of ``facezip compress`` and ``facezip extend``."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from facezip.cleaning.steps import CleaningFacts
from facezip.documents.document import Document
from facezip.fit.choice import Trial
from facezip.pack.errors import MapErrors
from facezip.pack.facts import PackFacts

Region = Literal["mask", "whole texture"]


@dataclass(frozen=True, kw_only=True)
class Registration:
    """Whether expressions are registered to the neutral.

    Attributes
    ----------
    misregistered : those that are off it, and by how many texels at the worst place.
    unknown : those that have too little in common with it to tell.
    """

    misregistered: Mapping[str, float]
    unknown: Sequence[str]


@dataclass(frozen=True, kw_only=True)
class MeasuredPack(PackFacts):
    """A pack that was written and read back.

    Attributes
    ----------
    rmse : of the albedo, 0..255: the mean over expressions of their errors inside the mask.
    rmse_per_expression : the same by expression.
    errors : by map.
    region : where errors are measured.
    """

    rmse: float
    rmse_per_expression: Mapping[str, float]
    errors: Mapping[str, MapErrors]
    region: Region


@dataclass(frozen=True, kw_only=True)
class ChoiceFacts:
    """How many difference textures and how fine weights were chosen.

    Attributes
    ----------
    reason : one sentence for people.
    tried : all fits in the order in which they were made.
    """

    reason: str
    tried: Sequence[Trial]


@dataclass(frozen=True, kw_only=True)
class KeptFacts:
    """What a region that is kept of an older pack costs.

    Attributes
    ----------
    regions : their names.
    share : how much of the face is inside, 0..1.
    rmse_inside, rmse_outside : of the albedo, 0..255; null where there is nothing.
    """

    regions: Sequence[str]
    share: float
    rmse_inside: float | None
    rmse_outside: float | None


@dataclass(frozen=True, kw_only=True)
class CompressDocument(MeasuredPack, Registration, Document):
    """What ``facezip compress`` wrote.

    Attributes
    ----------
    pack : its folder.
    seconds : the whole job.
    kept : where ``--keep-region`` was given.
    choice : where ``--target-rmse`` or ``--budget-mb`` was given.
    cleaning : where ``--clean`` was given; errors are those to the clean scans.
    """

    format: Literal["facezip-compress/1"] = "facezip-compress/1"
    pack: str
    seconds: float
    kept: KeptFacts | None = None
    choice: ChoiceFacts | None = None
    cleaning: CleaningFacts | None = None


@dataclass(frozen=True, kw_only=True)
class ExtendDocument(PackFacts, Registration, Document):
    """What ``facezip extend`` wrote.

    Attributes
    ----------
    pack : its folder.
    added, kept : the new expressions, and those of the scans that the pack had.
    errors : of the new expressions, by map.
    full_fit : the same of a fit of all expressions; null with ``--quick``.
    loss : by map and name how much of an error that fit would take away; null with ``--quick``.
    cut : the share of each new expression's weights that the range of the pack's bounds.
    advised : for whom a fit of all is worth its while.
    region : where errors are measured.
    seconds : the whole job.
    """

    format: Literal["facezip-extend/1"] = "facezip-extend/1"
    pack: str
    added: Sequence[str]
    kept: Sequence[str]
    errors: Mapping[str, MapErrors]
    full_fit: Mapping[str, MapErrors] | None
    loss: Mapping[str, Mapping[str, float]] | None
    cut: Mapping[str, float]
    advised: Sequence[str]
    region: Region
    seconds: float
