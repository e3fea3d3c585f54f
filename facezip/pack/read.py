"""Reading a pack: nothing is read from one that fails verification."""

from collections.abc import Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from facezip.character.meshes import Meshes
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.accessors import GlbFault
from facezip.files.images import Texels, read_texture_exactly
from facezip.files.obj import read_obj
from facezip.files.reading import reading, undisturbed
from facezip.machine import memory
from facezip.machine.cores import cores
from facezip.machine.rows import by_rows
from facezip.pack.atlas import from_atlas
from facezip.pack.checks import atlas_shape
from facezip.pack.footprint import SLOTS_PER_LAYER
from facezip.pack.geometry import read_head, states_centimetres
from facezip.pack.manifest import HEAD_FILE, GeometryEntry, Manifest, MapEntry, MasksEntry, TextureEntry, TileEntry
from facezip.pack.masked import MaskedWeights
from facezip.pack.model import CompressedTextures
from facezip.pack.parsing import bad_pack
from facezip.pack.quantise import StoredPart, StoredTextures, StoredWeights
from facezip.pack.verification import verify_pack


def read_pack(path: str | Path) -> CompressedTextures:
    """Verify a pack of any version and read it.

    Raises
    ------
    FaceZipError
        What :func:`facezip.verify_pack` raises; ``BAD_PACK`` too for a file whose content is not what the manifest
        says. Nothing is read from a pack that fails verification.
    """
    _, stored = read_bytes(Path(path))
    return stored.dequantised()


def read_bytes(folder: Path) -> tuple[Manifest, StoredTextures]:
    """Verify a pack of any version; its manifest, and what it holds as it is stored. Raises as :func:`read_pack`."""

    def verified() -> tuple[Manifest, StoredTextures]:
        manifest = verify_pack(folder)
        memory.check(_row_bytes(manifest))
        return manifest, read_stored(folder, manifest)

    return undisturbed(folder, verified)


def _row_bytes(manifest: Manifest) -> int:
    """Of one row of a map's neutral and differences, as they are stored and as floats."""
    return max(
        5 * (1 + len(texture.differences)) * texture.size[1] * kind.image_channels
        for kind, texture in manifest.entries().values()
    )


def read_stored(folder: Path, manifest: Manifest) -> StoredTextures:
    """What a verified pack holds, as it is stored; ``BAD_PACK`` as :func:`read_pack`."""
    with reading(folder), _inside(folder), ThreadPoolExecutor(cores()) as pool:
        geometry = manifest.geometry
        meshes = pool.submit(_meshes, folder, geometry, manifest.expressions) if geometry else None
        return StoredTextures(
            manifest.method,
            manifest.expressions,
            tuple(entry.kind for entry in manifest.maps),
            {key: _part(folder, *entries, pool) for key, entries in manifest.entries().items()},
            _masked(folder, manifest, manifest.masks)
            if manifest.masks
            else {tile.number: _weights(folder, manifest, tile) for tile in manifest.tiles},
            meshes.result() if meshes else None,
        )


@contextmanager
def _inside(folder: Path) -> Iterator[None]:
    """What is wrong with an image or mesh of a pack is wrong with the pack."""
    try:
        yield
    except FaceZipError as error:
        raise error if error.code is ErrorCode.BAD_PACK else bad_pack(folder, str(error)) from None


def _part(folder: Path, entry: MapEntry, texture: TextureEntry, pool: Executor) -> StoredPart:
    shape = (*texture.size, entry.image_channels)
    differences: NDArray[np.uint8] = memory.empty((len(texture.differences), *shape), np.uint8)
    jobs = zip(texture.differences, differences, strict=True)
    read = pool.map(lambda job: _image(folder, job[0], shape, "uint8", job[1]), jobs)
    neutral = pool.submit(_image, folder, texture.neutral, shape, f"uint{texture.neutral_bits}")
    list(read)
    # In doubles, in which the writer's multiplication is exact: the very span that was fitted comes back.
    span = (np.array(texture.difference_span, np.float64) / entry.kind.unit).astype(np.float32)
    return StoredPart(neutral.result(), _fewer(differences, entry.channels), span)


def _fewer(images: NDArray[np.uint8], channels: int) -> NDArray[np.uint8]:
    """Images ``(R, H, W, C)`` without those of their channels that are for people."""
    if images.shape[3] == channels:
        return images
    return by_rows(lambda rows: images[:, rows, :, :channels], (*images.shape[:3], channels), np.uint8, axis=1)


def _weights(folder: Path, manifest: Manifest, tile: TileEntry) -> StoredWeights:
    span, offset = np.array(tile.weight_span, np.float32), np.array(tile.weight_offset, np.float32)
    if manifest.uniform_weights:
        return StoredWeights(np.array(manifest.uniform_weights, np.float32)[:, None, None, :], span, offset)
    count = len(manifest.expressions)
    layers = [_image(folder, file, atlas_shape(tile, count), "uint8") for file in tile.weights]
    return StoredWeights(from_atlas(layers, tile.weight_size, count, len(span)), span, offset)


def _by_mask(fours: NDArray[np.uint8], count: int) -> NDArray[np.uint8]:
    """Masks ``(K, h, w)`` of an atlas's places ``(K' / 4, h, w, 4)``."""
    _, height, width, _ = fours.shape

    def rows_of(rows: slice) -> NDArray[np.uint8]:
        return fours[:, rows].transpose(0, 3, 1, 2).reshape(-1, rows.stop - rows.start, width)[:count]

    return by_rows(rows_of, (count, height, width), np.uint8, axis=1)


def _masked(folder: Path, manifest: Manifest, entry: MasksEntry) -> MaskedWeights:
    count, slots = len(entry.names), len(manifest.tiles[0].weight_span)
    masks = {}
    for tile, file in zip(manifest.tiles, entry.files, strict=True):
        image = _image(folder, file, atlas_shape(tile, entry.fours), "uint8")
        fours = from_atlas([image], tile.weight_size, entry.fours, SLOTS_PER_LAYER)
        masks[tile.number] = _by_mask(fours, count)
    stored = np.fromfile(folder / entry.activations, "<f2").astype(np.float16)
    activations = stored.reshape(len(manifest.expressions), count, slots)
    masked = MaskedWeights(entry.names, masks, activations)
    if not np.isfinite(activations).all() or masked.clamped != entry.clamped:
        where = "all within 0 and 1" if entry.clamped else "finite numbers, some of them outside 0..1"
        raise bad_pack(folder, f"'{entry.activations}' does not hold {where}")
    return masked


def _meshes(folder: Path, geometry: GeometryEntry, expressions: tuple[str, ...]) -> Meshes:
    centimetres = False
    if geometry.files == (HEAD_FILE,):
        try:
            content = (folder / HEAD_FILE).read_bytes()
            topology, neutral, vertices = read_head(content, expressions)
            centimetres = states_centimetres(content)
        except GlbFault as fault:
            raise bad_pack(folder, f"'{HEAD_FILE}': {fault}") from None
    else:
        mesh_file, deltas_file = geometry.files
        neutral, topology = read_obj(folder / mesh_file)
        deltas = np.fromfile(folder / deltas_file, "<f4").astype(np.float32)
        if deltas.size != len(expressions) * neutral.size or not np.isfinite(deltas).all():
            raise bad_pack(folder, f"'{deltas_file}' does not hold finite numbers for every vertex")
        vertices = neutral + deltas.reshape(-1, *neutral.shape)
    if (len(neutral), len(topology.faces)) != (geometry.vertices, geometry.triangles):
        raise bad_pack(folder, "its meshes are not as stated")
    return Meshes(topology, neutral, vertices, centimetres)


def _image(folder: Path, file: str, shape: tuple[int, ...], dtype: str, into: Texels | None = None) -> Texels:
    """An image of the shape and type that a manifest states, in ``into`` if that is given; or ``BAD_PACK``."""
    texels = read_texture_exactly(folder / file, shape, into)
    if texels.dtype != dtype:
        raise bad_pack(folder, f"'{file}' holds {texels.dtype}, not {dtype}")
    return texels
