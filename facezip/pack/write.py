"""Writing a pack: whole or not at all, for readers that refuse what is not exactly so."""

from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import Map
from facezip.character.scans import check_names
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.glb import GlbFault
from facezip.files.images import Texels, write_texture
from facezip.files.writing import whole_folder
from facezip.machine.cores import cores
from facezip.machine.rows import by_rows
from facezip.pack.atlas import atlas
from facezip.pack.checks import first_out_of_range
from facezip.pack.footprint import SLOTS_PER_LAYER
from facezip.pack.geometry import head_bytes
from facezip.pack.manifest import (
    FILE_NAME,
    HEAD_FILE,
    GeometryEntry,
    Manifest,
    MapEntry,
    StoredFile,
    TextureEntry,
    TileEntry,
)
from facezip.pack.model import CompressedTextures
from facezip.pack.parsing import MAX_BYTES
from facezip.pack.quantise import ZERO, StoredPart, StoredWeights, quantise_part, quantise_weights
from facezip.pack.verification import is_pack, stored


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
    with whole_folder(path, overwrite, is_pack) as folder:
        tiles = tuple(_write_tile(model, tile, folder) for tile in model.tiles)
        geometry = _write_geometry(model, name or "head", folder)
        files = {file.name: stored(file) for file in sorted(folder.iterdir())}
        manifest = _manifest(model, name, tiles, geometry, dict(made_with or {}), files)
        (folder / FILE_NAME).write_bytes(_content(path, manifest))


def _content(path: Path, manifest: Manifest) -> bytes:
    """The manifest's bytes, if a reader will take them."""
    wrong = first_out_of_range(manifest)
    content = b"" if wrong else manifest.to_bytes()
    if wrong or len(content) > MAX_BYTES:
        raise FaceZipError(
            ErrorCode.BAD_VALUE,
            f"{path}: no reader would take this pack: '{wrong or 'made_with'}' is out of range (docs/pack-format.md)",
        )
    return content


def _write_tile(model: CompressedTextures, tile: int, folder: Path) -> TileEntry:
    weights = quantise_weights(model.weights[tile])
    columns = 1 if weights.uniform else int(np.ceil(np.sqrt(len(weights.texels))))
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
    layers = _layers(weights, columns, tile)
    images |= layers
    with ThreadPoolExecutor(cores()) as pool:
        list(pool.map(lambda file: write_texture(folder / file, images[file]), images))
    return TileEntry(
        number=tile,
        weight_size=(weights.texels.shape[1], weights.texels.shape[2]),
        weight_columns=columns,
        weight_span=tuple(map(float, weights.span)),
        weight_offset=tuple(map(float, weights.offset)),
        weights=tuple(layers),
        textures=tuple(textures),
    )


def _texture_entry(stem: str, kind: Map, part: StoredPart) -> TextureEntry:
    slots, height, width, _ = part.differences.shape
    return TextureEntry(
        size=(height, width),
        neutral=f"{stem}.neutral.png",
        differences=tuple(f"{stem}.difference_{i}.png" for i in range(slots)),
        neutral_bits=part.bits,
        difference_span=tuple(tuple(float(value) * kind.unit for value in row) for row in part.span),
    )


def _layers(weights: StoredWeights, columns: int, tile: int) -> dict[str, Texels]:
    """The atlas of every four slots, by file; none for uniform weights."""
    if weights.uniform:
        return {}
    found: dict[str, Texels] = {}
    for layer, slot in enumerate(range(0, weights.texels.shape[3], SLOTS_PER_LAYER)):
        file = f"weights{f'_{layer}' if layer else ''}.{tile}.png"
        found[file] = atlas(weights.texels[..., slot : slot + SLOTS_PER_LAYER], columns)
    return found


def _as_image(difference: NDArray[np.uint8], kind: Map) -> NDArray[np.uint8]:
    """A difference texture as an image: two channels get a third one that differs nowhere."""
    if not kind.is_normal:
        return difference

    def padded(rows: slice) -> NDArray[np.uint8]:
        return np.pad(difference[rows], ((0, 0), (0, 0), (0, 1)), constant_values=ZERO)

    return by_rows(padded, (*difference.shape[:2], 3), np.uint8)


def _write_geometry(model: CompressedTextures, name: str, folder: Path) -> GeometryEntry | None:
    meshes = model.meshes
    if meshes is None:
        return None
    try:
        content = head_bytes(name, meshes.topology, meshes.neutral, meshes.vertices, model.expressions)
    except (GlbFault, ValueError) as fault:
        raise FaceZipError(ErrorCode.BAD_VALUE, f"{folder}: its meshes cannot be stored: {fault}") from None
    (folder / HEAD_FILE).write_bytes(content)
    return GeometryEntry((HEAD_FILE,), len(meshes.neutral), len(meshes.topology.faces))


def _manifest(
    model: CompressedTextures,
    name: str,
    tiles: tuple[TileEntry, ...],
    geometry: GeometryEntry | None,
    made_with: dict[str, Any],
    files: dict[str, StoredFile],
) -> Manifest:
    first = model.weights[model.tiles[0]]
    uniform = first[:, 0, 0].tolist() if first.shape[1:3] == (1, 1) else []
    channels = {kind: model.parts[kind.name, model.tiles[0]].neutral.shape[2] for kind in model.maps}
    return Manifest(
        name=name,
        method=model.method,
        expressions=model.expressions,
        maps=tuple(MapEntry(kind.name, kind.encoding, (kind.low, kind.high), channels[kind]) for kind in model.maps),
        tiles=tiles,
        uniform_weights=tuple(map(tuple, uniform)),
        geometry=geometry,
        made_with=made_with,
        files=files,
    )
