"""What every export starts from: a verified pack, by tiles, and which of its texels the surface shows."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import ALBEDO, KNOWN, Map
from facezip.character.meshes import Meshes
from facezip.character.raster import covered
from facezip.character.tiles import charts, shifted
from facezip.errors import ErrorCode, FaceZipError
from facezip.export.fill import Fill
from facezip.export.joining import CHANNELS, joined
from facezip.export.regions import Regions, read_regions
from facezip.export.sheets import Sheet
from facezip.files.images import Texels
from facezip.files.obj import Topology
from facezip.files.reading import reading, undisturbed
from facezip.machine import memory
from facezip.machine.rows import by_rows, map_rows
from facezip.pack.atlas import atlases, columns_of
from facezip.pack.manifest import Manifest, TileEntry
from facezip.pack.masked import MaskedWeights
from facezip.pack.quantise import StoredTextures
from facezip.pack.read import read_stored
from facezip.pack.verification import verify_pack

TOGETHER, APART = "together", "apart"


@dataclass(frozen=True, eq=False)
class Tile:
    """What one material shows.

    Attributes
    ----------
    name : what the character, or this part of it, is called in shaders.
    expressions : N names in the order of the weight maps.
    layout : UDIM number, and how the weight maps lie.
    uniform_weights : N lists of R numbers where weights are uniform, else empty.
    weight_images : the atlas of every four slots: the bytes of the pack's PNG, or texels of weight maps that are made
        of masks; none for uniform weights.
    maps : the kinds, albedo first.
    sheets : the textures that hold them; the albedo's first.
    regions : of the face, which can be turned down.
    """

    name: str
    expressions: tuple[str, ...]
    layout: TileEntry
    uniform_weights: tuple[tuple[float, ...], ...]
    weight_images: tuple[bytes | Texels, ...]
    maps: tuple[Map, ...]
    sheets: tuple[Sheet, ...]
    regions: Regions

    @property
    def known(self) -> list[str]:
        """Maps that materials everywhere have a place for: those that are what their names say."""
        return [kind.name for kind in self.maps if KNOWN.get(kind.name) == kind]

    def sheet_of(self, name: str) -> tuple[Sheet, slice]:
        """Where a map is: its sheet, and its channels there."""
        return next((sheet, at) for sheet in self.sheets for kind, at in sheet.maps if kind.name == name)


@dataclass(frozen=True, eq=False)
class Source:
    """A pack to export, all of it in memory: what becomes of its folder afterwards changes nothing.

    Attributes
    ----------
    path : its folder.
    name : what the character is called.
    expressions : N names.
    geometry : the meshes, or None.
    tiles : what its materials show; one of them in an ordinary export.
    """

    path: Path
    name: str
    expressions: tuple[str, ...]
    geometry: Meshes | None
    tiles: tuple[Tile, ...]

    @property
    def meshes(self) -> Meshes:
        """The geometry; ``BAD_VALUE`` where the pack has none."""
        if self.geometry is None:
            raise FaceZipError(
                ErrorCode.BAD_VALUE, f"{self.path}: has no meshes to export; compress a character with its meshes"
            )
        return self.geometry

    @property
    def charts(self) -> list[Topology]:
        """The faces of each tile."""
        return charts(self.meshes.topology, [tile.layout.number for tile in self.tiles])

    def folder_of(self, tile: Tile, folder: Path) -> Path:
        """Where a tile's files go: there is a folder for each of several."""
        return folder if len(self.tiles) == 1 else folder / str(tile.layout.number)


def read_source(
    pack: Path, maps: str = TOGETHER, normals_alone: bool = False, regions: Mapping[str, Path] | None = None
) -> Source:
    """Verify a pack and read it for export.

    Parameters
    ----------
    pack : its folder.
    maps : ``"together"`` where maps share textures as far as they fit, ``"apart"`` where each has its own.
    normals_alone : whether normals share with no map as long as that takes no fetch more.
    regions : images of regions of the face, by their names.

    Raises
    ------
    FaceZipError
        What :func:`facezip.read_pack` and :func:`facezip.export.regions.read_regions` raise; ``BAD_VALUE`` for textures
        that are neither grey nor colour, and for a pack without albedo.
    """
    read = undisturbed(pack, lambda: _read(pack, regions or {}))
    manifest, stored = read.manifest, read.stored
    tiles = []
    for entry in manifest.tiles:
        layout, images = _weight_maps(entry, read)
        alone = tuple(_alone(stored, layout.number))
        sheets = joined(alone, normals_alone) if maps == TOGETHER else alone
        _check_names(pack, [sheet.name for sheet in sheets])
        tiles.append(
            Tile(
                name=manifest.name if len(manifest.tiles) == 1 else f"{manifest.name}_{layout.number}",
                expressions=manifest.expressions,
                layout=layout,
                uniform_weights=manifest.uniform_weights,
                weight_images=images,
                maps=stored.maps,
                sheets=sheets,
                regions=read.regions[layout.number],
            )
        )
    return Source(pack, manifest.name, manifest.expressions, stored.meshes, tuple(tiles))


class _Read(NamedTuple):
    """What is read of a pack, and by tile the regions of the face and the files of weight maps."""

    manifest: Manifest
    stored: StoredTextures
    regions: Mapping[int, Regions]
    weights: Mapping[int, tuple[bytes, ...]]


def _read(pack: Path, regions: Mapping[str, Path]) -> _Read:
    manifest = verify_pack(pack)
    _check(pack, manifest)
    memory.check(_row_bytes(manifest), _whole_bytes(manifest))
    found = read_regions(pack, manifest, regions)
    stored = read_stored(pack, manifest)
    with reading(pack):
        weights = {tile.number: tuple((pack / file).read_bytes() for file in tile.weights) for tile in manifest.tiles}
    return _Read(manifest, stored, found, weights)


def _weight_maps(tile: TileEntry, read: _Read) -> tuple[TileEntry, tuple[bytes | Texels, ...]]:
    """How the weight maps of a tile lie, and the images that hold them; of masks they are made here."""
    stored = read.stored
    if not isinstance(stored.weights, MaskedWeights):
        return tile, read.weights[tile.number]
    maps, columns = stored.weight_maps(tile.number), columns_of(len(stored.expressions))
    layout = replace(
        tile,
        weight_columns=columns,
        weight_span=tuple(maps.span.tolist()),
        weight_offset=tuple(maps.offset.tolist()),
    )
    return layout, tuple(atlases(maps.texels, columns))


def _alone(stored: StoredTextures, tile: int) -> Iterator[Sheet]:
    """A sheet for each map of a tile."""
    topology = shifted(stored.meshes.topology, tile) if stored.meshes else None
    weights, fills = stored.weight_maps(tile).values, dict[tuple[int, int], Fill]()
    for kind in stored.maps:
        part = stored.parts[kind.name, tile]
        _, height, width, channels = part.differences.shape
        if (height, width) not in fills:
            fills[height, width] = Fill(_covered(topology, (height, width)))
        yield Sheet(
            ((kind, slice(0, channels)),),
            part.neutral[..., :channels],
            part.differences,
            part.span,
            stored.expressions,
            weights,
            fills[height, width],
        )


def _covered(topology: Topology | None, size: tuple[int, int]) -> NDArray[np.bool_]:
    """The texels that the surface shows; all where no face lies on a tile."""
    chart = None if topology is None else covered(topology, size)
    if chart is not None and any(map_rows(lambda top, bottom: bool(chart[top:bottom].any()), len(chart))):
        return chart
    return by_rows(lambda _: np.ones(1, np.bool_), size, np.bool_)


def _row_bytes(manifest: Manifest) -> int:
    """Of one row of every expression, in 16 bits, with as many channels as maps that share textures may have."""
    widest = max(texture.size[1] for _, texture in manifest.entries().values())
    return 2 * CHANNELS * widest * len(manifest.expressions)


def _whole_bytes(manifest: Manifest) -> int:
    """Of ``head.glb`` while it is put together: the neutrals' images, and mesh and normals of every expression.

    And of the files of weight maps, from the beginning to the end.
    """
    images = sum(manifest.files[texture.neutral].bytes for _, texture in manifest.entries().values())
    vertices = manifest.geometry.vertices if manifest.geometry else 0
    weights = sum(manifest.files[file].bytes for tile in manifest.tiles for file in tile.weights)
    return weights + 3 * images + 2 * 12 * vertices * (1 + len(manifest.expressions))


def _check(pack: Path, manifest: Manifest) -> None:
    for entry in manifest.maps:
        if entry.channels > CHANNELS or (entry.encoding == "srgb" and entry.channels == 2):
            raise FaceZipError(
                ErrorCode.BAD_VALUE, f"{pack}: textures of {entry.channels} channels; engines take those of 1 or 3"
            )
    if manifest.maps[0].kind != KNOWN[ALBEDO]:
        raise FaceZipError(ErrorCode.BAD_VALUE, f"{pack}: has no albedo of 0 to 1, which every material here needs")


def _check_names(pack: Path, names: list[str]) -> None:
    """Raise where shaders or files could not tell sheets apart."""
    for name in names:
        if name.startswith("weights") or "__" in f"{name}_" or names.count(name) > 1:
            raise FaceZipError(
                ErrorCode.BAD_VALUE, f"{pack}: shaders cannot call a map '{name}'; compress it under another name"
            )
