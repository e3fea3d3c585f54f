"""Surfaces on disk: version 2 of the format, with the guarantees of version 1, which the ordinary case still is."""

from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import MapKind
from facezip.character.neutrals import packed_neutral, unpacked_neutral
from facezip.character.scans import check_names
from facezip.files.images import Texels, write_texture
from facezip.files.reading import reading
from facezip.files.writing import whole_folder
from facezip.machine.cores import cores
from facezip.machine.rows import by_rows
from facezip.pack import manifest as manifests
from facezip.pack.footprint import SLOTS_PER_LAYER
from facezip.pack.manifest import Manifest, StoredFile
from facezip.pack.model import CompressedTextures
from facezip.pack.quantise import ZERO, QuantisedMaps, dequantise, quantise
from facezip.pack.surface_manifest import (
    AnyManifest,
    StoredMap,
    StoredTexture,
    StoredTile,
    SurfaceManifest,
    versions,
)
from facezip.pack.surface_model import CompressedSurface
from facezip.pack.surface_ranges import atlas_shape, first_out_of_range
from facezip.pack.verification import is_pack, stored, verify_version
from facezip.pack.version_1 import (
    atlas,
    checked_bytes,
    checked_image,
    from_atlas,
    inside,
    read_meshes,
    read_verified,
    stacked_images,
    write_meshes,
    write_pack,
)


def write_surface(
    model: CompressedSurface,
    path: str | Path,
    *,
    name: str = "",
    neutral_bits: Mapping[tuple[str, int], int] | None = None,
    made_with: Mapping[str, Any] | None = None,
    overwrite: bool = False,
) -> None:
    """Write a pack: of version 1 where there is nothing but one albedo on one tile, else of version 2.

    Parameters
    ----------
    model : what to write.
    path, name, made_with, overwrite : as of :func:`facezip.write_pack`.
    neutral_bits : by map and tile, 8 or 16; 8 where nothing is said.

    Raises
    ------
    FaceZipError
        As :func:`facezip.write_pack`.
    """
    path, bits = Path(path), dict(neutral_bits or {})
    if model.ordinary:
        ((key, whole),) = model.parts.items()
        whole = replace(whole, meshes=model.meshes)
        write_pack(whole, path, name=name, neutral_bits=bits.get(key, 8), made_with=made_with, overwrite=overwrite)
        return
    check_names(model.expressions, path)
    with whole_folder(path, overwrite, is_pack) as folder:
        tiles = tuple(_write_tile(model, tile, bits, folder) for tile in model.tiles)
        write_meshes(model.meshes, folder)
        files = {file.name: stored(file) for file in sorted(folder.iterdir())}
        manifest = _manifest(model, tiles, name, dict(made_with or {}), files)
        wrong = first_out_of_range(manifest)
        content = checked_bytes(path, b"" if wrong else manifest.to_bytes(), wrong)
        (folder / manifests.FILE_NAME).write_bytes(content)


def read_surface(path: str | Path) -> CompressedSurface:
    """Verify a pack of any version and read it.

    Raises
    ------
    FaceZipError
        As :func:`facezip.read_pack`.
    """
    return read_verified_surface(Path(path), verify_surface(path))


def read_verified_surface(folder: Path, manifest: AnyManifest) -> CompressedSurface:
    """Read a pack whose every byte was found to be as its manifest says; ``BAD_PACK`` as :func:`read_surface`."""
    if isinstance(manifest, Manifest):
        return CompressedSurface.of(read_verified(folder, manifest))
    with reading(folder), inside(folder):
        meshes = read_meshes(folder, manifest)
        parts = {
            (kind.name, tile.number): part
            for tile in manifest.tiles
            for kind, part in zip(manifest.maps, _read_tile(folder, manifest, tile), strict=True)
        }
        return CompressedSurface(tuple(kind.kind for kind in manifest.maps), parts, meshes)


def verify_surface(path: str | Path) -> AnyManifest:
    """Check that every byte of a pack of any version is as it was written; as :func:`facezip.verify_pack`."""
    return verify_version(Path(path), versions())


def _write_tile(model: CompressedSurface, tile: int, bits: Mapping[tuple[str, int], int], folder: Path) -> StoredTile:
    maps = {kind: quantise(model.parts[kind.name, tile]) for kind in model.maps}
    first = next(iter(maps.values()))
    count, h, w, _ = first.weights.shape
    columns = 1 if first.uniform else int(np.ceil(np.sqrt(count)))
    textures = tuple(
        StoredTexture(
            size=(one.differences.shape[1], one.differences.shape[2]),
            neutral_bits=bits.get((kind.name, tile), 8),
            difference_scale=tuple(tuple(float(v) * kind.unit for v in row) for row in one.difference_scale),
        )
        for kind, one in maps.items()
    )
    scale, offset = (tuple(map(float, values)) for values in (first.weight_scale, first.weight_offset))
    stored_tile = StoredTile(tile, (h, w), columns, scale, offset, textures)
    images: dict[str, Texels] = {}
    for kind, texture in zip(model.maps, textures, strict=True):
        neutral = packed_neutral(model.parts[kind.name, tile].neutral, kind, texture.neutral_bits)
        images[stored_tile.neutral_file(kind.name)] = neutral
        files = stored_tile.difference_files(kind.name)
        images |= {file: _shown(one, kind) for file, one in zip(files, maps[kind].differences, strict=True)}
    for layer, file in enumerate(stored_tile.weight_files):
        some = first.weights[..., layer * SLOTS_PER_LAYER : (layer + 1) * SLOTS_PER_LAYER]
        images[file] = atlas(some, columns)
    with ThreadPoolExecutor(cores()) as pool:
        list(pool.map(lambda file: write_texture(folder / file, images[file]), images))
    return stored_tile


def _shown(difference: NDArray[np.uint8], kind: MapKind) -> NDArray[np.uint8]:
    """A difference texture as an image: two channels get a third one that differs nowhere."""
    if not kind.is_normal:
        return difference

    def padded(rows: slice) -> NDArray[np.uint8]:
        return np.pad(difference[rows], ((0, 0), (0, 0), (0, 1)), constant_values=ZERO)

    return by_rows(padded, (*difference.shape[:2], 3), np.uint8)


def _read_tile(folder: Path, manifest: SurfaceManifest, tile: StoredTile) -> Iterator[CompressedTextures]:
    """The maps of a tile, in their order, with the same weight maps."""
    count, slots = len(manifest.expressions), len(tile.weight_scale)
    if manifest.uniform_weights:
        weights: NDArray[np.uint8] | NDArray[np.float32] = np.array(manifest.uniform_weights, np.float32)[:, None, None]
    else:
        shape = atlas_shape(tile, count)
        layers = [checked_image(folder, file, shape, "uint8") for file in tile.weight_files]
        weights = from_atlas(layers, tile.weight_size, count, slots)
    shared: NDArray[np.float32] | None = None
    for kind, texture in zip(manifest.maps, tile.textures, strict=True):
        shape = (*texture.size, kind.stored_channels)
        differences = _fewer(stacked_images(folder, tile.difference_files(kind.name), shape), kind.channels)
        file = tile.neutral_file(kind.name)
        neutral = checked_image(folder, file, shape, f"uint{texture.neutral_bits}")
        scale = np.array(texture.difference_scale, np.float32) / np.float32(kind.kind.unit)
        maps = QuantisedMaps(
            unpacked_neutral(neutral, kind.kind), differences, scale, weights,
            np.array(tile.weight_scale, np.float32), np.array(tile.weight_offset, np.float32),
        )  # fmt: skip
        part = dequantise(maps, manifest.expressions, manifest.method, None)
        shared = part.weights if shared is None else shared
        yield replace(part, weights=shared)


def _fewer(images: NDArray[np.uint8], channels: int) -> NDArray[np.uint8]:
    """Images ``(R, H, W, C)`` without those of their channels that are for people; inverse of :func:`_shown`."""
    if images.shape[3] == channels:
        return images
    return by_rows(lambda rows: images[:, rows, :, :channels], (*images.shape[:3], channels), np.uint8, axis=1)


def _manifest(
    model: CompressedSurface,
    tiles: tuple[StoredTile, ...],
    name: str,
    made_with: dict[str, Any],
    files: dict[str, StoredFile],
) -> SurfaceManifest:
    weights = model.whole.weights
    uniform = weights[:, 0, 0].tolist() if weights.shape[1:3] == (1, 1) else []
    meshes = model.meshes
    channels = {kind: model.parts[kind.name, tiles[0].number].neutral.shape[2] for kind in model.maps}
    return SurfaceManifest(
        name=name,
        method=model.method,
        expressions=model.expressions,
        maps=tuple(StoredMap(kind.name, kind.encoding, (kind.low, kind.high), channels[kind]) for kind in model.maps),
        tiles=tiles,
        uniform_weights=tuple(map(tuple, uniform)),
        vertices=len(meshes.neutral) if meshes else 0,
        triangles=len(meshes.topology.faces) if meshes else 0,
        texture_coordinates=len(meshes.topology.uv) if meshes else 0,
        made_with=made_with,
        files=files,
    )
