"""The pack on disk: written whole or not at all, verified before use, readable by an engine without this code."""

from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from facezip.character.scans import check_names
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.images import Texels, read_texture_exactly, write_texture
from facezip.files.obj import read_obj, write_obj
from facezip.files.reading import reading
from facezip.files.writing import whole_folder
from facezip.machine import memory
from facezip.machine.cores import cores
from facezip.pack import manifest as manifests
from facezip.pack.footprint import SLOTS_PER_LAYER
from facezip.pack.manifest import Manifest, StoredFile, bad_pack
from facezip.pack.model import CompressedTextures, Meshes
from facezip.pack.quantise import QuantisedMaps, dequantise, quantise
from facezip.pack.ranges import (
    DELTAS_FILE,
    MESH_FILE,
    NEUTRAL_FILE,
    atlas_shape,
    difference_files,
    first_out_of_range,
    weight_files,
)
from facezip.pack.verification import bytes_on_disk, is_pack, stored, verify_pack

if TYPE_CHECKING:
    from facezip.pack.surface_manifest import AnyManifest

__all__ = ["NEUTRAL_FILE", "bytes_on_disk", "is_pack", "read_pack", "verify_pack", "write_pack"]


def write_pack(
    model: CompressedTextures,
    path: str | Path,
    *,
    name: str = "",
    neutral_bits: int = 8,
    made_with: Mapping[str, Any] | None = None,
    overwrite: bool = False,
) -> None:
    """Quantise a model to 8 bits and write it as the folder ``path``.

    The same model and ``made_with`` give the same bytes, wherever they are written.

    Parameters
    ----------
    model : what to write.
    path : the folder, by custom ``NAME.facezip``.
    name : what the character is called; where empty, readers take the stem of the folder's name.
    neutral_bits : bits of a channel of the neutral, 8 or 16.
    made_with : options and the like, for people; anything that JSON holds.
    overwrite : whether an existing pack may be replaced.

    Raises
    ------
    FaceZipError
        ``CANNOT_WRITE``: the folder exists (without ``overwrite``), is no pack, or the disk refuses. What was there
        before is then untouched. ``UNSAFE_NAME``: an expression's name cannot be a file name. ``BAD_VALUE``: what no
        reader would accept.
    """
    path = Path(path)
    check_names(model.expressions, path)
    maps = quantise(model, neutral_bits)
    with whole_folder(path, overwrite, is_pack) as folder:
        columns = _write_maps(maps, folder)
        write_meshes(model.meshes, folder)
        files = {file.name: stored(file) for file in sorted(folder.iterdir())}
        manifest = _manifest(model, maps, name, columns, dict(made_with or {}), files)
        wrong = first_out_of_range(manifest)
        (folder / manifests.FILE_NAME).write_bytes(checked_bytes(path, b"" if wrong else manifest.to_bytes(), wrong))


def read_pack(path: str | Path) -> CompressedTextures:
    """Verify a pack and read it.

    Raises
    ------
    FaceZipError
        What :func:`verify_pack` raises; ``BAD_PACK`` too for a file whose content is not what the manifest says.
        Nothing is read from a pack that fails verification.
    """
    folder = Path(path)
    return read_verified(folder, verify_pack(folder))


def read_verified(folder: Path, manifest: Manifest) -> CompressedTextures:
    """Read a pack whose every byte was found to be as its manifest says; ``BAD_PACK`` as :func:`read_pack`."""
    maps, meshes = read_stored(folder, manifest)
    return dequantise(maps, manifest.expressions, manifest.method, meshes)


def read_stored(folder: Path, manifest: Manifest) -> tuple[QuantisedMaps, Meshes | None]:
    """What a verified pack holds, its maps as they are stored; ``BAD_PACK`` as :func:`read_pack`."""
    with reading(folder), inside(folder):
        return _read_maps(folder, manifest), read_meshes(folder, manifest)


def _read_maps(folder: Path, manifest: Manifest) -> QuantisedMaps:
    shape, files = (*manifest.size, manifest.channels), difference_files(manifest)
    return QuantisedMaps(
        neutral=checked_image(folder, NEUTRAL_FILE, shape, f"uint{manifest.neutral_bits}"),
        differences=stacked_images(folder, files, shape),
        difference_scale=np.array(manifest.difference_scale, np.float32),
        weights=_read_weights(folder, manifest),
        weight_scale=np.array(manifest.weight_scale, np.float32),
        weight_offset=np.array(manifest.weight_offset, np.float32),
    )


def stacked_images(folder: Path, files: list[str], shape: tuple[int, ...]) -> NDArray[np.uint8]:
    """8-bit images of one ``shape``, one after the other; raises as :func:`checked_image`."""
    images: NDArray[np.uint8] = memory.empty((len(files), *shape), np.uint8)
    with ThreadPoolExecutor(cores()) as pool:
        list(pool.map(lambda i: checked_image(folder, files[i], shape, "uint8", images[i]), range(len(files))))
    return images


@contextmanager
def inside(folder: Path) -> Iterator[None]:
    """What is wrong with an image or mesh of a pack is wrong with the pack."""
    try:
        yield
    except FaceZipError as error:
        raise error if error.code is ErrorCode.BAD_PACK else bad_pack(folder, str(error)) from None


def checked_bytes(path: Path, content: bytes, wrong: str | None) -> bytes:
    """A manifest's bytes, if a reader will take them; ``wrong`` is the first field that it would not."""
    if wrong or len(content) > manifests.MAX_BYTES:
        raise FaceZipError(
            ErrorCode.BAD_VALUE,
            f"{path}: no reader would take this pack: '{wrong or 'made_with'}' is out of range (docs/pack-format.md)",
        )
    return content


def _manifest(
    model: CompressedTextures,
    maps: QuantisedMaps,
    name: str,
    columns: int,
    made_with: dict[str, Any],
    files: dict[str, StoredFile],
) -> Manifest:
    _, height, width, channels = maps.differences.shape
    uniform = [[float(value) for value in row] for row in maps.weights[:, 0, 0]] if maps.uniform else []
    topology = model.meshes.topology if model.meshes else None
    return Manifest(
        name=name,
        method=model.method,
        size=(height, width),
        channels=channels,
        neutral_bits=8 * maps.neutral.itemsize,
        expressions=model.expressions,
        difference_scale=tuple(tuple(map(float, row)) for row in maps.difference_scale),
        weight_size=(maps.weights.shape[1], maps.weights.shape[2]),
        weight_columns=columns,
        weight_scale=tuple(map(float, maps.weight_scale)),
        weight_offset=tuple(map(float, maps.weight_offset)),
        uniform_weights=tuple(map(tuple, uniform)),
        vertices=len(model.meshes.neutral) if model.meshes else 0,
        triangles=len(topology.faces) if topology else 0,
        texture_coordinates=len(topology.uv) if topology else 0,
        made_with=made_with,
        files=files,
    )


def _write_maps(maps: QuantisedMaps, folder: Path) -> int:
    images: dict[str, Texels] = {NEUTRAL_FILE: maps.neutral}
    images |= {f"difference_{i}.png": difference for i, difference in enumerate(maps.differences)}
    columns = 1 if maps.uniform else int(np.ceil(np.sqrt(len(maps.weights))))
    if not maps.uniform:
        for first in range(0, maps.weights.shape[3], SLOTS_PER_LAYER):
            slots = maps.weights[..., first : first + SLOTS_PER_LAYER]
            images[f"weights_{first // SLOTS_PER_LAYER}.png" if first else "weights.png"] = atlas(slots, columns)
    with ThreadPoolExecutor(cores()) as pool:
        list(pool.map(lambda file: write_texture(folder / file, images[file]), images))
    return columns


def atlas(slots: NDArray[Any], columns: int) -> NDArray[np.uint8]:
    """``(N, h, w, ≤4)`` weight maps as one RGBA image, in expression order, row by row."""
    n, h, w, used = slots.shape
    image: NDArray[np.uint8] = memory.zeros((-(-n // columns) * h, columns * w, SLOTS_PER_LAYER), np.uint8)
    for place, slot in zip(_places(n, (h, w), columns), slots, strict=True):
        image[(*place, slice(used))] = slot
        memory.ease()
    return image


def _places(count: int, size: tuple[int, int], columns: int) -> Iterator[tuple[slice, slice]]:
    """The rows and columns of each weight map in an atlas."""
    h, w = size
    for n in range(count):
        row, column = divmod(n, columns)
        yield slice(row * h, (row + 1) * h), slice(column * w, (column + 1) * w)


def _read_weights(folder: Path, manifest: Manifest) -> NDArray[np.uint8] | NDArray[np.float32]:
    if manifest.uniform_weights:
        return np.array(manifest.uniform_weights, np.float32)[:, None, None, :]
    layers = [checked_image(folder, file, atlas_shape(manifest), "uint8") for file in weight_files(manifest)]
    return from_atlas(layers, manifest.weight_size, len(manifest.expressions), len(manifest.weight_scale))


def from_atlas(layers: list[Texels], size: tuple[int, int], count: int, slots: int) -> NDArray[np.uint8]:
    """Weight maps ``(N, h, w, R)`` out of the atlas images of every four slots; inverse of :func:`atlas`."""
    h, w = size
    columns = layers[0].shape[1] // w
    weights: NDArray[np.uint8] = memory.empty((count, h, w, slots), np.uint8)
    for n, place in enumerate(_places(count, size, columns)):
        weights[n] = np.concatenate([layer[place] for layer in layers], axis=2)[..., :slots]
        memory.ease()
    return weights


def write_meshes(meshes: Meshes | None, folder: Path) -> None:
    """Neutral and deltas, where there are meshes."""
    if meshes is not None:
        write_obj(folder / MESH_FILE, meshes.neutral, meshes.topology)
        (folder / DELTAS_FILE).write_bytes(meshes.deltas.astype("<f4").tobytes())


def read_meshes(folder: Path, manifest: "AnyManifest") -> Meshes | None:
    """What :func:`write_meshes` wrote; ``BAD_PACK`` where it is not as stated."""
    if manifest.vertices == 0:
        return None
    neutral, topology = read_obj(folder / MESH_FILE)
    sizes = (len(neutral), len(topology.faces), len(topology.uv))
    deltas = np.fromfile(folder / DELTAS_FILE, "<f4")
    if sizes != (manifest.vertices, manifest.triangles, manifest.texture_coordinates) or not np.isfinite(deltas).all():
        raise bad_pack(folder, "its meshes are not as stated, or not of finite numbers")
    return Meshes(topology, neutral, deltas.astype(np.float32).reshape(-1, len(neutral), 3))


def checked_image(folder: Path, file: str, shape: tuple[int, ...], dtype: str, into: Texels | None = None) -> Texels:
    """An image of the shape and type that a manifest states, in ``into`` if that is given; or ``BAD_PACK``."""
    texels = read_texture_exactly(folder / file, shape, into)
    if texels.dtype != dtype:
        raise bad_pack(folder, f"'{file}' holds {texels.dtype}, not {dtype}")
    return texels
