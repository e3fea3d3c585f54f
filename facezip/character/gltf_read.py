"""A character from one glTF: expressions are morph targets, and each has a texture that is called as it is.

Variants (``KHR_materials_variants``) are what glTF has for "the same mesh with another texture": editors and viewers
show them, and tools that drop what nothing refers to keep them. Files of other makers are read too, where a material,
texture, image, or file beside the glTF has the morph target's name.
"""

from pathlib import Path

from facezip.character.filenames import MASK, is_at_rest
from facezip.character.gltf_images import Images
from facezip.character.gltf_maps import Maps
from facezip.character.gltf_material import PLACED, Material, Placement
from facezip.character.gltf_mesh import DRACO, read_mesh
from facezip.character.gltf_parts import Part, face_of, parts_of, titles
from facezip.character.gltf_textures import VARIANTS, Look, Looks
from facezip.character.maps import KNOWN
from facezip.character.meshes import Meshes
from facezip.character.notes import Note
from facezip.character.parts import listed
from facezip.character.scans import NEUTRAL, Character, at_least, check_names
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.accessors import GlbFault
from facezip.files.glb import COMPRESSED_VIEWS, Glb
from facezip.machine import memory
from facezip.names import folded

# Without effect on a face, read, or refused where the face uses them.
_UNDERSTOOD = {VARIANTS, PLACED, "KHR_mesh_quantization", "KHR_texture_basisu", "EXT_texture_webp", "MSFT_texture_dds"}
_UNDERSTOOD |= {"EXT_texture_avif", "KHR_lights_punctual", "KHR_animation_pointer", "KHR_xmp_json_ld"}
_SHADING = "KHR_materials_"
# A channel of 8 bits.
WHITE = 254.5 / 255


def load_gltf(path: Path, name: str, part: str | None, maps: tuple[str, ...] | None, fewest: int) -> Character:
    """Read a character from the face of a glTF, binary or with files beside it.

    The texture of a target is that of the material variant of its name, or else of a material, texture or image of its
    name, or else a file of that name beside the glTF. The neutral's is the face's own. A variant, image or file
    ``mask`` limits the face region. Roughness and normals are read where all of these materials have them.

    Parameters
    ----------
    path : the file.
    name : what the character is called.
    part : the name of the mesh, node or material that is the face; None to find it by its textures.
    maps : names of the maps that are wanted; None for all.
    fewest : expressions that there have to be.

    Raises
    ------
    FaceZipError
        One line that names the file: ``MISSING_FILE``, ``UNREADABLE_MESH`` (no glTF, damaged, compressed, no named
        targets, several faces), ``BAD_CHARACTER`` (a target without a texture), and what readers of textures refuse.
    """
    if not path.is_file():
        raise FaceZipError(ErrorCode.MISSING_FILE, f"{path}: no such file; give a .glb or a folder with neutral.obj")
    memory.check(0, _held(path))
    try:
        glb = Glb.read(path)
        _check_version(glb)
        held = _held(path, *_linked_buffers(glb))
        memory.check(0, held)
        return _Reading(path, glb, part, held).character(name, maps, fewest)
    except GlbFault as fault:
        raise FaceZipError(ErrorCode.UNREADABLE_MESH, f"{path}: {fault}") from None
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError, IndexError) as error:
        reason = f"not valid glTF ({type(error).__name__}: {(str(error).splitlines() or ['no reason'])[0][:200]})"
        raise FaceZipError(ErrorCode.UNREADABLE_MESH, f"{path}: {reason}; export it again") from None


class _Reading:
    """One call of :func:`load_gltf`."""

    def __init__(self, path: Path, glb: Glb, part: str | None, held: int) -> None:
        self._path, self._glb, self._held = path, glb, held
        self._images = Images(path, glb)
        parts = parts_of(glb)
        self._part = face_of(parts, part, self._rank)
        self._looks = Looks(path, glb, self._images, self._part)
        self._notes: list[Note] = []
        called = dict(zip(map(id, parts), titles(parts), strict=True))
        if others := [called[id(other)] for other in parts if other is not self._part]:
            self._note(f"the face is '{called[id(self._part)]}'; left out: {listed(others)}")

    def character(self, name: str, maps: tuple[str, ...] | None, fewest: int) -> Character:
        neutral = self._neutral_look()
        mask, stated = self._looks.of(MASK), {one: self._looks.of(one) for one in self._part.names}
        placement = Placement() if neutral.colours is None else neutral.colours.placement
        _check_placements({**stated, MASK: mask}, placement)
        meshes, done = read_mesh(self._glb, self._part, placement)
        for words in done:
            self._note(words)
        names, meshes = self._expressions(meshes, fewest)
        check_names(names, self._path)
        looks = {NEUTRAL: neutral, **{one: self._look(one) for one in names}}
        self._note_what_is_left_out([look.material for look in looks.values()])
        reading = Maps(self._path, self._images, looks, mask, meshes.topology, self._held)
        stacks = reading.read(maps)
        kinds = tuple(KNOWN[kind] for kind, _ in stacks)
        # One image may be of several targets.
        notes = tuple(dict.fromkeys([*self._notes, *reading.notes]))
        return Character(name, names, meshes, kinds, stacks, notes)

    def _rank(self, part: Part) -> int:
        """How closely textures of all expressions belong to a part: not at all, by names, with its own, as variants."""
        looks = Looks(self._path, self._glb, self._images, part)
        names = [name for name in part.names if not _is_neutral(name)]
        try:
            neutral = looks.of(NEUTRAL)
            if neutral is None or not all(map(looks.of, names)):
                return 0
        except GlbFault:
            # Of the face it is said when it is read.
            return 0
        return 1 + (neutral.colours is not None) + looks.are_variants(names)

    def _neutral_look(self) -> Look:
        called_so = [NEUTRAL, *(name for name in self._part.names if _is_neutral(name))]
        look = next(filter(None, map(self._looks.of, called_so)), None)
        if look is None:
            reason = "its face has no base colour texture; give it one"
            raise FaceZipError(ErrorCode.BAD_CHARACTER, f"{self._path}: {reason}")
        return look

    def _look(self, name: str) -> Look:
        look = self._looks.of(name)
        if look is None:
            raise FaceZipError(
                ErrorCode.BAD_CHARACTER,
                f"{self._path}: morph target '{name}' has no texture; add a material variant or an image of its name, "
                "or remove the target",
            )
        return look

    def _expressions(self, meshes: Meshes, fewest: int) -> tuple[tuple[str, ...], Meshes]:
        """Targets without those that are the neutral: called so, and moving nothing."""
        kept = []
        for number, name in enumerate(self._part.names):
            if _is_neutral(name) and not meshes.deltas[number].any():
                self._note(f"'{name}' moves nothing and is taken for the neutral")
            else:
                kept.append(number)
        if len(kept) < fewest:
            raise GlbFault(f"{len(kept)} morph target(s) that move it; {at_least(fewest)}")
        names = tuple(self._part.names[number] for number in kept)
        return names, Meshes(meshes.topology, meshes.neutral, meshes.vertices[kept])

    def _note_what_is_left_out(self, materials: list[Material | None]) -> None:
        left_out = dict.fromkeys(words for material in materials if material for words in material.left_out)
        if left_out:
            self._note(f"left out of its materials: {', '.join(left_out)}")
        for primitive in self._part.primitives:
            colours = primitive["attributes"].get("COLOR_0")
            if colours is not None and (self._glb.array(colours)[:, :3] < WHITE).any():
                self._note("its vertex colours (COLOR_0), which viewers multiply by the texture, are left out", True)
                break
        if any(self._glb.item("meshes", self._part.mesh).get("weights", [])):
            self._note("its targets have weights that are not 0; the neutral is without them", True)

    def _note(self, words: str, asks: bool = False) -> None:
        self._notes.append(Note(self._path.name, words, asks))


def _is_neutral(name: str) -> bool:
    """Whether a target that moves nothing is called as the neutral itself is."""
    return is_at_rest(name) or folded(name) == "none"


def _check_placements(looks: dict[str, Look | None], placement: Placement) -> None:
    for name, look in looks.items():
        if look is not None and look.colours is not None and not look.colours.placement.is_as(placement):
            raise GlbFault(
                f"the texture of '{name}' lies otherwise on the face than the neutral's ({PLACED} or texCoord); "
                "bake all of them alike"
            )


def _check_version(glb: Glb) -> None:
    version = str(glb.document.get("asset", {}).get("version", "2"))
    if not version.startswith("2"):
        raise GlbFault(f"it is glTF {version[:16]}; 2.0 is read, export it as that")
    for name in map(str, glb.document.get("extensionsRequired", [])):
        if name not in _UNDERSTOOD and not name.startswith(_SHADING):
            compressed = name in (DRACO, *COMPRESSED_VIEWS)
            remedy = "export it uncompressed" if compressed else "export it without"
            raise GlbFault(f"it needs {name[:64]!r}, which is not read here; {remedy}")


def _linked_buffers(glb: Glb) -> set[Path]:
    buffers = (glb.item("buffers", index) for index in range(len(glb.document.get("buffers", []))))
    files = (glb.links.file(str(buffer["uri"])) for buffer in buffers if "uri" in buffer)
    return {file for file in files if file is not None}


def _held(*files: Path) -> int:
    """Bytes that reading takes besides textures: of the file, its chunks or buffers, and an image of it."""
    return 3 * sum(file.stat().st_size for file in files)
