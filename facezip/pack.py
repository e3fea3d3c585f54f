"""The pack on disk: written whole or not at all, verified before use, readable by an engine without this code."""

import hashlib
import json
import os
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip import manifest as manifests
from facezip.errors import ErrorCode, FaceZipError
from facezip.footprint import SLOTS_PER_LAYER
from facezip.manifest import Manifest, StoredFile, read_manifest
from facezip.meshes import read_obj, write_obj
from facezip.model import CompressedTextures, Meshes
from facezip.quantise import QuantisedMaps, dequantise, quantise
from facezip.textures import Texels, read_texture_exactly, write_texture
from facezip.writing import whole_folder

NEUTRAL_FILE = "neutral.png"
MESH_FILE = "neutral.obj"
DELTAS_FILE = "deltas.f32"


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

    Raises
    ------
    FaceZipError
        ``CANNOT_WRITE``: the folder exists (without ``overwrite``), is no pack, or the disk refuses. What was there
        before is then untouched. ``BAD_VALUE``: an expression's name cannot be a file name.
    """
    path = Path(path)
    unsafe = [expression for expression in model.expressions if not manifests.is_safe_name(expression)]
    if unsafe:
        raise FaceZipError(ErrorCode.BAD_VALUE, f"expression name {unsafe[0]!r} cannot be a file name; rename it")
    maps = quantise(model, neutral_bits)
    with whole_folder(path, overwrite, is_pack) as folder:
        columns = _write_maps(maps, folder)
        _write_meshes(model.meshes, folder)
        files = {file.name: _stored(file) for file in sorted(folder.iterdir())}
        manifest = _manifest(model, maps, name or path.stem, columns, dict(made_with or {}), files)
        (folder / manifests.FILE_NAME).write_bytes(manifest.to_bytes())


def read_pack(path: str | Path) -> CompressedTextures:
    """Verify a pack and read it.

    Raises
    ------
    FaceZipError
        ``BAD_PACK``: one line with what is wrong; nothing is read from a pack that fails verification.
    """
    manifest = verify_pack(path)
    folder = Path(path)
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        differences = list(pool.map(lambda file: _image(folder, file, manifest, "uint8"), _difference_files(manifest)))
    maps = QuantisedMaps(
        neutral=_image(folder, NEUTRAL_FILE, manifest, f"uint{manifest.neutral_bits}"),
        differences=np.stack(differences),
        difference_scale=np.array(manifest.difference_scale, np.float32),
        weights=_read_weights(folder, manifest),
        weight_scale=np.array(manifest.weight_scale, np.float32),
        weight_offset=np.array(manifest.weight_offset, np.float32),
    )
    return dequantise(maps, manifest.expressions, manifest.method, _read_meshes(folder, manifest))


def verify_pack(path: str | Path) -> Manifest:
    """Check that every byte of a pack is as it was written and that nothing was added.

    Raises
    ------
    FaceZipError
        ``BAD_PACK``: a file that is missing, added, linked, of another length, or with another checksum; a manifest
        that does not describe the files.
    """
    folder = Path(path)
    if not folder.is_dir():
        raise FaceZipError(ErrorCode.MISSING_FILE, f"{folder}: no such pack; give a folder NAME.facezip")
    manifest = read_manifest(folder)
    if {*manifest.files} != {*_expected_files(manifest)}:
        raise _bad(folder, "the manifest lists other files than its fields need")
    present = {entry.name for entry in folder.iterdir()}
    for name in sorted(present ^ {*manifest.files, manifests.FILE_NAME}):
        raise _bad(folder, f"'{name}' is {'not part of the pack' if name in present else 'missing'}")
    for name, stated in manifest.files.items():
        if (folder / name).is_symlink() or not (folder / name).is_file():
            raise _bad(folder, f"'{name}' is a link or folder, not a file")
        if (folder / name).stat().st_size != stated.bytes or _stored(folder / name) != stated:
            raise _bad(folder, f"'{name}' was changed or damaged after it was written; restore it or compress again")
    return manifest


def is_pack(folder: Path) -> bool:
    """Whether a folder looks like a pack, intact or not: only such a folder may be overwritten by one."""
    try:
        return bool(json.loads((folder / manifests.FILE_NAME).read_bytes())["format"].startswith("facezip-pack/"))
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return False


def bytes_on_disk(folder: str | Path) -> int:
    """Bytes of all files of a pack."""
    return sum(file.stat().st_size for file in Path(folder).iterdir())


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
        for layer, file in enumerate(_weight_files(maps.weights.shape[3])):
            slots = maps.weights[..., layer * SLOTS_PER_LAYER : (layer + 1) * SLOTS_PER_LAYER].astype(np.uint8)
            images[file] = _atlas(slots, columns)
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        list(pool.map(lambda file: write_texture(folder / file, images[file]), images))
    return columns


def _atlas(slots: NDArray[np.uint8], columns: int) -> NDArray[np.uint8]:
    """``(N, h, w, ≤4)`` weight maps as one RGBA image, in expression order, row by row."""
    n, h, w, used = slots.shape
    rows = -(-n // columns)
    padded = np.zeros((rows * columns, h, w, SLOTS_PER_LAYER), np.uint8)
    padded[:n, ..., :used] = slots
    return padded.reshape(rows, columns, h, w, -1).swapaxes(1, 2).reshape(rows * h, columns * w, -1)


def _read_weights(folder: Path, manifest: Manifest) -> NDArray[np.uint8] | NDArray[np.float32]:
    slots, n, (h, w) = len(manifest.weight_scale), len(manifest.expressions), manifest.weight_size
    if manifest.uniform_weights:
        return np.array(manifest.uniform_weights, np.float32)[:, None, None, :]
    columns = manifest.weight_columns
    shape = (-(-n // columns) * h, columns * w, SLOTS_PER_LAYER)
    layers = [_checked_image(folder, file, shape, "uint8") for file in _weight_files(slots)]
    stacked = [layer.reshape(-1, h, columns, w, 4).swapaxes(1, 2).reshape(-1, h, w, 4)[:n] for layer in layers]
    return np.concatenate(stacked, axis=3)[..., :slots].astype(np.uint8)


def _write_meshes(meshes: Meshes | None, folder: Path) -> None:
    if meshes is not None:
        write_obj(folder / MESH_FILE, meshes.neutral, meshes.topology)
        (folder / DELTAS_FILE).write_bytes(meshes.deltas.astype("<f4").tobytes())


def _read_meshes(folder: Path, manifest: Manifest) -> Meshes | None:
    if manifest.vertices == 0:
        return None
    neutral, topology = read_obj(folder / MESH_FILE)
    shape = (len(manifest.expressions), len(neutral), 3)
    deltas = np.fromfile(folder / DELTAS_FILE, "<f4")
    sizes = (len(neutral), len(topology.faces), len(topology.uv))
    if sizes != (manifest.vertices, manifest.triangles, manifest.texture_coordinates) or deltas.size != np.prod(shape):
        raise _bad(folder, "its meshes are not of the stated size")
    return Meshes(topology, neutral, deltas.astype(np.float32).reshape(shape))


def _image(folder: Path, file: str, manifest: Manifest, dtype: str) -> Texels:
    return _checked_image(folder, file, (*manifest.size, manifest.channels), dtype)


def _checked_image(folder: Path, file: str, shape: tuple[int, ...], dtype: str) -> Texels:
    texels = read_texture_exactly(folder / file, shape)
    if texels.dtype != dtype:
        raise _bad(folder, f"'{file}' holds {texels.dtype}, not {dtype}")
    return texels


def _expected_files(manifest: Manifest) -> Iterator[str]:
    yield NEUTRAL_FILE
    yield from _difference_files(manifest)
    if not manifest.uniform_weights:
        yield from _weight_files(len(manifest.weight_scale))
    if manifest.vertices:
        yield from (MESH_FILE, DELTAS_FILE)


def _difference_files(manifest: Manifest) -> list[str]:
    return [f"difference_{i}.png" for i in range(len(manifest.difference_scale))]


def _weight_files(slots: int) -> list[str]:
    layers = -(-slots // SLOTS_PER_LAYER)
    return ["weights.png", *(f"weights_{layer}.png" for layer in range(1, layers))]


def _stored(file: Path) -> StoredFile:
    with open(file, "rb") as content:
        return StoredFile(file.stat().st_size, hashlib.file_digest(content, "sha256").hexdigest())


def _bad(folder: Path, reason: str) -> FaceZipError:
    return FaceZipError(ErrorCode.BAD_PACK, f"{folder}: not a usable pack: {reason}")
