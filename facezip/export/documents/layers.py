"""Exports of layers under masks, to MetaHuman and O3DE."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

from facezip.character.maps import Encoding
from facezip.documents.document import Document
from facezip.export.documents.textures import Size
from facezip.export.documents.tiles import ExportedFile


@dataclass(frozen=True, kw_only=True)
class LayeredTexture:
    """A whole picture, or a mask.

    Attributes
    ----------
    file : its name.
    srgb, mipmaps : how an importer has to take it; with mip-maps where that is left out.
    """

    file: str
    srgb: bool
    mipmaps: bool | None = None


@dataclass(frozen=True, kw_only=True)
class LayeredMap:
    """Where a map is, and how far what the engine mixes is from the pack: RMSE of 255, of normals angles in degrees.

    Attributes
    ----------
    encoding, range : what its numbers stand for, and the values of texels of 0 and 1.
    size : rows and columns.
    neutral, layers : names among the textures; no layers where the engine does not mix the map.
    rmse, angular_error : mean over expressions.
    rmse_per_expression, angular_error_per_expression : by expression.
    rmse_blends, angular_error_blends : mean over blends of neighbours, half and half.
    rmse_largest, angular_error_largest : of a texel in an expression.
    beyond : the share of its layers' values that 8 bits cut, 0..1.
    """

    encoding: Encoding
    range: tuple[float, float]
    size: Size
    neutral: str
    layers: Sequence[str]
    rmse: float | None = None
    rmse_per_expression: Mapping[str, float] | None = None
    rmse_blends: float | None = None
    rmse_largest: float | None = None
    angular_error: float | None = None
    angular_error_per_expression: Mapping[str, float] | None = None
    angular_error_blends: float | None = None
    angular_error_largest: float | None = None
    beyond: float | None = None


@dataclass(frozen=True, kw_only=True)
class LayerCurve:
    """What a curve drives: a mask in a layer of a map, layers from 1 on."""

    map: str
    layer: int
    mask: str


@dataclass(frozen=True, kw_only=True)
class CurveImages:
    """What a curve drives, by files of the export: a mask of a picture.

    Attributes
    ----------
    map, mask : the picture and the mask.
    """

    map: str
    mask: str


@dataclass(frozen=True, kw_only=True)
class CurvesDocument(Document):
    """``curves.json`` beside MetaHuman's layers: the animation of every expression.

    Attributes
    ----------
    curves : by name, what each drives.
    expressions : by name, the values of the curves that are not 0, from 0 to 1.
    """

    format: Literal["facezip-curves/1"] = "facezip-curves/1"
    curves: Mapping[str, CurveImages]
    expressions: Mapping[str, Mapping[str, float]]


@dataclass(frozen=True, kw_only=True)
class LayersExport(Document):
    """An export of layers under masks, for MetaHuman or O3DE, as it stands in ``facezip.json``.

    Attributes
    ----------
    target, name, tile : as of :class:`facezip.export.documents.tiles.TileExport`.
    textures, maps : by name.
    curves : by name, of MetaHuman.
    notes : what the engine leaves out, for people.
    files, sha256, output, bytes : as of :class:`facezip.export.documents.tiles.ExportDocument`.
    """

    format: Literal["facezip-export/1"] = "facezip-export/1"
    target: str
    name: str
    tile: int
    textures: Mapping[str, LayeredTexture]
    maps: Mapping[str, LayeredMap]
    curves: Mapping[str, LayerCurve] | None = None
    notes: Sequence[str]
    files: Mapping[str, ExportedFile] = field(default_factory=dict)
    sha256: str = ""
    output: str | None = None
    bytes: int | None = None
