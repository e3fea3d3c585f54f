"""A character as one GLB: expressions are morph targets, their textures material variants of the same names.

Variants (``KHR_materials_variants``) are what glTF has for "the same mesh with another texture": editors and viewers
show them, and tools that drop what nothing refers to keep them. Files of other makers are read too, where a material,
texture, image, or file beside the GLB has the morph target's name.
"""

import os
import tempfile
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

from facezip.character.custom import texture_path
from facezip.character.filenames import MASK
from facezip.character.folder import checked_mask, words_for
from facezip.character.gltf import CLAMPED, add_mesh, skin, start
from facezip.character.gltf_mesh import ScannedMesh, read_mesh
from facezip.character.maps import ALBEDO, KNOWN
from facezip.character.meshes import Meshes
from facezip.character.scans import NEUTRAL, Character, Stack, check_names
from facezip.character.sizes import SPARE
from facezip.character.tiles import FIRST_TILE
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.glb import Glb, GlbFault
from facezip.files.images import Texels, png, read_texture, to_float
from facezip.files.reading import check_expansion
from facezip.files.writing import write_whole
from facezip.machine import memory
from facezip.machine.progress import track
from facezip.names import printable

VARIANTS = "KHR_materials_variants"
SUFFIXES = {"image/png": ".png", "image/jpeg": ".jpg"}
UNDERSTOOD = {VARIANTS, "KHR_mesh_quantization", "KHR_materials_unlit", "KHR_materials_specular", "KHR_materials_ior"}


def load_glb(path: Path) -> Character:
    """Read a character from the one mesh with morph targets of a GLB.

    The texture of a target is that of the material variant of its name, or else of a material, texture or image of its
    name, or else a file of that name beside the GLB. The neutral's is the mesh's own. A variant, image or file
    ``mask`` limits the face region.

    Raises
    ------
    FaceZipError
        One line that names the file: ``MISSING_FILE``, ``UNREADABLE_MESH`` (no GLB, damaged, compressed, no named
        targets), ``BAD_CHARACTER`` (a target without a texture), and what the readers of textures refuse.
    """
    if not path.is_file():
        raise FaceZipError(ErrorCode.MISSING_FILE, f"{path}: no such file; give a .glb or a folder with neutral.obj")
    memory.check(0, _held(path))
    try:
        glb = Glb.read(path)
        _check_extensions(glb)
        mesh = read_mesh(glb)
        # Textures may be looked for under these names beside the file.
        check_names(mesh.names, path)
        return _character(path, mesh, _Textures(path, glb, mesh))
    except GlbFault as fault:
        raise FaceZipError(ErrorCode.UNREADABLE_MESH, f"{path}: {fault}") from None
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError, IndexError) as error:
        reason = f"not valid glTF ({type(error).__name__}: {(str(error).splitlines() or ['no reason'])[0][:200]})"
        raise FaceZipError(ErrorCode.UNREADABLE_MESH, f"{path}: {reason}; export it again") from None


def save_glb(character: Character, path: Path) -> None:
    """Write a character as one GLB that :func:`load_glb` reads back; textures as PNG, of 16 bits where not of 8.

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


class _Textures:
    """Finds and decodes the images of a GLB."""

    def __init__(self, path: Path, glb: Glb, mesh: ScannedMesh) -> None:
        self._path, self._glb = path, glb
        self._variants = _variant_materials(glb, mesh.primitive)
        self._material = mesh.primitive.get("material")

    def find(self, name: str, into: Texels | None = None) -> Texels | None:
        """The texture of a name, or None; ``into`` is as in :func:`facezip.files.images.read_texture`."""
        image = self._image(name)
        if image is not None:
            return self._decoded(image, into)
        file = self._beside(name)
        return read_texture(file, into) if file.is_file() else None

    def stored_bytes(self, names: Iterable[str]) -> int:
        """Bytes of the file and of all files of these names beside it."""
        files = [self._path, *filter(Path.is_file, map(self._beside, names))]
        return sum(file.stat().st_size for file in files)

    def _beside(self, name: str) -> Path:
        return texture_path(self._path.parent, name)

    def _image(self, name: str) -> int | None:
        if name in self._variants:
            return self._of_material(self._variants[name])
        if name == NEUTRAL and self._material is not None:
            return self._of_material(self._material)
        ways: dict[str, Callable[[int], int | None]]
        ways = {"materials": self._of_material, "textures": self._of_texture, "images": int}
        for kind, image_of in ways.items():
            for index, entry in enumerate(self._glb.document.get(kind, [])):
                if Path(str(entry.get("name", ""))).stem == name:
                    return image_of(index)
        return None

    def _of_material(self, index: Any) -> int | None:
        shading = self._glb.item("materials", index).get("pbrMetallicRoughness", {})
        texture = shading.get("baseColorTexture")
        return None if texture is None else self._of_texture(texture["index"])

    def _of_texture(self, index: Any) -> int:
        texture = self._glb.item("textures", index)
        if "source" not in texture:
            raise GlbFault("a texture is neither PNG nor JPEG; export it with PNG textures")
        return int(texture["source"])

    def _decoded(self, index: int, into: Texels | None) -> Texels:
        image = self._glb.item("images", index)
        suffix = SUFFIXES.get(str(image.get("mimeType")))
        if suffix is None or "bufferView" not in image:
            raise GlbFault(f"image {index} is no PNG or JPEG within the file; export one .glb with PNG textures")
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / f"image{suffix}"
            file.write_bytes(self._glb.view(image["bufferView"]))
            try:
                # glTF states what its images' numbers are (2.0, section 3.8.3): they do not.
                return read_texture(file, into, ignores_space=True)
            except FaceZipError as error:
                raise FaceZipError(error.code, f"{self._path}: image {index}{str(error)[len(str(file)) :]}") from None


def _character(path: Path, mesh: ScannedMesh, images: _Textures) -> Character:
    neutral = images.find(NEUTRAL)
    if neutral is None:
        raise FaceZipError(ErrorCode.BAD_CHARACTER, f"{path}: its mesh has no base colour texture; give it one")
    unfolded = (len(mesh.names) + 1) * neutral.nbytes
    check_expansion(path, unfolded, images.stored_bytes(mesh.names), SPARE)
    memory.check(unfolded // len(neutral), _held(path))
    textures: Texels = memory.empty((len(mesh.names), *neutral.shape), neutral.dtype)
    for n, name in enumerate(track(mesh.names, "Reading the character", len(mesh.names))):
        texture = images.find(name, textures[n])
        if texture is None:
            raise FaceZipError(
                ErrorCode.BAD_CHARACTER,
                f"{path}: morph target '{name}' has no texture; add a material variant or an image of its name, or "
                "remove the target",
            )
        if texture.shape != neutral.shape or texture.dtype != neutral.dtype:
            raise FaceZipError(
                ErrorCode.SIZE_MISMATCH,
                f"{path}: the texture of '{name}' is {words_for(texture)}, the neutral is {words_for(neutral)}; "
                "export both alike",
            )
    mask = images.find(MASK)
    region = None if mask is None else checked_mask(to_float(mask[:, :, 0]), neutral.shape[:2], path)
    stacks = {(ALBEDO, FIRST_TILE): Stack(neutral, textures, region)}
    meshes = Meshes(mesh.topology, mesh.neutral, mesh.vertices)
    return Character(printable(path.stem), mesh.names, meshes, (KNOWN[ALBEDO],), stacks)


def _held(path: Path) -> int:
    """Bytes that reading takes besides textures: of the file, its chunks, and an image of it."""
    return 3 * path.stat().st_size


def _check_extensions(glb: Glb) -> None:
    needed = glb.document.get("extensionsRequired", [])
    unknown = [name for name in needed if name not in UNDERSTOOD]
    if unknown:
        raise GlbFault(f"it needs {str(unknown[0])[:64]!r}, which is not read here; export it uncompressed, with PNGs")


def _variant_materials(glb: Glb, primitive: Mapping[str, Any]) -> dict[str, Any]:
    """The material of every variant, by its name."""
    variants = glb.document.get("extensions", {}).get(VARIANTS, {}).get("variants", [])
    mappings = primitive.get("extensions", {}).get(VARIANTS, {}).get("mappings", [])
    return {
        str(variants[index]["name"]): mapping["material"]
        for mapping in mappings
        for index in mapping["variants"]
        if type(index) is int and 0 <= index < len(variants)
    }
