"""A pack with more expressions: what is there of it stays as it is, so that what has been shipped serves on.

Neutrals, difference textures and masks are the old files. Weight maps are laid out anew, since an atlas holds those of
all expressions, but the bytes of the old ones, and the ranges that give them meaning, stay.
"""

import shutil
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from facezip.character.scans import check_names
from facezip.files.images import Texels, write_texture
from facezip.files.packs import MANIFEST, is_pack
from facezip.files.reading import reading
from facezip.files.writing import whole_folder
from facezip.pack.manifest import Manifest, TileEntry
from facezip.pack.masked import MaskedWeights
from facezip.pack.parsing import damaged_pack
from facezip.pack.quantise import StoredTextures
from facezip.pack.verification import stored
from facezip.pack.write import checked_content, weights_entry, write_activations, write_geometry


def write_extended(
    pack: Path,
    before: Manifest,
    extended: StoredTextures,
    path: Path,
    *,
    made_with: Mapping[str, Any],
    overwrite: bool = False,
) -> None:
    """Write a pack again, with the weights and the meshes of more expressions.

    Parameters
    ----------
    pack, before : the pack that is there, and its manifest, verified.
    extended : the same textures under weights of more expressions, those of the pack first.
    path, overwrite : as of :func:`facezip.write_pack`; ``path`` may be ``pack``.
    made_with : what is added to what the pack says of its making.

    Raises
    ------
    FaceZipError
        What :func:`facezip.write_pack` raises; ``BAD_VALUE`` for a name that is there twice, in capitals or not;
        ``DAMAGED_PACK``: a file changed in the meantime.
    """
    check_names(extended.expressions, path)
    with whole_folder(path, overwrite, is_pack) as folder:
        images: dict[str, Texels] = {}
        tiles = tuple(_tile(entry, extended, images) for entry in before.tiles)
        for file, image in images.items():
            write_texture(folder / file, image)
        geometry = write_geometry(extended.meshes, extended.expressions, before.name or "head", folder)
        weights = extended.weights
        masks = write_activations(weights, folder) if isinstance(weights, MaskedWeights) else None
        _copy_textures(pack, before, folder)
        manifest = replace(
            before,
            expressions=extended.expressions,
            tiles=tiles,
            uniform_weights=_uniform(extended, tiles[0]),
            geometry=geometry,
            masks=masks and replace(masks, files=before.masks.files if before.masks else ()),
            made_with={**before.made_with, **made_with},
            files={file.name: stored(file) for file in sorted(folder.iterdir())},
        )
        (folder / MANIFEST).write_bytes(checked_content(path, manifest))


def _tile(entry: TileEntry, extended: StoredTextures, images: dict[str, Texels]) -> TileEntry:
    if isinstance(extended.weights, MaskedWeights):
        return entry
    weights = weights_entry(extended.weights[entry.number], entry.number, images)
    return replace(weights, textures=entry.textures)


def _uniform(extended: StoredTextures, first: TileEntry) -> tuple[tuple[float, ...], ...]:
    if isinstance(extended.weights, MaskedWeights) or first.weight_size != (1, 1):
        return ()
    return tuple(map(tuple, extended.weights[first.number].texels[:, 0, 0].tolist()))


def _copy_textures(pack: Path, before: Manifest, folder: Path) -> None:
    """Those of all maps, and masks, as they lie there."""
    textures = [texture for _, texture in before.entries().values()]
    names = [name for texture in textures for name in (texture.neutral, *texture.differences)]
    for name in (*names, *(before.masks.files if before.masks else ())):
        with reading(pack / name):
            shutil.copyfile(pack / name, folder / name)
        if stored(folder / name) != before.files[name]:
            raise damaged_pack(pack, f"'{name}' was changed while it was read")
