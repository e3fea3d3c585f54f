"""The document of ``facezip importance``."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from facezip.character.facts import CharacterFacts
from facezip.documents.document import Document
from facezip.pack.errors import MapErrors
from render.documents.conditions import Versions
from reports.findings import Finding


@dataclass(frozen=True, kw_only=True)
class Pair:
    """Image RMSE, 0..255, of a fit without and with the importance, and how much the latter is above the former."""

    uniform: float
    importance: float
    change: float


@dataclass(frozen=True, kw_only=True)
class LookErrors(Pair):
    """Of one look, root mean square over expressions.

    Attributes
    ----------
    view, light : which.
    held_out : whether the importance knows nothing of it.
    """

    view: str
    light: str
    held_out: bool


@dataclass(frozen=True, kw_only=True)
class Change:
    """Pooled over looks, and the largest change of one.

    Attributes
    ----------
    made_for, worst_made_for : of the looks that the importance was made for.
    held_out, worst_held_out : of those that it knows nothing of; null where there are none.
    """

    made_for: Pair | None
    worst_made_for: float | None
    held_out: Pair | None
    worst_held_out: float | None


@dataclass(frozen=True, kw_only=True)
class ImportanceFacts:
    """The importance of the albedo on all tiles.

    Attributes
    ----------
    floor : what an unseen texel counts, of the mean.
    seen_share : of the face region.
    largest, p99 : the largest weight, and the 99th percentile on the face.
    counts : how much each map counts beside the albedo, in parts of what it does without an importance.
    """

    floor: float
    seen_share: float
    largest: float
    p99: float
    counts: Mapping[str, float]


@dataclass(frozen=True, kw_only=True)
class FitFacts:
    """One of the two fits.

    Attributes
    ----------
    name : which.
    texture_rmse, map_errors : of its textures.
    bytes_on_gpu, fetches : what it costs.
    """

    name: str
    texture_rmse: float
    map_errors: Mapping[str, MapErrors]
    bytes_on_gpu: int
    fetches: int


@dataclass(frozen=True, kw_only=True)
class FitSettings:
    """Of both fits: difference textures, and how many times smaller weight maps are."""

    differences: int
    weight_scale: int


@dataclass(frozen=True, kw_only=True)
class ImportanceConditions(FitSettings, Versions):
    """How images were rendered and errors measured."""

    spp: int
    sampler: str
    seed: int
    judging_seed: int
    light_transport: str
    skin: str
    resolution: int
    views: Sequence[str]
    held_out_views: Sequence[str]
    lights: Sequence[str]
    expressions: str
    errors: str
    texture_region: str
    maps_rendered: Sequence[str]
    importance_of: str


@dataclass(frozen=True, kw_only=True)
class ImportanceSeconds:
    """Of making the importance, of the fits, and of the whole job."""

    importance: float
    fits: float
    total: float


@dataclass(frozen=True, kw_only=True)
class ImportanceDocument(Document):
    """What the importance of texels gains, as it stands in ``importance.json``.

    Attributes
    ----------
    character, conditions : what was measured, and how.
    importance : what it is.
    fits : without and with it, at equal bytes.
    looks : image errors of both, look by look.
    change : the same, pooled.
    seconds : spent.
    findings : in words; in the file alone.
    command : which makes the report again.
    output, importance_file, report : the folder, what ``facezip compress --importance`` takes, and the page; not in the
        file.
    """

    format: Literal["facezip-importance/1"] = "facezip-importance/1"
    character: CharacterFacts
    conditions: ImportanceConditions
    importance: ImportanceFacts
    fits: Sequence[FitFacts]
    looks: Sequence[LookErrors]
    change: Change
    seconds: ImportanceSeconds
    findings: Sequence[Finding] | None = None
    command: str | None = None
    output: str | None = None
    importance_file: str | None = None
    report: str | None = None
