"""What every export starts from: a verified pack, by tiles, and which of its texels the surface shows."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import ALBEDO, KNOWN, Map
from facezip.character.meshes import Meshes
from facezip.character.raster import covered
from facezip.character.tiles import FIRST_TILE, charts, shifted
from facezip.errors import ErrorCode, FaceZipError
from facezip.export.sheets import CHANNELS, Sheet, in_sheets
from facezip.files.obj import Topology
from facezip.pack.manifest import Manifest
from facezip.pack.model import CompressedTextures
from facezip.pack.ranges import weight_files
from facezip.pack.surface_manifest import AnyManifest, StoredTexture, StoredTile
from facezip.pack.verification import verify_pack
from facezip.pack.version_2 import read_verified_surface


@dataclass(frozen=True, eq=False)
class Tile:
    """What one material shows.

    Attributes
    ----------
    name : what the character, or this part of it, is called in shaders.
    expressions : N names in the order of the weight maps.
    layout : UDIM number, and how the weight maps lie.
    uniform_weights : N lists of R numbers where weights are uniform, else empty.
    weight_files : the atlas of every four slots; none for uniform weights.
    maps : the kinds, albedo first.
    sheets : the textures that hold them; the albedo's first.
    """

    name: str
    expressions: tuple[str, ...]
    layout: StoredTile
    uniform_weights: tuple[tuple[float, ...], ...]
    weight_files: tuple[Path, ...]
    maps: tuple[Map, ...]
    sheets: tuple[Sheet, ...]

    @property
    def known(self) -> list[str]:
        """Maps that materials everywhere have a place for: those that are what their names say."""
        return [kind.name for kind in self.maps if KNOWN.get(kind.name) == kind]

    def sheet_of(self, name: str) -> tuple[Sheet, slice]:
        """Where a map is: its sheet, and its channels there."""
        return next((sheet, at) for sheet in self.sheets for kind, at in sheet.maps if kind.name == name)


@dataclass(frozen=True, eq=False)
class Source:
    """A pack to export.

    Attributes
    ----------
    path : its folder.
    name : what the character is called.
    surface : its maps and meshes.
    tiles : what its materials show; one of them in an ordinary export.
    """

    path: Path
    name: str
    surface: CompressedTextures
    tiles: tuple[Tile, ...]

    @property
    def meshes(self) -> Meshes:
        """The geometry; ``BAD_VALUE`` where the pack has none."""
        if self.surface.meshes is None:
            raise FaceZipError(
                ErrorCode.BAD_VALUE, f"{self.path}: has no meshes to export; compress a character with its meshes"
            )
        return self.surface.meshes

    @property
    def charts(self) -> list[Topology]:
        """The faces of each tile."""
        return charts(self.meshes.topology, [tile.layout.number for tile in self.tiles])

    def folder_of(self, tile: Tile, folder: Path) -> Path:
        """Where a tile's files go: there is a folder for each of several."""
        return folder if len(self.tiles) == 1 else folder / str(tile.layout.number)


def read_source(pack: Path) -> Source:
    """Verify a pack and read it for export.

    Raises
    ------
    FaceZipError
        What :func:`facezip.read_surface` raises; ``BAD_VALUE`` for textures that are neither grey nor colour, and for
        a surface without albedo.
    """
    manifest = verify_pack(pack)
    surface = read_verified_surface(Path(pack), manifest)
    _check(pack, surface)
    layouts, tiles = _layouts(manifest), []
    for layout in layouts:
        sheets = in_sheets(_alone(surface, layout))
        _check_names(pack, [sheet.name for sheet in sheets])
        files = weight_files(manifest) if isinstance(manifest, Manifest) else layout.weight_files
        tiles.append(
            Tile(
                name=manifest.name if len(layouts) == 1 else f"{manifest.name}_{layout.number}",
                expressions=manifest.expressions,
                layout=layout,
                uniform_weights=manifest.uniform_weights,
                weight_files=tuple(Path(pack) / file for file in files),
                maps=surface.maps,
                sheets=sheets,
            )
        )
    return Source(Path(pack), manifest.name, surface, tuple(tiles))


def _layouts(manifest: AnyManifest) -> tuple[StoredTile, ...]:
    if not isinstance(manifest, Manifest):
        return manifest.tiles
    texture = StoredTexture(manifest.size, manifest.neutral_bits, manifest.difference_scale)
    weights = manifest.weight_size, manifest.weight_columns, manifest.weight_scale, manifest.weight_offset
    return (StoredTile(FIRST_TILE, *weights, (texture,)),)


def _alone(surface: CompressedTextures, layout: StoredTile) -> list[Sheet]:
    """A sheet for each map of a tile."""
    topology = shifted(surface.meshes.topology, layout.number) if surface.meshes else None
    charts_of: dict[tuple[int, int], NDArray[np.bool_]] = {}
    found = []
    for kind, texture in zip(surface.maps, layout.textures, strict=True):
        if texture.size not in charts_of:
            charts_of[texture.size] = _covered(topology, texture.size)
        scale = np.array(texture.difference_scale, np.float32) / np.float32(kind.unit)
        model = replace(surface.parts[kind.name, layout.number], meshes=None)
        maps = ((kind, slice(0, scale.shape[1])),)
        found.append(Sheet(maps, model, scale, texture.neutral_bits, charts_of[texture.size]))
    return found


def _covered(topology: Topology | None, size: tuple[int, int]) -> NDArray[np.bool_]:
    chart = np.zeros(size, np.bool_) if topology is None else covered(topology, size)
    return chart if chart.any() else np.ones(size, np.bool_)


def _check(pack: Path, surface: CompressedTextures) -> None:
    for kind in surface.maps:
        channels = surface.parts[kind.name, surface.tiles[0]].neutral.shape[2]
        if channels > CHANNELS or (kind.encoding == "srgb" and channels == 2):
            raise FaceZipError(
                ErrorCode.BAD_VALUE, f"{pack}: textures of {channels} channels; engines take those of 1 or 3"
            )
    if surface.maps[0] != KNOWN[ALBEDO]:
        raise FaceZipError(ErrorCode.BAD_VALUE, f"{pack}: has no albedo of 0 to 1, which every material here needs")


def _check_names(pack: Path, names: list[str]) -> None:
    """Raise where shaders or files could not tell sheets apart."""
    for name in names:
        if name.startswith("weights") or "__" in f"{name}_" or names.count(name) > 1:
            raise FaceZipError(
                ErrorCode.BAD_VALUE, f"{pack}: shaders cannot call a map '{name}'; compress it under another name"
            )
