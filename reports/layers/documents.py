"""The document of ``facezip layers``; levels are root mean squares, of 255."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from facezip.documents.document import Document


@dataclass(frozen=True, kw_only=True)
class RegionShare:
    """A region of the face, and its share of what a layer does."""

    name: str
    share: float


@dataclass(frozen=True, kw_only=True)
class ExpressionLevel:
    """An expression, and how much something makes of it."""

    name: str
    level: float


@dataclass(frozen=True, kw_only=True)
class LayerFacts:
    """One difference texture.

    Attributes
    ----------
    layer : its number.
    name : the parts of the face that it changes most.
    level : of its part of an expression, over all expressions.
    regions, expressions : the strongest first.
    """

    layer: int
    name: str
    level: float
    regions: Sequence[RegionShare]
    expressions: Sequence[ExpressionLevel]


@dataclass(frozen=True, kw_only=True)
class ExpressionLevels:
    """An expression, and the level of each layer in it, in the order of the layers."""

    name: str
    levels: Sequence[float]


@dataclass(frozen=True, kw_only=True)
class MaskLevels:
    """One mask.

    Attributes
    ----------
    mask : its number.
    name : of the mask.
    region : of the face, that it is on.
    level : of its part of an expression, over all expressions.
    expressions : those that use it, the strongest first.
    """

    mask: int
    name: str
    region: str
    level: float
    expressions: Sequence[ExpressionLevel]


@dataclass(frozen=True, kw_only=True)
class LayersDocument(Document):
    """What every layer, weight map and mask of a pack does, as it stands in ``layers.json``.

    Attributes
    ----------
    name : of the pack.
    layers : the strongest first.
    expressions : by the layer that makes most of each.
    masks : those that do most first; none where weight maps are not made of masks.
    """

    format: Literal["facezip-layers/1"] = "facezip-layers/1"
    name: str
    layers: Sequence[LayerFacts]
    expressions: Sequence[ExpressionLevels]
    masks: Sequence[MaskLevels]
