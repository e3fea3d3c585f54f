"""``manifest.json`` of version 2 of the format: maps, and for each tile their sizes, ranges and shared weight maps."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from facezip.character.maps import ALBEDO, MapKind
from facezip.character.surface import FIRST_TILE
from facezip.pack.footprint import SLOTS_PER_LAYER, Footprint
from facezip.pack.manifest import (
    LAYERED,
    VERSION,
    Manifest,
    StoredFile,
    Versions,
    frozen,
    read_version,
    signed,
    with_files,
)
from facezip.pack.surface_footprint import SurfaceFootprint


@dataclass(frozen=True)
class StoredMap:
    """A map as a pack holds it.

    Attributes
    ----------
    name, encoding : as of :class:`facezip.character.maps.MapKind`.
    range : what t = 0 and t = 1 of the neutral stand for.
    channels : of the fitted texels; 2 for normals, whose images have a third one for people to look at.
    """

    name: str
    encoding: str
    range: tuple[float, float]
    channels: int

    @property
    def kind(self) -> MapKind:
        """The map without its channels."""
        return MapKind(self.name, self.encoding, *self.range)

    @property
    def stored_channels(self) -> int:
        """Of the images."""
        return 3 if self.kind.is_normal else self.channels


@dataclass(frozen=True)
class StoredTexture:
    """One map on one tile.

    Attributes
    ----------
    size : rows and columns of neutral and differences.
    neutral_bits : bits of a channel of the neutral.
    difference_scale : R lists of C ranges; D = (t - 128/255) · scale, in units of the map, slopes for normals.
    """

    size: tuple[int, int]
    neutral_bits: int
    difference_scale: tuple[tuple[float, ...], ...]


@dataclass(frozen=True)
class StoredTile:
    """The weight maps of a tile, and its maps in the order of the manifest's ``maps``.

    Attributes
    ----------
    number : of the UDIM tile, 1001 + column + 10 · row.
    weight_size, weight_columns, weight_scale, weight_offset : as of :class:`facezip.pack.manifest.Manifest`.
    textures : one a map.
    """

    number: int
    weight_size: tuple[int, int]
    weight_columns: int
    weight_scale: tuple[float, ...]
    weight_offset: tuple[float, ...]
    textures: tuple[StoredTexture, ...]

    @property
    def weight_files(self) -> list[str]:
        """The atlas of every four slots; none for uniform weights."""
        layers = 0 if self.weight_size == (1, 1) else -(-len(self.weight_scale) // SLOTS_PER_LAYER)
        return [f"weights{f'_{layer}' if layer else ''}.{self.number}.png" for layer in range(layers)]

    def neutral_file(self, name: str) -> str:
        """The image of a map's neutral."""
        return f"{name}.{self.number}.neutral.png"

    def difference_files(self, name: str) -> list[str]:
        """The image of each of a map's difference textures."""
        return [f"{name}.{self.number}.difference_{i}.png" for i in range(len(self.weight_scale))]


@dataclass(frozen=True)
class SurfaceManifest:
    """The fields of a ``manifest.json`` of version 2, checked against their ranges when it is read.

    Attributes
    ----------
    maps, tiles : what there is; albedo first, numbers ascending.
    uniform_weights : N lists of R numbers, for all tiles, where weights are uniform, else empty.
    name, method, expressions, vertices, triangles, texture_coordinates, made_with, files : as of version 1.
    """

    name: str
    method: str
    expressions: tuple[str, ...]
    maps: tuple[StoredMap, ...]
    tiles: tuple[StoredTile, ...]
    uniform_weights: tuple[tuple[float, ...], ...]
    vertices: int
    triangles: int
    texture_coordinates: int
    made_with: dict[str, Any]
    files: dict[str, StoredFile]

    @property
    def footprint(self) -> SurfaceFootprint:
        """Bytes and fetches at run time."""
        count = len(self.expressions)
        return SurfaceFootprint(
            tuple(
                tuple(
                    Footprint(one.size, kind.channels, len(tile.weight_scale), count, tile.weight_size)
                    for kind, one in zip(self.maps, tile.textures, strict=True)
                )
                for tile in self.tiles
            )
        )

    def to_bytes(self) -> bytes:
        """The file's content, signed as that of version 1 is."""
        return signed(LAYERED, asdict(self))

    @classmethod
    def of_document(cls, document: dict[str, Any]) -> "SurfaceManifest":
        """A parsed file; TypeError or ValueError where its structure is another."""
        given = with_files(document, cls)
        maps = tuple(StoredMap(**_frozen(entry)) for entry in given.pop("maps"))
        tiles = tuple(_tile(_frozen(entry)) for entry in given.pop("tiles"))
        return cls(maps=maps, tiles=tiles, **given)


AnyManifest = Manifest | SurfaceManifest


def neutral_bits_of(manifest: AnyManifest) -> dict[tuple[str, int], int]:
    """By map and tile, the bits a channel that textures are written with again: 8, or what a map of 16 bits had."""
    if isinstance(manifest, Manifest):
        # Version 1 has always been decompressed to 8 bits.
        return {(ALBEDO, FIRST_TILE): 8}
    return {
        (kind.name, tile.number): texture.neutral_bits
        for tile in manifest.tiles
        for kind, texture in zip(manifest.maps, tile.textures, strict=True)
    }


def _tile(entry: dict[str, Any]) -> StoredTile:
    textures = tuple(StoredTexture(**_frozen(one)) for one in entry.pop("textures"))
    return StoredTile(textures=textures, **entry)


def _frozen(entry: dict[str, Any]) -> dict[str, Any]:
    return {key: frozen(value) for key, value in entry.items()}


def versions() -> Versions[AnyManifest]:
    """All versions of the format."""
    from facezip.pack.surface_ranges import first_out_of_range

    layered: Mapping[str, Any] = {LAYERED: (SurfaceManifest.of_document, first_out_of_range)}
    return {**VERSION, **layered}


def read_any_manifest(folder: Path) -> AnyManifest:
    """The manifest of a pack of any version; as :func:`facezip.pack.manifest.read_manifest`."""
    return read_version(folder, versions())
