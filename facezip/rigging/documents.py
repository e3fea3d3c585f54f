"""The document of ``facezip rig``; lengths are in the unit of the meshes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from facezip.character.facts import CharacterFacts
from facezip.cleaning.steps import CleaningFacts
from facezip.documents.document import Document
from facezip.pack.facts import PackFacts
from facezip.rigging.rigged import MAPS
from facezip.rigging.shown import Region


@dataclass(frozen=True)
class RigRequest:
    """What is asked for besides scans, a template and a place for the rig.

    Attributes
    ----------
    method : how textures are compressed.
    maps : how shapes get weight maps, one of ``MAPS``.
    clean : those of :data:`facezip.cleaning.steps.STEPS` that are taken before anything else.
    seed : of what is random.
    """

    method: str = "refined"
    maps: str = MAPS[0]
    clean: tuple[str, ...] = ()
    seed: int = 0


@dataclass(frozen=True, kw_only=True)
class ScanFit:
    """How well one scan is made of the shapes.

    Attributes
    ----------
    rms_left : root mean square of what of its displacement they do not show.
    rms_displacement : that of the displacement itself.
    """

    rms_left: float
    rms_displacement: float


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """What scans tell of one shape.

    Attributes
    ----------
    determined : the share of its motion that the scans determine.
    largest_weight : of the shape in any scan.
    shown, uncertainty, regions : of its texture, as of :class:`facezip.rigging.shown.Shown`; only where its maps are
        geometry-aware.
    """

    determined: float
    largest_weight: float
    shown: float | None = None
    uncertainty: float | None = None
    regions: Sequence[Region] | None = None


@dataclass(frozen=True, kw_only=True)
class RigPack(PackFacts):
    """The pack of the shapes.

    Attributes
    ----------
    path : its folder.
    """

    path: str


@dataclass(frozen=True, kw_only=True)
class RigSeconds:
    """Seconds of the fit of the shapes, and of the whole job."""

    rig: float
    total: float


@dataclass(frozen=True, kw_only=True)
class RigFit:
    """The rig without its meshes.

    Attributes
    ----------
    character : the scans.
    shapes : of the template, in the order of the pack.
    example_weights : by scan, how much of which shape it is made of.
    fit : by scan.
    unseen_shapes : those hardly in any scan.
    condition : of the matrix of weights; null where it is infinite.
    rank : of that matrix.
    """

    character: CharacterFacts
    shapes: Sequence[str]
    example_weights: Mapping[str, Mapping[str, float]]
    fit: Mapping[str, ScanFit]
    unseen_shapes: Sequence[str]
    condition: float | None
    rank: int


@dataclass(frozen=True, kw_only=True)
class RigDocument(RigFit, Document):
    """What ``facezip rig`` wrote, as it stands in ``rig.json``.

    Attributes
    ----------
    evidence : by shape.
    pack : of the shapes.
    settings : what was asked for.
    damping : of the weight maps, by leaving scans out; null for pseudo-inverse ones.
    seconds : of its parts.
    cleaning : where ``--clean`` was given.
    output : the folder; not in the file.
    """

    format: Literal["facezip-rig/1"] = "facezip-rig/1"
    evidence: Mapping[str, Evidence]
    pack: RigPack
    settings: RigRequest
    damping: float | None
    seconds: RigSeconds
    cleaning: CleaningFacts | None = None
    output: str | None = None
