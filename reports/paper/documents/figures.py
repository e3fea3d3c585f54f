"""Tables and figures of the paper as they come out here."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

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
