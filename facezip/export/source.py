"""What every export starts from: a verified pack, by tiles, and which of its texels the surface shows."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import ALBEDO, KNOWN, Map
from facezip.character.meshes import Meshes
from facezip.character.tiles import charts, shifted
from facezip.character.units import in_metres
from facezip.errors import ErrorCode, FaceZipError
from facezip.export.fill import Fill, shown
from facezip.export.joining import CHANNELS, joined
from facezip.export.masks import MOST_VECTORS, Masks
from facezip.export.regions import Regions, read_regions
from facezip.export.sheets import Sheet
from facezip.files.images import Texels
from facezip.files.obj import Topology
from facezip.files.reading import reading, undisturbed
from facezip.machine import memory
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
    layout : UDIM number, and how the weight maps, or else the masks, lie.
    uniform_weights : N lists of R numbers where weights are uniform, else empty.
    weight_images : the atlas of every four slots: the bytes of the pack's PNG, or texels of weight maps that are made
        of masks; none for uniform weights, and where the pre-pass combines masks.
    maps : the kinds, albedo first.
    sheets : the textures that hold them; the albedo's first.
    regions : of the face, which can be turned down.
    masks : what the pre-pass combines in the place of weight maps; None where it combines those.
    """

    name: str
    expressions: tuple[str, ...]
    layout: TileEntry
    uniform_weights: tuple[tuple[float, ...], ...]
    weight_images: tuple[bytes | Texels, ...]
    maps: tuple[Map, ...]
    sheets: tuple[Sheet, ...]
    regions: Regions
    masks: Masks | None = None

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
    geometry : the meshes as the pack has them, or None.
    tiles : what its materials show; one of them in an ordinary export.
    """

    path: Path
    name: str
    expressions: tuple[str, ...]
    geometry: Meshes | None
    tiles: tuple[Tile, ...]

    @cached_property
    def meshes(self) -> Meshes:
        """The geometry, in metres where its unit is known; ``BAD_VALUE`` where the pack has none."""
        if self.geometry is None:
            raise FaceZipError(
                ErrorCode.BAD_VALUE, f"{self.path}: has no meshes to export; compress a character with its meshes"
            )
        return in_metres(self.geometry)

    @property
    def charts(self) -> list[Topology]:
        """The faces of each tile."""
        return charts(self.meshes.topology, [tile.layout.number for tile in self.tiles])

    def folder_of(self, tile: Tile, folder: Path) -> Path:
        """Where a tile's files go: there is a folder for each of several."""
        return folder if len(self.tiles) == 1 else folder / str(tile.layout.number)


def read_source(
    pack: Path,
    maps: str = TOGETHER,
    normals_alone: bool = False,
    regions: Mapping[str, Path] | None = None,
    expanded: bool = False,
) -> Source:
    """Verify a pack and read it for export.

    Parameters
    ----------
    pack : its folder.
    maps : ``"together"`` where maps share textures as far as they fit, ``"apart"`` where each has its own.
    normals_alone : whether normals share with no map as long as that takes no fetch more.
    regions : images of regions of the face, by their names.
    expanded : whether weight maps are made of masks here, for what has no pre-pass that combines those.

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
        masks = None if expanded else _masks(entry, read)
        layout, images = (entry, ()) if masks else _weight_maps(entry, read)
        alone = tuple(_alone(stored, entry.number, _seen(stored, entry.number, masks)))
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
                regions=read.regions[entry.number],
                masks=masks,
            )
        )
    return Source(pack, manifest.name, manifest.expressions, stored.meshes, tuple(tiles))


class _Read(NamedTuple):
    """What is read of a pack, and by tile the regions of the face and the files of weight maps, or of masks."""

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
        weights = {
            number: tuple((pack / file).read_bytes() for file in files) for number, files in _images(manifest).items()
        }
    return _Read(manifest, stored, found, weights)


def _images(manifest: Manifest) -> dict[int, tuple[str, ...]]:
    """By tile the files of weight maps, or the one of masks."""
    if manifest.masks is None:
        return {tile.number: tile.weights for tile in manifest.tiles}
    return {tile.number: (file,) for tile, file in zip(manifest.tiles, manifest.masks.files, strict=True)}


def _masks(tile: TileEntry, read: _Read) -> Masks | None:
    """The masks of a tile, where there are any, and not more than shaders take."""
    weights = read.stored.weights
    if not isinstance(weights, MaskedWeights):
        return None
    (image,) = read.weights[tile.number]
    masks = Masks(weights.names, image, tile.weight_columns, tile.weight_size, weights.vectors, weights.clamped)
    return masks if masks.count <= MOST_VECTORS else None


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


def _seen(stored: StoredTextures, tile: int, masks: Masks | None) -> NDArray[np.float32]:
    """Weight maps ``(N, h, w, R)`` as shaders see them: not rounded where a pre-pass makes them of masks."""
    if masks is not None and isinstance(stored.weights, MaskedWeights):
        return stored.weights[tile]
    return stored.weight_maps(tile).values


def _alone(stored: StoredTextures, tile: int, weights: NDArray[np.float32]) -> Iterator[Sheet]:
    """A sheet for each map of a tile, under the weights ``(N, h, w, R)``."""
    topology = shifted(stored.meshes.topology, tile) if stored.meshes else None
    fills: dict[tuple[int, int], Fill] = {}
    for kind in stored.maps:
        part = stored.parts[kind.name, tile]
        _, height, width, channels = part.differences.shape
        if (height, width) not in fills:
            fills[height, width] = Fill(shown(topology, (height, width)))
        yield Sheet(
            ((kind, slice(0, channels)),),
            part.neutral[..., :channels],
            part.differences,
            part.span,
            stored.expressions,
            weights,
            fills[height, width],
        )


def _row_bytes(manifest: Manifest) -> int:
    """Of one row of every expression, in 16 bits, with as many channels as maps that share textures may have."""
    widest = max(texture.size[1] for _, texture in manifest.entries().values())
    return 2 * CHANNELS * widest * len(manifest.expressions)


def _whole_bytes(manifest: Manifest) -> int:
    """Of ``head.glb`` while it is put together: the neutrals' images, and mesh and normals of every expression.

    And of the files of weight maps or masks, from the beginning to the end.
    """
    images = sum(manifest.files[texture.neutral].bytes for _, texture in manifest.entries().values())
    vertices = manifest.geometry.vertices if manifest.geometry else 0
    weights = sum(manifest.files[file].bytes for files in _images(manifest).values() for file in files)
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
