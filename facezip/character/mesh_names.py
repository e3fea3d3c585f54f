"""Which meshes a folder has, what they are called, and which is the neutral."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from facezip.character.filenames import at_rest, files_near, visible_files, within
from facezip.character.notes import Note
from facezip.character.parts import listed
from facezip.character.scans import NEUTRAL
from facezip.errors import ErrorCode, FaceZipError
from facezip.names import folded, one_form

MESH_SUFFIX = ".obj"
# Meshes all the same, whose files would be missed beside the others.
OTHER_MESHES = (
    *(".fbx", ".ply", ".stl", ".abc", ".usd", ".usda", ".usdc", ".usdz", ".dae", ".ztl", ".zpr", ".blend"),
    *(".ma", ".mb", ".max", ".c4d", ".hip", ".lwo", ".3ds", ".x3d", ".off", ".glb", ".gltf"),
)


@dataclass(frozen=True)
class NamedMeshes:
    """The meshes of a folder.

    Attributes
    ----------
    files : by name in one Unicode form, the neutral's being ``neutral``.
    owners : these names by what they are compared as, and by what the neutral's mesh is called.
    notes : what is certain but not called as it should be.
    """

    files: dict[str, Path]
    owners: dict[str, str]
    notes: tuple[Note, ...] = ()

    @property
    def called(self) -> dict[str, str]:
        """:attr:`owners` without ``neutral`` where the neutral's mesh is called otherwise."""
        others = [name for name, owner in self.owners.items() if owner == NEUTRAL and name != NEUTRAL]
        return {name: owner for name, owner in self.owners.items() if name != NEUTRAL or not others}


def meshes_in(folder: Path, neutral: str | None = None, below: bool = False) -> NamedMeshes:
    """The meshes of a folder.

    Parameters
    ----------
    folder : which.
    neutral : what the neutral's mesh is called, where that is said.
    below : whether meshes in folders within it count where it has none itself: all in one, or each in its own.

    Raises
    ------
    FaceZipError
        ``BAD_CHARACTER``: two of one name, several that may be the neutral, or none of the stated name.
    """
    named = named_in(folder, below)
    owners, notes = owners_of(named, neutral_among(named, neutral), folder, stated=neutral is not None)
    for path in named.values():
        if path.parent != folder:
            notes.append(Note(within(folder, path), "taken for a mesh of the character, in a folder within it"))
    return NamedMeshes({owners[folded(name)]: path for name, path in named.items()}, owners, tuple(notes))


def named_in(folder: Path, below: bool = False) -> dict[str, Path]:
    """The meshes of a folder by their own names; parameters and errors as of :func:`meshes_in`."""
    there = [path for path in visible_files(folder) if path.suffix.lower() == MESH_SUFFIX]
    if there or not below:
        return mesh_files((path.stem, path) for path in there)
    return _nested([path for path in files_near(folder) if path.suffix.lower() == MESH_SUFFIX])


def _nested(paths: list[Path]) -> dict[str, Path]:
    """Meshes in folders by name: by their own, or by their folders' where each has one; nothing where it is unclear."""
    parents = {path.parent for path in paths}
    if len(parents) <= 1:
        return mesh_files((path.stem, path) for path in paths)
    if len(parents) < len(paths) or len({parent.parent for parent in parents}) > 1:
        return {}
    by_stem = len({folded(path.stem) for path in paths}) == len(paths)
    return mesh_files((path.stem if by_stem else path.parent.name, path) for path in paths)


def mesh_files(named: Iterable[tuple[str, Path]]) -> dict[str, Path]:
    """Meshes by their names in one Unicode form; ``BAD_CHARACTER`` where a file system may take two for one."""
    meshes: dict[str, Path] = {}
    seen: dict[str, tuple[str, Path]] = {}
    for name, path in named:
        called, beside = seen.setdefault(folded(name), (name, path))
        if beside != path:
            alike = "in its Unicode form" if one_form(name) == one_form(called) else "in case"
            raise FaceZipError(
                ErrorCode.BAD_CHARACTER,
                f"{path}: a second mesh beside {beside.name}, whose name differs {alike} alone; rename or remove one",
            )
        meshes[one_form(name)] = path
    return meshes


def neutral_among(meshes: dict[str, Path], stated: str | None = None) -> str | None:
    """The name that the neutral's mesh has: as stated, ``neutral`` in any case, or what is certain; None for none.

    Raises
    ------
    FaceZipError
        ``BAD_CHARACTER``: several may be it, or none is called as stated.
    """
    if stated is not None and meshes:
        return _stated(meshes, stated)
    rest = [name for name in meshes if folded(name) == NEUTRAL] or at_rest(meshes)
    if len(rest) > 1:
        raise FaceZipError(
            ErrorCode.BAD_CHARACTER,
            f"{meshes[rest[0]]}: may be the neutral, and so may {meshes[rest[1]].name}; call the one {NEUTRAL}.obj, or "
            f'say neutral = "{rest[0]}" in character.toml',
        )
    return rest[0] if rest else None


def _stated(meshes: dict[str, Path], stated: str) -> str:
    found = [name for name in meshes if folded(name) == folded(stated.removesuffix(MESH_SUFFIX))]
    other = [path for name, path in meshes.items() if folded(name) == NEUTRAL and name not in found]
    if not found:
        reason = f"is neutral in character.toml, and there is no mesh of that name; there are {listed(meshes)}"
        raise FaceZipError(ErrorCode.BAD_CHARACTER, f"{min(meshes.values()).parent}: '{stated}' {reason}")
    if other:
        reason = f"is called so, and character.toml says that '{found[0]}' is the neutral; rename it"
        raise FaceZipError(ErrorCode.BAD_CHARACTER, f"{other[0]}: {reason}")
    return found[0]


def owners_of(
    meshes: dict[str, Path], neutral: str | None, folder: Path, stated: bool = False
) -> tuple[dict[str, str], list[Note]]:
    """Names of meshes by what they are compared as, that of the neutral's being ``neutral``, and what to say of it."""
    owners = {NEUTRAL: NEUTRAL} | {folded(name): NEUTRAL if name == neutral else name for name in meshes}
    if neutral is None or stated or folded(neutral) == NEUTRAL:
        return owners, []
    return owners, [Note(within(folder, meshes[neutral]), "taken for the neutral")]
