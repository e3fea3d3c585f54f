"""What ``facezip animate`` answers, and ``animation.json``."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from facezip.character.facts import CharacterFacts
from facezip.documents.document import Document
from facezip.pack.errors import MapErrors
from render.documents.conditions import RenderConditions
from render.documents.images import ImageMetrics


@dataclass(frozen=True, kw_only=True)
class FrameErrors(ImageMetrics):
    """Errors of a frame.

    Attributes
    ----------
    texture_rmse : of the albedo, 0..255, inside the mask.
    map_errors : by map.
    """

    texture_rmse: float
    map_errors: Mapping[str, MapErrors]


@dataclass(frozen=True, kw_only=True)
class FrameMeans:
    """Means over frames, as of :class:`FrameErrors`."""

    texture_rmse: float
    image_rmse: float
    flip: float
    delta_e_mean: float
    delta_e_p95: float
    ssim: float
    map_errors: Mapping[str, MapErrors]


@dataclass(frozen=True, kw_only=True)
class Frame(FrameErrors):
    """One frame.

    Attributes
    ----------
    frame : its number.
    pose : that it belongs to.
    weights : the blend, by expression.
    """

    frame: int
    pose: str
    weights: Mapping[str, float]


@dataclass(frozen=True, kw_only=True)
class AnimationConditions(RenderConditions):
    """How an animation was made.

    Attributes
    ----------
    maps_rendered : those that light meets.
    """

    maps_rendered: Sequence[str]


@dataclass(frozen=True, kw_only=True)
class TotalSeconds:
    """Of the whole job."""

    total: float


@dataclass(frozen=True, kw_only=True)
class AnimationDocument(Document):
    """A blend in motion, original against compressed, as it stands in ``animation.json``.

    Attributes
    ----------
    character, conditions : what was rendered, and how.
    original : what the pack is compared with.
    frames : all of them.
    means : over frames.
    worst : the number of the frame with the largest image RMSE.
    seconds : spent.
    pack : its name.
    command : which makes the report again.
    output : the report's folder; not in the file.
    """

    format: Literal["facezip-animation/1"] = "facezip-animation/1"
    character: CharacterFacts
    original: str
    conditions: AnimationConditions
    frames: Sequence[Frame]
    means: FrameMeans
    worst: int
    seconds: TotalSeconds
    pack: str | None = None
    command: str | None = None
    output: str | None = None
