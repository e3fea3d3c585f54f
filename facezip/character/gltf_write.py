"""A character as one GLB: expressions are morph targets, their textures material variants of the same names."""

import os
from pathlib import Path

from facezip.character.filenames import MASK
from facezip.character.gltf import CLAMPED, add_mesh, skin, start
from facezip.character.gltf_textures import VARIANTS
from facezip.character.maps import ALBEDO, KNOWN
from facezip.character.scans import NEUTRAL, Character
from facezip.character.tiles import FIRST_TILE
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.images import png
from facezip.files.writing import write_whole
from facezip.machine.progress import track


def save_glb(character: Character, path: Path) -> None:
    """Write a character as one GLB that :func:`facezip.load_character` reads back; PNGs of 16 bits where not of 8.

    Raises
    ------
    FaceZipError
        ``CANNOT_WRITE``: the file exists already, or the disk refuses; ``BAD_VALUE``: there is more than one albedo.
    """
    if character.maps != (KNOWN[ALBEDO],) or character.tiles != (FIRST_TILE,):
        reason = f"a GLB holds one albedo on one tile, and {character.name} has more; save it as a folder"
        raise FaceZipError(ErrorCode.BAD_VALUE, f"{path}: {reason}")
    if os.path.lexists(path):
        raise FaceZipError(ErrorCode.CANNOT_WRITE, f"{path}: exists already; choose another name")
    glb = start(character.name)
    meshes, albedo = character.meshes, character.first
    (primitive,) = add_mesh(glb, character.name, meshes, character.expressions, [meshes.topology])
    images = {NEUTRAL: albedo.neutral, **dict(zip(character.expressions, albedo.textures, strict=True))}
    if albedo.mask is not None:
        images[MASK] = albedo.mask[:, :, None]
    for name in track(images, "Writing the character", len(images)):
        glb.image(name, png(images[name]), "image/png")
    names = [name for name in images if name != NEUTRAL]
    glb.document |= {
        "samplers": CLAMPED,
        "textures": [{"name": name, "sampler": 0, "source": index} for index, name in enumerate(images)],
        "materials": [skin(name, index) for index, name in enumerate(images)],
        "extensionsUsed": [VARIANTS],
        "extensions": {VARIANTS: {"variants": [{"name": name} for name in names]}},
    }
    mappings = [{"material": index + 1, "variants": [index]} for index in range(len(names))]
    primitive["extensions"] = {VARIANTS: {"mappings": mappings}}
    write_whole(path, glb.finish().to_bytes())
