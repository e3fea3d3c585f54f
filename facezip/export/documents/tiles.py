"""Exports to engines that blend as packs do, of one tile or several."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

from facezip.documents.document import Document
from facezip.export.documents.maps import CodecErrors, ExportedMap, MipErrors
from facezip.export.documents.textures import (
    ExportedMasks,
    ExportedRegions,
    ExportedTexture,
    ExpressionPlace,
    Gains,
    Size,
)


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
    files : all others, which are looked at when the last is written.
    sha256 : of the document without this field, as JSON with sorted keys and no spaces.
    output, bytes : the folder, and the bytes of all files; not in the file.
    """

    notes: Sequence[str] = ()
    files: Mapping[str, ExportedFile] = field(default_factory=dict)
    sha256: str = ""
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
    files: Mapping[str, ExportedFile] = field(default_factory=dict)
    sha256: str = ""
    output: str | None = None
    bytes: int | None = None
