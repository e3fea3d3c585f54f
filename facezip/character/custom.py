"""A folder without ``character.toml``: which file is what, by the custom that names are ``NAME.MAP.TILE``."""

import re
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from facezip.character.filenames import (
    MASK,
    TILE,
    Parts,
    at_rest,
    first_tile,
    is_like_a_mask,
    is_litter,
    readings,
    tile_number,
)
from facezip.character.maps import ALBEDO, KNOWN
from facezip.character.notes import Note
from facezip.character.parts import listed
from facezip.character.scans import NEUTRAL
from facezip.character.tiles import FIRST_TILE
from facezip.errors import ErrorCode, FaceZipError, Refuse, raised
from facezip.files.opening import OTHER_SUFFIXES, TEXTURE_SUFFIXES, not_read
from facezip.names import folded, one_form

MESH_SUFFIX = ".obj"
# Meshes all the same, whose files would be missed beside the others.
OTHER_MESHES = (
    *(".fbx", ".ply", ".stl", ".abc", ".usd", ".usda", ".usdc", ".usdz", ".dae", ".ztl", ".zpr", ".blend"),
    *(".ma", ".mb", ".max", ".c4d", ".hip", ".lwo", ".3ds", ".x3d", ".off", ".glb", ".gltf"),
)


@dataclass(frozen=True)
class Found:
    """Files of a folder.

    Attributes
    ----------
    meshes : by name in one Unicode form, the neutral's being ``neutral``.
    maps : by map, textures by name and tile.
    masks : by tile.
    numbered : whether names of textures say tiles.
    materials : images that material libraries name, as of :func:`facezip.files.mtl.images_by_material`.
    notes : what is not used, and what is certain but not called as it should be.
    """

    meshes: dict[str, Path]
    maps: dict[str, dict[tuple[str, int], Path]] = field(default_factory=dict)
    masks: dict[int, Path] = field(default_factory=dict)
    numbered: bool = False
    materials: dict[str, dict[str, str]] = field(default_factory=dict)
    notes: list[Note] = field(default_factory=list)


@dataclass(frozen=True)
class _Image:
    """An image, the parts of its name, and the name of the mesh that it is of; None where there is none."""

    path: Path
    parts: Parts
    owner: str | None


def files_by_custom(
    folder: Path,
    meshes: dict[str, Path],
    owners: dict[str, str],
    materials: dict[str, dict[str, str]],
    refuse: Refuse = raised,
) -> Found:
    """Look through a folder; what ``refuse`` does not raise is left out.

    Parameters
    ----------
    folder : which.
    meshes, owners : its meshes, of :func:`meshes_in`.
    materials : as of :func:`facezip.files.mtl.images_by_material`.
    refuse : takes the errors of single images.

    Raises
    ------
    FaceZipError
        ``BAD_CHARACTER`` for two files of one texture, or a name that says no map or tile; ``MISSING_FILE`` for a
        texture without a mesh; ``UNREADABLE_IMAGE`` for a texture of a format that is not read.
    """
    files = visible_files(folder)
    images = [_taken_apart(path, owners) for path in files if path.suffix.lower() in TEXTURE_SUFFIXES]
    tiles = [image.parts.tile for image in images if image.owner is not None]
    found, first = Found(meshes, numbered=any(tiles), materials=materials), first_tile(tiles)
    if first == 0:
        named = next(image.path for image in images if re.search(r"[uv]0(?!\d)", image.parts.tile, re.IGNORECASE))
        found.notes.append(Note(named.name, f"tiles are counted from u0, v0, which is {FIRST_TILE}"))
    others = [_taken_apart(path, owners) for path in files if path.suffix.lower() in OTHER_SUFFIXES]
    for sort_in, some in ((_sort_in, images), (_check_unread, others)):
        for image in some:
            try:
                sort_in(found, image, first)
            except FaceZipError as error:
                refuse(error)
    tiles_without = {tile for _, tile in found.maps.get(ALBEDO, {})} - {*found.masks}
    # What is called nearly so may be meant where there is no mask.
    return replace(found, notes=[replace(note, asks=note.asks and bool(tiles_without)) for note in found.notes])


def meshes_in(folder: Path) -> tuple[dict[str, Path], dict[str, str], list[Note]]:
    """The meshes of a folder by name, the neutral's being ``neutral``; what :func:`owners_of` says of their names.

    Raises
    ------
    FaceZipError
        ``BAD_CHARACTER``: two of one name, or several that may be the neutral.
    """
    meshes = mesh_files(path for path in visible_files(folder) if path.suffix.lower() == MESH_SUFFIX)
    owners, notes = owners_of(meshes, neutral_among(meshes))
    return {owners[folded(name)]: path for name, path in meshes.items()}, owners, notes


def visible_files(folder: Path) -> list[Path]:
    """The files in a folder that are a person's, by name."""
    return [path for path in sorted(folder.iterdir()) if not is_litter(Path(path.name)) and path.is_file()]


def mesh_files(paths: Iterator[Path]) -> dict[str, Path]:
    """Meshes by their names in one Unicode form; ``BAD_CHARACTER`` where a file system may take two for one."""
    meshes: dict[str, Path] = {}
    seen: dict[str, Path] = {}
    for path in paths:
        beside = seen.setdefault(folded(path.stem), path)
        if beside != path:
            alike = "in its Unicode form" if one_form(path.stem) == one_form(beside.stem) else "in case"
            raise FaceZipError(
                ErrorCode.BAD_CHARACTER,
                f"{path}: a second mesh beside {beside.name}, whose name differs {alike} alone; rename or remove one",
            )
        meshes[one_form(path.stem)] = path
    return meshes


def neutral_among(meshes: dict[str, Path]) -> str | None:
    """The name that the neutral's mesh has: ``neutral`` in any case, or what else is certain; None where nothing is.

    Raises
    ------
    FaceZipError
        ``BAD_CHARACTER``: several may be it.
    """
    rest = [name for name in meshes if folded(name) == NEUTRAL] or at_rest(meshes)
    if len(rest) > 1:
        raise FaceZipError(
            ErrorCode.BAD_CHARACTER,
            f"{meshes[rest[0]]}: may be the neutral, and so may {meshes[rest[1]].name}; call the one {NEUTRAL}.obj",
        )
    return rest[0] if rest else None


def owners_of(meshes: dict[str, Path], neutral: str | None) -> tuple[dict[str, str], list[Note]]:
    """Names of meshes by what they are compared as, that of the neutral's being ``neutral``, and what to say of it."""
    owners = {NEUTRAL: NEUTRAL} | {folded(name): NEUTRAL if name == neutral else name for name in meshes}
    if neutral is None or folded(neutral) == NEUTRAL:
        return owners, []
    return owners, [Note(meshes[neutral].name, "taken for the neutral")]


def texture_among(files: Iterable[Path], name: str) -> Path | None:
    """The texture of a name among files, whatever its suffix; None where there is none.

    Raises
    ------
    FaceZipError
        ``BAD_CHARACTER``: two are of that name.
    """
    alike = [path for path in files if folded(path.stem) == folded(name)]
    found = [path for path in alike if path.suffix.lower() in TEXTURE_SUFFIXES]
    if len(found) > 1:
        raise second_texture(found[1], found[0])
    return next(iter(found or [path for path in alike if path.suffix.lower() in OTHER_SUFFIXES]), None)


def second_texture(path: Path, beside: Path, what: str = "texture") -> FaceZipError:
    """The error for two files of one texture, or mesh."""
    return FaceZipError(ErrorCode.BAD_CHARACTER, f"{path}: a second {what} beside {beside.name}; keep one of them")


def _taken_apart(path: Path, owners: dict[str, str]) -> _Image:
    """A texture by the longest name that a mesh, or the mask, has: such a name is a name, whatever it ends in."""
    known = {**owners, folded(MASK): MASK}
    for parts in readings(path.stem):
        owner = known.get(folded(parts.name))
        if owner is not None and not (owner == MASK and parts.map):
            return _Image(path, parts, owner)
    return _Image(path, Parts(path.stem), None)


def _sort_in(found: Found, image: _Image, first: int) -> None:
    path, parts, owner = image.path, image.parts, image.owner
    if owner is None:
        if whose := [material for material, images in found.materials.items() if folded(path.name) in images]:
            found.notes.append(Note(path.name, f"left out: a texture of the material {listed(whose)}"))
            return
        if is_like_a_mask(path.stem):
            found.notes.append(
                Note(path.name, "not taken for the mask; call it mask.png if it is the face's", asks=True)
            )
            return
        raise without_mesh(path, found.meshes)
    tile = _number(path, parts, first)
    if owner == MASK:
        put(found.masks, tile, path)
        return
    if one_form(parts.name) != one_form(found.meshes[owner].stem) and owner != NEUTRAL:
        found.notes.append(Note(path.name, f"taken for a texture of {found.meshes[owner].name}"))
    put(found.maps.setdefault(parts.map or ALBEDO, {}), (owner, tile), path)


def put(files: dict[Any, Path], key: Any, path: Path, what: str = "texture") -> None:
    """Add a texture, or mesh; ``BAD_CHARACTER`` where there is one."""
    if key in files:
        raise second_texture(path, files[key], what)
    files[key] = path


def _number(path: Path, parts: Parts, first: int) -> int:
    try:
        return tile_number(parts.tile, first)
    except ValueError as fault:
        raise FaceZipError(ErrorCode.BAD_CHARACTER, f"{path}: {fault}; rename it") from None


def _check_unread(found: Found, image: _Image, first: int) -> None:
    """Refuse an image of a format that is not read where no other is in its place."""
    path, parts, owner = image.path, image.parts, image.owner
    if owner is None:
        like_a_mask = is_like_a_mask(path.stem)
        words = "not read; save it as mask.png if it is the face's" if like_a_mask else "not read, and of no mesh"
        found.notes.append(Note(path.name, words, asks=like_a_mask))
        return
    tile = _number(path, parts, first)
    served = tile in found.masks if owner == MASK else (owner, tile) in found.maps.get(parts.map or ALBEDO, {})
    if not served:
        raise not_read(path)


def without_mesh(texture: Path, meshes: Collection[str]) -> FaceZipError:
    """The error for a texture of none of the meshes; where its name begins like one of theirs, of what follows."""
    stem = one_form(texture.stem)
    owners = [name for name in meshes if folded(stem[: len(name)]) == folded(name) and stem[len(name) :][:1] in "._- "]
    if not owners:
        return _no_mesh(texture, min((parts.name for parts in readings(texture.stem)), key=len))
    owner = max(owners, key=len)
    behind = stem[len(owner) + 1 :]
    nearest = _nearest(re.split(r"[._ -]", behind) if stem[len(owner)] != "." else behind.split("."))
    known = f"there are {', '.join(KNOWN)}, then a UDIM tile such as {FIRST_TILE}"
    remedy = f"call it {owner}.{nearest}{texture.suffix}" if nearest else "rename it"
    return FaceZipError(
        ErrorCode.BAD_CHARACTER,
        f"{texture}: '{behind}' is no map of '{owner}'; {known}; {remedy}, or list it in character.toml (docs/maps.md)",
    )


def _no_mesh(texture: Path, name: str) -> FaceZipError:
    there = [path for path in sorted(texture.parent.iterdir()) if path.suffix.lower() in OTHER_MESHES]
    other = next((path for path in there if folded(path.stem) == folded(name)), None)
    if other is not None:
        return FaceZipError(
            ErrorCode.UNREADABLE_MESH, f"{other}: {other.suffix.lower()} is not read; export the mesh as OBJ"
        )
    return FaceZipError(
        ErrorCode.MISSING_FILE,
        f"{texture}: there is no mesh {name}{MESH_SUFFIX} beside it; add the mesh, or move the image out of the folder",
    )


def _nearest(parts: list[str]) -> str | None:
    """A map, a tile, or both, in their order, as close as can be to what stands behind a name; None for no idea."""
    tiles = [found[0] for part in parts if (found := re.search(TILE, part, re.IGNORECASE))]
    maps = [name for part in parts for name in get_close_matches(part.lower(), KNOWN, 1)]
    both = len(tiles) + len(maps) == len(parts) and max(len(tiles), len(maps)) == 1
    return ".".join((*maps, *tiles)) if both else None
