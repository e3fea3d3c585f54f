"""How far the shapes of a rig are from the truth, and what ``facezip bench rig`` answers."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from facezip.documents.document import Document
from facezip.machine.conditions import Conditions
from reports.paper.documents.figures import Size


@dataclass(frozen=True, kw_only=True)
class MethodErrors:
    """RMSE of generated shapes to the truth, 0..255, mean over shapes, by what stands for them.

    Attributes
    ----------
    naive, paper, ours : the weighted sum of the scans' differences, the paper's method, and ours.
    neutral, cleaned : the scanned neutral, and that made of all scans, in the place of every shape.
    ours_to_neutral : the ratio of those two.
    worse_than_neutral : for how many shapes ours is worse than the neutral; the worst of those ratios is
        ``worst_ratio``.
    worst_ratio : of one shape.
    damping : of our weight maps.
    """

    naive: float
    paper: float
    ours: float
    neutral: float
    cleaned: float
    ours_to_neutral: float
    worse_than_neutral: float
    worst_ratio: float
    damping: float


@dataclass(frozen=True, kw_only=True)
class ShapeErrors(MethodErrors):
    """The same, and of every shape.

    Attributes
    ----------
    rmse_per_shape : by method and shape.
    """

    rmse_per_shape: Mapping[str, Mapping[str, float]]


@dataclass(frozen=True, kw_only=True)
class GeometryErrors:
    """Mean vertex error over mean true displacement, of the transferred and of the generated shapes."""

    transferred: float
    ours: float


@dataclass(frozen=True, kw_only=True)
class RigNumbers(ShapeErrors):
    """Of one person, or means over several.

    Attributes
    ----------
    shapes : how many.
    clean : errors without nuisances.
    geometry : errors of the meshes.
    condition : of the scans' weights; null where it is infinite.
    seconds : of the rig, and of each method.
    """

    shapes: float
    clean: ShapeErrors
    geometry: GeometryErrors
    condition: float | None
    seconds: Mapping[str, float]


@dataclass(frozen=True, kw_only=True)
class RigIntervals(MethodErrors):
    """Half the widths of the 95 % intervals of means over persons, as of :class:`RigNumbers`."""

    shapes: float
    clean: MethodErrors
    geometry: GeometryErrors
    condition: float | None
    seconds: Mapping[str, float]


@dataclass(frozen=True, kw_only=True)
class RigBench(RigNumbers):
    """What was measured.

    Attributes
    ----------
    intervals, per_seed : where there are several persons.
    """

    intervals: RigIntervals | None = None
    per_seed: Sequence[RigNumbers] | None = None


@dataclass(frozen=True, kw_only=True)
class RigBenchConditions(Conditions):
    """What was rigged, and in words what stands for shapes."""

    character: str
    resolution: Size
    seed: int
    seeds: int
    template: str
    neutral: str
    cleaned: str


@dataclass(frozen=True, kw_only=True)
class RigBenchDocument(RigBench, Document):
    """Generated shapes against the known truth.

    Attributes
    ----------
    conditions : how it was measured.
    """

    format: Literal["facezip-bench-rig/1"] = "facezip-bench-rig/1"
    conditions: RigBenchConditions
