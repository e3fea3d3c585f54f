"""Writing a pack: whole or not at all, for readers that refuse what is not exactly so."""

from collections.abc import Iterator, Mapping
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import Map
from facezip.character.meshes import Meshes
from facezip.character.scans import check_names
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.accessors import GlbFault
from facezip.files.images import Texels, write_texture
from facezip.files.packs import MANIFEST, is_pack
from facezip.files.writing import whole_folder
from facezip.machine.cores import cores
from facezip.machine.rows import by_rows
from facezip.pack.atlas import atlas, atlases, columns_of
from facezip.pack.checks import first_out_of_range
from facezip.pack.geometry import head_bytes
from facezip.pack.manifest import (
    ACTIVATIONS_FILE,
    HEAD_FILE,
    GeometryEntry,
    MadeWith,
    Manifest,
    MapEntry,
    MasksEntry,
    StoredFile,
    TextureEntry,
    TileEntry,
)
from facezip.pack.masked import MaskedWeights
from facezip.pack.model import CompressedTextures
from facezip.pack.parsing import MAX_BYTES
from facezip.pack.quantise import ZERO, StoredPart, StoredWeights, quantise_part, quantise_weights
from facezip.pack.verification import stored_files


def write_pack(
    model: CompressedTextures,
    path: str | Path,
    *,
    name: str = "",
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
    with whole_folder(path, overwrite, is_pack) as folder, ThreadPoolExecutor(cores()) as pool:
        geometry = pool.submit(write_geometry, model.meshes, model.expressions, name or "head", folder)
        tiles = tuple(_write_tile(model, tile, folder, pool) for tile in model.tiles)
        entry = geometry.result()
        masks = write_activations(model.masked, folder) if model.masked else None
        files = stored_files(folder, sorted(file.name for file in folder.iterdir()), pool)
        manifest = _manifest(model, name, tiles, entry, masks, dict(made_with or {}), files)
        (folder / MANIFEST).write_bytes(checked_content(path, manifest))


def checked_content(path: Path, manifest: Manifest) -> bytes:
    """The manifest's bytes, if a reader will take them."""
    wrong = first_out_of_range(manifest)
    try:
        content = b"" if wrong else manifest.to_bytes()
    except (TypeError, ValueError, RecursionError):
        # All other fields are names and finite numbers by now.
        content, wrong = b"", "made_with"
    if wrong or len(content) > MAX_BYTES:
        raise FaceZipError(
            ErrorCode.BAD_VALUE,
            f"{path}: no reader would take this pack: '{wrong or 'made_with'}' is out of range (docs/pack-format.md)",
        )
    return content


def _write_tile(model: CompressedTextures, tile: int, folder: Path, pool: Executor) -> TileEntry:
    images: dict[str, Texels] = {}
    textures = []
    for kind in model.maps:
        part = quantise_part(model.parts[kind.name, tile], kind)
        entry = _texture_entry(f"{kind.name}.{tile}", kind, part)
        images[entry.neutral] = part.neutral
        images |= {
            file: _as_image(texels, kind) for file, texels in zip(entry.differences, part.differences, strict=True)
        }
        textures.append(entry)
    weights = (
        _masks(model.masked, tile, images)
        if model.masked
        else weights_entry(quantise_weights(model.weights[tile], model.weight_ranges.get(tile)), tile, images)
    )
    list(pool.map(lambda file: write_texture(folder / file, images[file]), images))
    return replace(weights, textures=tuple(textures))


def weights_entry(weights: StoredWeights, tile: int, images: dict[str, Texels]) -> TileEntry:
    """A tile without its textures; adds the atlas of every four slots to ``images``, none for uniform weights."""
    columns = 1 if weights.uniform else columns_of(len(weights.texels))
    layers = {} if weights.uniform else dict(_layers(weights.texels, columns, tile))
    images |= layers
    return TileEntry(
        number=tile,
        weight_size=(weights.texels.shape[1], weights.texels.shape[2]),
        weight_columns=columns,
        weight_span=tuple(map(float, weights.span)),
        weight_offset=tuple(map(float, weights.offset)),
        weights=tuple(layers),
        textures=(),
    )


def _masks(masked: MaskedWeights, tile: int, images: dict[str, Texels]) -> TileEntry:
    """As :func:`weights_entry`, of masks: an atlas of them by four."""
    fours, slots = masked.fours(tile), masked.activations.shape[2]
    size, columns = (fours.shape[1], fours.shape[2]), columns_of(len(fours))
    images[f"masks.{tile}.png"] = atlas(fours, columns)
    return TileEntry(tile, size, columns, (1.0,) * slots, (0.0,) * slots, weights=(), textures=())


def write_activations(masked: MaskedWeights, folder: Path) -> MasksEntry:
    """Write them; the entry of the manifest."""
    masked.activations.astype("<f2").tofile(folder / ACTIVATIONS_FILE)
    files = tuple(f"masks.{tile}.png" for tile in sorted(masked))
    return MasksEntry(masked.names, files, ACTIVATIONS_FILE, masked.clamped)


def _texture_entry(stem: str, kind: Map, part: StoredPart) -> TextureEntry:
    slots, height, width, _ = part.differences.shape
    return TextureEntry(
        size=(height, width),
        neutral=f"{stem}.neutral.png",
        differences=tuple(f"{stem}.difference_{i}.png" for i in range(slots)),
        neutral_bits=part.bits,
        difference_span=tuple(tuple(float(value) * kind.unit for value in row) for row in part.span),
    )


def _layers(texels: NDArray[Any], columns: int, tile: int) -> Iterator[tuple[str, Texels]]:
    """The atlas of every four slots, and its file."""
    for layer, image in enumerate(atlases(texels, columns)):
        yield f"weights{f'_{layer}' if layer else ''}.{tile}.png", image


def _as_image(difference: NDArray[np.uint8], kind: Map) -> NDArray[np.uint8]:
    """A difference texture as an image: two channels get a third one that differs nowhere."""
    if not kind.is_normal:
        return difference

    def padded(rows: slice) -> NDArray[np.uint8]:
        return np.pad(difference[rows], ((0, 0), (0, 0), (0, 1)), constant_values=ZERO)

    return by_rows(padded, (*difference.shape[:2], 3), np.uint8)


def write_geometry(
    meshes: Meshes | None, expressions: tuple[str, ...], name: str, folder: Path
) -> GeometryEntry | None:
    """Write ``head.glb``, where there are meshes; the entry of the manifest."""
    if meshes is None:
        return None
    try:
        content = head_bytes(name, meshes.topology, meshes.neutral, meshes.vertices, expressions, meshes.centimetres)
    except (GlbFault, ValueError) as fault:
        raise FaceZipError(ErrorCode.BAD_VALUE, f"{folder}: its meshes cannot be stored: {fault}") from None
    (folder / HEAD_FILE).write_bytes(content)
    return GeometryEntry((HEAD_FILE,), len(meshes.neutral), len(meshes.topology.faces))


def _manifest(
    model: CompressedTextures,
    name: str,
    tiles: tuple[TileEntry, ...],
    geometry: GeometryEntry | None,
    masks: MasksEntry | None,
    made_with: MadeWith,
    files: dict[str, StoredFile],
) -> Manifest:
    is_uniform = masks is None and tiles[0].weight_size == (1, 1)
    uniform = model.weights[tiles[0].number][:, 0, 0].tolist() if is_uniform else []
    channels = {kind: model.parts[kind.name, model.tiles[0]].neutral.shape[2] for kind in model.maps}
    return Manifest(
        name=name,
        method=model.method,
        expressions=model.expressions,
        maps=tuple(MapEntry(kind.name, kind.encoding, (kind.low, kind.high), channels[kind]) for kind in model.maps),
        tiles=tiles,
        uniform_weights=tuple(map(tuple, uniform)),
        geometry=geometry,
        masks=masks,
        made_with=made_with,
        files=files,
    )
