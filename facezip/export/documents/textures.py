"""The files of a tile: textures, and atlases of regions and masks."""

from collections.abc import Sequence
from dataclasses import dataclass

Size = tuple[int, int]


@dataclass(frozen=True, kw_only=True)
class Gains:
    """Names of what can be turned down after export: maps, expressions, and regions of the face."""

    maps: Sequence[str]
    expressions: Sequence[str]
    regions: Sequence[str]


@dataclass(frozen=True, kw_only=True)
class ExpressionPlace:
    """Where an expression is: its morph target, and column and row of any weight map of its own in the atlas."""

    morph_target: int
    weight_tile: Size | None = None


@dataclass(frozen=True, kw_only=True)
class ExportedTexture:
    """A file, and the numbers that turn its texels t, from 0 to 1, back into values.

    Attributes
    ----------
    file : its name.
    low : the file of the lower bits, of a neutral of 16.
    scale, zero : of a difference: (t − zero) · scale, a number a channel.
    offset : of weights: t · scale + offset.
    columns, size : of weights: weight maps beside each other, and rows and columns of one.
    """

    file: str
    low: str | None = None
    scale: Sequence[float] | None = None
    zero: float | None = None
    offset: Sequence[float] | None = None
    columns: int | None = None
    size: Size | None = None


@dataclass(frozen=True, kw_only=True)
class ExportedRegions:
    """The atlas of masks: its file, how many are beside each other, and rows and columns of one."""

    file: str
    columns: int
    size: Size


@dataclass(frozen=True, kw_only=True)
class ExportedMasks:
    """Masks that weight maps are sums of, in the place of weight maps.

    Attributes
    ----------
    file : their atlas, by four.
    columns, size : fours beside each other, and rows and columns of a mask.
    names : of the masks.
    clamped : whether all activations lie in 0..1.
    vectors : activations of an expression by four: for each layer of four slots one of each mask.
    activations : those of all expressions as half floats, little-endian, in base64.
    """

    file: str
    columns: int
    size: Size
    names: Sequence[str]
    clamped: bool
    vectors: int
    activations: str
