"""The documents of ``facezip paper`` and ``bench rig``; errors are RMSE, 0..255, of maps as packs store them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from facezip.character.facts import CharacterFacts
from facezip.documents.document import Document
from facezip.machine.conditions import Conditions
from reports.findings import Finding

# By method.
Numbers = Mapping[str, float]
PerExpression = Mapping[str, Mapping[str, float]]
Size = tuple[int, int]


@dataclass(frozen=True, kw_only=True)
class TableRow:
    """One row of Table 1.

    Attributes
    ----------
    resolution : rows and columns of the textures.
    expressions : how many.
    seconds : of every step and method.
    bytes_on_gpu : by method, and ``raw``.
    bytes_on_gpu_of_51 : the same for as many expressions as the paper counts.
    fetches : a pixel, by method.
    rmse : mean over expressions, by method.
    """

    resolution: Size
    expressions: int
    seconds: Numbers
    bytes_on_gpu: Mapping[str, int]
    bytes_on_gpu_of_51: Mapping[str, int]
    fetches: Mapping[str, int]
    rmse: Numbers


@dataclass(frozen=True, kw_only=True)
class ErrorFigure:
    """Figure 6: by method the mean error, and that of every expression."""

    resolution: Size
    rmse: Numbers
    rmse_per_expression: PerExpression


@dataclass(frozen=True, kw_only=True)
class ConvergenceFigure:
    """Figure 7, left.

    Attributes
    ----------
    resolution, masks : of what was stitched.
    history : cost of equation (3) from every random start, sweep by sweep.
    cost, seconds : of every search; ``lower_bound`` took time as well.
    lower_bound : no permutation costs less; null where none is known.
    gap : how far each search may be above the optimum, as a share.
    """

    resolution: Size
    masks: int
    history: Sequence[Sequence[float]]
    cost: Numbers
    seconds: Numbers
    lower_bound: float | None
    gap: Mapping[str, float | None]


@dataclass(frozen=True, kw_only=True)
class Chosen:
    """Cost and error of one stitching."""

    cost: float
    rmse: float


@dataclass(frozen=True, kw_only=True)
class MaskCount:
    """One number of masks: cost and error of every start, and what each search chooses."""

    masks: int
    costs: Sequence[float]
    rmse: Sequence[float]
    chosen: Mapping[str, Chosen]


@dataclass(frozen=True, kw_only=True)
class MasksFigure:
    """Figure 7, right.

    Attributes
    ----------
    resolution : of what was stitched.
    starts : for each number of masks.
    counts : by number of masks; those too large for the face are left out.
    without_masks : errors of methods that have none.
    """

    resolution: Size
    starts: int
    counts: Sequence[MaskCount]
    without_masks: Numbers | None = None


@dataclass(frozen=True, kw_only=True)
class ShapesFigure:
    """Figure 8: albedos of generated shapes, made in three ways.

    Attributes
    ----------
    resolution : of the albedos.
    condition : of the scans' weights; null where it is infinite.
    damping : of our weight maps.
    unseen : shapes hardly in any scan.
    columns : of the pictures.
    pictures : by shape, data URIs in the order of the columns.
    rmse, rmse_per_expression : by method, where the truth is known.
    """

    resolution: Size
    condition: float | None
    damping: float
    unseen: Sequence[str]
    columns: Sequence[str]
    pictures: Mapping[str, str]
    rmse: Numbers | None = None
    rmse_per_expression: PerExpression | None = None


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
    condition: float
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
