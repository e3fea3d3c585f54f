"""A character: one neutral and N expressions, meshes sharing one topology, textures sharing one UV layout."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.errors import ErrorCode, FaceZipError
from facezip.files.decoding import stated_size
from facezip.files.images import Texels, read_texture, to_float, write_texture
from facezip.files.names import MAX_CHARACTERS, first_unusable, printable
from facezip.files.obj import Topology, read_obj, write_obj
from facezip.files.opening import TEXTURE_SUFFIXES
from facezip.files.reading import check_expansion, reading
from facezip.files.writing import whole_folder
from facezip.machine import memory
from facezip.machine.cores import cores
from facezip.machine.progress import track
from facezip.machine.rows import by_rows
from facezip.pack.manifest import FILE_NAME as PACKED

NEUTRAL = "neutral"
MASK = "mask"
# Fifty flat 2048 x 2048 textures are no attack; what unfolds to more has to be in proportion to its files.
SPARE = 2**32


@dataclass(frozen=True, eq=False)
class Character:
    """The scans of one person.

    Attributes
    ----------
    name : what reports call the character.
    topology : faces and UV layout of every mesh.
    expressions : the N names, without the neutral.
    neutral_vertices : ``(V, 3)`` float32.
    vertices : ``(N, V, 3)`` float32, absolute positions.
    neutral : ``(H, W, C)`` encoded values as stored: uint8, uint16, or float32 in [0, 1].
    textures : ``(N, H, W, C)`` of the same type.
    mask : ``(H, W)`` float32 in [0, 1], the face region and weight of errors; None for the whole texture.
    """

    name: str
    topology: Topology
    expressions: tuple[str, ...]
    neutral_vertices: NDArray[np.float32]
    vertices: NDArray[np.float32]
    neutral: Texels
    textures: Texels
    mask: NDArray[np.float32] | None = None

    @property
    def resolution(self) -> tuple[int, int]:
        """Rows and columns of every texture."""
        return self.neutral.shape[0], self.neutral.shape[1]

    @property
    def weight(self) -> NDArray[np.float32]:
        """``(H, W)`` float32: the mask, or 1 everywhere."""
        one = np.ones(1, np.float32)
        return by_rows(lambda _: one, self.resolution, np.float32) if self.mask is None else self.mask

    @property
    def facts(self) -> dict[str, Any]:
        """Name, expressions and sizes, as documents state them."""
        return {
            "name": self.name,
            "expressions": list(self.expressions),
            "resolution": list(self.resolution),
            "channels": self.neutral.shape[2],
            "vertices": len(self.neutral_vertices),
            "triangles": len(self.topology.faces),
        }

    def texture(self, expression: str) -> NDArray[np.float32]:
        """``(H, W, C)`` float32 in [0, 1] of an expression or of ``"neutral"``."""
        return to_float(self.neutral if expression == NEUTRAL else self.textures[self.index(expression)])

    def mesh_vertices(self, expression: str) -> NDArray[np.float32]:
        """``(V, 3)`` float32 of an expression or of ``"neutral"``."""
        return self.neutral_vertices if expression == NEUTRAL else self.vertices[self.index(expression)]

    def index(self, expression: str) -> int:
        """Position of an expression on axis 0; ``UNKNOWN_NAME`` where there is none."""
        if expression not in self.expressions:
            known = ", ".join(self.expressions)
            raise FaceZipError(ErrorCode.UNKNOWN_NAME, f"no expression '{expression}'; this character has {known}")
        return self.expressions.index(expression)


def check_names(expressions: tuple[str, ...], whose: str | Path) -> None:
    """Raise ``UNSAFE_NAME`` for the first expression whose name cannot be a file name, before any file bears it."""
    unusable = first_unusable(expressions)
    if unusable is not None:
        raise FaceZipError(
            ErrorCode.UNSAFE_NAME,
            f"{whose}: expression name '{unusable[:MAX_CHARACTERS]}' cannot be a file name; rename it",
        )


def load_character(path: str | Path) -> Character:
    """Read a character folder: ``neutral.obj`` with its texture, and the same pair per expression; or one ``.glb``.

    Expressions come in the order of their names. Textures are PNG, TIFF, JPEG or OpenEXR, found by the mesh's name;
    ``mask.png`` (any of these formats), where present, limits the face region. Of a character with more maps than that
    albedo (:func:`facezip.load_surface`), they are left out.

    Raises
    ------
    FaceZipError
        One line that names the file: missing partners, fewer than two expressions, textures of another size or type,
        meshes of another topology or UV layout, and everything that the readers of meshes and textures refuse.
    """
    path = Path(path)
    with reading(path):
        if path.suffix.lower() != ".glb":
            from facezip.character.layout import is_layered

            return _albedo_alone(path) if is_layered(path) else _load_folder(path)
        from facezip.character.gltf_file import load_glb

        return load_glb(path)


def _albedo_alone(folder: Path) -> Character:
    from facezip.character.folder import load_surface

    surface = load_surface(folder, maps=("albedo",))
    if len(surface.tiles) > 1:
        raise FaceZipError(
            ErrorCode.BAD_CHARACTER,
            f"{folder}: {len(surface.tiles)} UDIM tiles; compress, decompress, info, verify and validate take them, "
            "this takes one: give it a folder of one tile",
        )
    return surface.whole


def _load_folder(folder: Path) -> Character:
    names = _expression_names(folder)
    check_names(names, folder)
    _check_sizes(folder, names)
    neutral_vertices, topology = read_obj(folder / f"{NEUTRAL}.obj")
    neutral = read_texture(texture_path(folder, NEUTRAL))
    vertices = np.empty((len(names), *neutral_vertices.shape), np.float32)
    textures: Texels = memory.empty((len(names), *neutral.shape), neutral.dtype)

    def read(n: int) -> None:
        vertices[n] = vertices_like(folder / f"{names[n]}.obj", neutral_vertices, topology)
        _read_like(folder, names[n], neutral, textures[n])

    with ThreadPoolExecutor(cores()) as pool:
        for _ in track(pool.map(read, range(len(names))), "Reading the character", len(names)):
            pass
    return Character(
        printable(folder.resolve().name),
        topology,
        names,
        neutral_vertices,
        vertices,
        neutral,
        textures,
        _mask(folder, neutral),
    )


def save_character(character: Character, folder: str | Path) -> None:
    """Write ``NAME.obj`` and ``NAME.png`` (``.exr`` for float textures) for the neutral and every expression.

    Where ``folder`` ends in ``.glb``, one such file is written instead.

    Raises
    ------
    FaceZipError
        ``UNSAFE_NAME``, or ``CANNOT_WRITE``: the folder holds something already, or the disk refuses; nothing is then
        written.
    """
    folder = Path(folder)
    check_names(character.expressions, character.name)
    if folder.suffix.lower() == ".glb":
        from facezip.character.gltf_file import save_glb

        save_glb(character, folder)
        return
    suffix = ".exr" if character.neutral.dtype.kind == "f" else ".png"
    names = (NEUTRAL, *character.expressions)
    with whole_folder(folder, False, lambda _: False) as whole:
        for name in track(names, "Writing the character", len(names)):
            write_obj(whole / f"{name}.obj", character.mesh_vertices(name), character.topology)
            stored = character.neutral if name == NEUTRAL else character.textures[character.index(name)]
            write_texture(whole / f"{name}{suffix}", stored)
        if character.mask is not None:
            write_texture(whole / f"{MASK}.png", character.mask[:, :, None])


def _expression_names(folder: Path) -> tuple[str, ...]:
    if not folder.is_dir():
        raise FaceZipError(ErrorCode.MISSING_FILE, f"{folder}: no such folder; give the folder with neutral.obj in it")
    if (folder / PACKED).is_file():
        raise FaceZipError(
            ErrorCode.BAD_CHARACTER, f"{folder}: is a pack; give the folder of scans that it was made of"
        )
    meshes = sorted(path.stem for path in folder.glob("*.obj"))
    if NEUTRAL not in meshes:
        raise FaceZipError(ErrorCode.MISSING_FILE, f"{folder}: no neutral.obj; a character needs a neutral mesh")
    names = tuple(name for name in meshes if name != NEUTRAL)
    for path in sorted(folder.iterdir()):
        known = path.stem in meshes or path.stem.startswith(MASK)
        if path.suffix.lower() in TEXTURE_SUFFIXES and not known:
            from facezip.character.layout import without_mesh

            raise without_mesh(path, meshes)
    if len(names) < 2:
        raise FaceZipError(
            ErrorCode.TOO_FEW_EXPRESSIONS,
            f"{folder}: {len(names)} expression(s); at least two besides the neutral",
        )
    return names


def _check_sizes(folder: Path, names: tuple[str, ...]) -> None:
    """Refuse, by their headers and before any is decoded, textures that differ or unfold out of proportion."""
    paths = [texture_path(folder, name) for name in (NEUTRAL, *names)]
    sizes = [stated_size(path) for path in paths]
    for path, (height, width, _) in zip(paths, sizes, strict=True):
        if (height, width) != sizes[0][:2]:
            raise FaceZipError(
                ErrorCode.SIZE_MISMATCH,
                f"{path}: {width}x{height}, the neutral is {sizes[0][1]}x{sizes[0][0]}; export both alike",
            )
    decoded = sum(size[2] for size in sizes)
    check_expansion(folder, decoded, sum(path.stat().st_size for path in paths), SPARE)
    memory.check(decoded // sizes[0][0])


def texture_path(folder: Path, name: str) -> Path:
    """The texture of a name in a folder, whatever its suffix; where there is none, what it would be called."""
    found = [folder / f"{name}{suffix}" for suffix in TEXTURE_SUFFIXES if (folder / f"{name}{suffix}").exists()]
    if len(found) > 1:
        raise FaceZipError(
            ErrorCode.BAD_CHARACTER, f"{found[1]}: a second texture beside {found[0].name}; keep one of them"
        )
    return found[0] if found else folder / f"{name}.png"


def vertices_like(path: Path, neutral: NDArray[np.float32], topology: Topology) -> NDArray[np.float32]:
    """The vertices ``(V, 3)`` of a mesh, if it has the neutral's topology and UV layout."""
    vertices, other = read_obj(path)
    if len(vertices) != len(neutral) or not np.array_equal(other.faces, topology.faces):
        difference = f"{len(vertices)} vertices and {len(other.faces)} triangles"
        raise FaceZipError(
            ErrorCode.TOPOLOGY_MISMATCH,
            f"{path}: {difference}, not the neutral's mesh ({len(neutral)} and {len(topology.faces)}, in its order); "
            "fit the neutral's topology to the scan",
        )
    if not other.same_as(topology):
        raise FaceZipError(
            ErrorCode.TOPOLOGY_MISMATCH,
            f"{path}: another UV layout than neutral.obj; transfer the neutral's UVs",
        )
    return vertices


def _read_like(folder: Path, name: str, neutral: Texels, into: Texels) -> None:
    path = texture_path(folder, name)
    texture = read_texture(path, into)
    if texture is not into:
        raise FaceZipError(
            ErrorCode.SIZE_MISMATCH,
            f"{path}: {kind_of(texture)}, the neutral is {kind_of(neutral)}; export both alike",
        )


def kind_of(texture: Texels) -> str:
    """Size, channels and type of a texture, in words."""
    height, width, channels = texture.shape
    return f"{width}x{height} with {channels} channel(s) of {texture.dtype}"


def _mask(folder: Path, neutral: Texels) -> NDArray[np.float32] | None:
    path = texture_path(folder, MASK)
    return mask_of(read_texture(path), neutral, path) if path.exists() else None


def mask_of(texels: Texels, neutral: Texels, path: Path) -> NDArray[np.float32]:
    """The face region ``(H, W)`` that an image at ``path`` says: of the neutral's size, and not black everywhere."""
    mask = to_float(texels[:, :, 0])
    if mask.shape != neutral.shape[:2]:
        raise FaceZipError(
            ErrorCode.SIZE_MISMATCH,
            f"{path}: {mask.shape[1]}x{mask.shape[0]}, the textures differ; resize the mask",
        )
    if texels[:, :, 0].max() == 0:
        raise FaceZipError(ErrorCode.BAD_TEXELS, f"{path}: the mask is black everywhere; paint the face region white")
    return mask
