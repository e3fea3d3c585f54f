"""``facezip.json``, which every export has, and what ``facezip export`` says of it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from facezip.character.maps import Encoding
from facezip.documents.document import Document

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


@dataclass(frozen=True, kw_only=True)
class CodecErrors:
    """What blocks add to expressions: RMSE of 255, of normals mean angles in degrees.

    Attributes
    ----------
    name : of the codec.
    rmse, angular_error : mean over expressions.
    rmse_per_expression, angular_error_per_expression : by expression.
    rmse_without_fit, angular_error_without_fit : without fitting each texture to what was lost of the others.
    maps : what storing lost of each texture.
    """

    name: str
    rmse: float | None = None
    rmse_per_expression: Mapping[str, float] | None = None
    rmse_without_fit: float | None = None
    angular_error: float | None = None
    angular_error_per_expression: Mapping[str, float] | None = None
    angular_error_without_fit: float | None = None
    maps: Mapping[str, float] | None = None


@dataclass(frozen=True, kw_only=True)
class MipErrors:
    """How far one level of mip-maps is from how a blend should look from afar; ``_blends`` of unseen blends.

    Attributes
    ----------
    size : rows and columns of the level.
    product_gap, product_gap_blends : how far the mean of a blend's texels is from the blend of plain mip-maps.
    plain, plain_blends : every texture averaged on its own, stored as it is.
    averaged, averaged_blends : the same in blocks.
    fitted, fitted_blends : in blocks and fitted, as written.
    """

    size: Size
    product_gap: float
    product_gap_blends: float | None = None
    plain: float
    plain_blends: float | None = None
    averaged: float | None = None
    averaged_blends: float | None = None
    fitted: float | None = None
    fitted_blends: float | None = None


@dataclass(frozen=True, kw_only=True)
class ExportedMap:
    """Where a map is.

    Attributes
    ----------
    encoding, range : what its numbers stand for, and the values of texels of 0 and 1.
    size : rows and columns.
    neutral, differences : names among the textures.
    channels : its own in those.
    max_slope : slopes of normals are clipped to this, either way.
    codec : of blocks.
    mips : level by level.
    """

    encoding: Encoding
    range: tuple[float, float]
    size: Size
    neutral: str
    differences: Sequence[str]
    channels: Sequence[int]
    max_slope: float | None = None
    codec: CodecErrors | None = None
    mips: Sequence[MipErrors]


@dataclass(frozen=True, kw_only=True)
class TileExport(Document):
    """One tile.

    Attributes
    ----------
    target : what takes it.
    name : of the pack.
    tile : its UDIM number.
    resolution, channels : of the first texture.
    layers : textures of combined weights, four slots each.
    weight_size : rows and columns of a weight map.
    uniform_weights : by expression, where weights are uniform, else none.
    gains : what can be turned down.
    order : expressions as weight maps have them.
    expressions : by name.
    textures, maps : by name.
    codec, mips : of the first map.
    regions : of the face, where some were given.
    masks : where weight maps are sums of them.
    """

    format: Literal["facezip-export/1"] = "facezip-export/1"
    target: str
    name: str
    tile: int
    resolution: Size
    channels: int
    layers: int
    weight_size: Size
    uniform_weights: Sequence[Sequence[float]]
    gains: Gains
    order: Sequence[str]
    expressions: Mapping[str, ExpressionPlace]
    textures: Mapping[str, ExportedTexture]
    maps: Mapping[str, ExportedMap]
    codec: CodecErrors
    mips: Sequence[MipErrors]
    regions: ExportedRegions | None = None
    masks: ExportedMasks | None = None


@dataclass(frozen=True, kw_only=True)
class ExportedFile:
    """What a file has to be.

    Attributes
    ----------
    bytes, sha256 : of its content.
    srgb, mipmaps : of a texture: how an importer has to take it.
    size, numbers : of a PNG: rows and columns, and the SHA-256 of its numbers, however they are compressed.
    settings : of an importer's file, in the place of all that.
    """

    bytes: int | None = None
    sha256: str | None = None
    srgb: bool | None = None
    mipmaps: bool | None = None
    size: Size | None = None
    numbers: str | None = None
    settings: Mapping[str, str] | None = None


@dataclass(frozen=True, kw_only=True)
class ExportDocument(TileExport):
    """An export of one tile, as it stands in ``facezip.json``.

    Attributes
    ----------
    notes : what is not usual, for people: the size of a head of an unknown unit.
    files : all others.
    sha256 : of the document without this field, as JSON with sorted keys and no spaces.
    output, bytes : the folder, and the bytes of all files; not in the file.
    """

    notes: Sequence[str] = ()
    files: Mapping[str, ExportedFile]
    sha256: str
    output: str | None = None
    bytes: int | None = None


@dataclass(frozen=True, kw_only=True)
class TilesDocument(Document):
    """An export of several tiles, as it stands in ``facezip.json``.

    Attributes
    ----------
    target, name : as of :class:`TileExport`.
    tiles : by UDIM number; each stands in the folder of its tile, too.
    notes, files, sha256, output, bytes : as of :class:`ExportDocument`.
    """

    format: Literal["facezip-export/1"] = "facezip-export/1"
    target: str
    name: str
    tiles: Mapping[str, TileExport]
    notes: Sequence[str] = ()
    files: Mapping[str, ExportedFile]
    sha256: str
    output: str | None = None
    bytes: int | None = None


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
class LayersExport(Document):
    """An export of layers under masks, for MetaHuman or O3DE, as it stands in ``facezip.json``.

    Attributes
    ----------
    target, name, tile : as of :class:`TileExport`.
    textures, maps : by name.
    curves : by name, of MetaHuman.
    notes : what the engine leaves out, for people.
    files, sha256, output, bytes : as of :class:`ExportDocument`.
    """

    format: Literal["facezip-export/1"] = "facezip-export/1"
    target: str
    name: str
    tile: int
    textures: Mapping[str, LayeredTexture]
    maps: Mapping[str, LayeredMap]
    curves: Mapping[str, LayerCurve] | None = None
    notes: Sequence[str]
    files: Mapping[str, ExportedFile]
    sha256: str
    output: str | None = None
    bytes: int | None = None


@dataclass(frozen=True, kw_only=True)
class WebDocument(Document):
    """The viewer as one page.

    Attributes
    ----------
    output, bytes : the file.
    originals : whether the original textures are in it.
    """

    format: Literal["facezip-export-web/1"] = "facezip-export-web/1"
    output: str
    bytes: int
    originals: bool


Export = ExportDocument | TilesDocument | LayersExport
