"""What a CHARACTER is: a folder of scans, a glTF, or a folder with one glTF in it."""

from pathlib import Path

from facezip.character.filenames import visible_files
from facezip.character.layout import holds_neutral
from facezip.character.mesh_names import MESH_SUFFIX
from facezip.character.parts import listed
from facezip.character.settings import SETTINGS
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.packs import MANIFEST

GLTF_SUFFIXES = (".glb", ".gltf", ".vrm")
_STARTS = b"glTF"
# What packs and exports have, whose heads are glTF too.
_OURS = (MANIFEST, "facezip.json")


def is_gltf_name(path: Path) -> bool:
    """Whether a path ends as those of glTF files do."""
    return path.suffix.lower() in GLTF_SUFFIXES


def is_character(path: Path) -> bool:
    """Whether there is a character at a path, whatever is wrong with it."""
    if not path.is_dir():
        return is_gltf_name(path)
    return holds_scans(path) or bool(_gltfs_in(path)) or (not is_ours(path) and holds_neutral(path, below=True))


def holds_scans(folder: Path) -> bool:
    """Whether a folder has a neutral mesh, or says what its files are and has no glTF."""
    return holds_neutral(folder) or ((folder / SETTINGS).is_file() and not _gltfs_in(folder))


def gltf_at(path: Path) -> Path | None:
    """The glTF that a character is read from; None for a folder of scans, and where nothing is there.

    Raises
    ------
    FaceZipError
        ``BAD_CHARACTER``: a file of another kind, or a folder with several glTFs.
    """
    if is_gltf_name(path) and not path.is_dir():
        return path
    if path.is_file():
        with open(path, "rb") as file:
            if file.read(len(_STARTS)) == _STARTS:
                return path
        kind = path.suffix.lower() or "a file without a suffix"
        reason = f"{kind} is no character; give a folder with neutral.obj, a .glb or a .gltf"
        raise FaceZipError(ErrorCode.BAD_CHARACTER, f"{path}: {reason}")
    inside = [] if holds_scans(path) else _gltfs_in(path)
    if len(inside) > 1:
        among = listed(file.name for file in inside)
        raise FaceZipError(ErrorCode.BAD_CHARACTER, f"{path}: holds {among}; give one of them")
    return inside[0] if inside else None


def is_ours(folder: Path) -> bool:
    """Whether a folder is a pack or an export."""
    return any((folder / name).exists() for name in _OURS)


def _gltfs_in(folder: Path) -> list[Path]:
    """The glTFs of a folder that is no pack or export, in the order of their names."""
    if not folder.is_dir() or is_ours(folder):
        return []
    files = visible_files(folder)
    has_meshes = any(file.suffix.lower() == MESH_SUFFIX for file in files)
    return [] if has_meshes else [file for file in files if is_gltf_name(file)]
