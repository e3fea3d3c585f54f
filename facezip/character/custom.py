"""A folder without ``character.toml``: which file is what, by the custom that names are ``NAME.MAP.TILE``."""

import re
from collections.abc import Collection, Iterable
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from facezip.character.filenames import (
    MASK,
    TILE,
    Parts,
    are_sizes,
    first_tile,
    folder_called,
    is_like_a_mask,
    readings,
    tile_number,
    visible_files,
)
from facezip.character.maps import ALBEDO, KNOWN
from facezip.character.mesh_names import MESH_SUFFIX, OTHER_MESHES
from facezip.character.notes import Note
from facezip.character.parts import listed
from facezip.character.scans import NEUTRAL
from facezip.character.tiles import FIRST_TILE
from facezip.errors import ErrorCode, FaceZipError, Refuse, raised
from facezip.files.opening import OTHER_SUFFIXES, TEXTURE_SUFFIXES, not_read
from facezip.names import folded, one_form


@dataclass(frozen=True)
class Found:
    """Files of a folder.

    Attributes
    ----------
    meshes : by name in one Unicode form, the neutral's being ``neutral``.
    maps : by map, textures by name and tile.
    masks : by tile.
    numbered : whether names of textures say tiles.
    green_down : whether names of normals say that y is down.
    materials : images that material libraries name, as of :func:`facezip.files.mtl.images_by_material`.
    notes : what is not used, and what is certain but not called as it should be.
    """

    meshes: dict[str, Path]
    maps: dict[str, dict[tuple[str, int], Path]] = field(default_factory=dict)
    masks: dict[int, Path] = field(default_factory=dict)
    numbered: bool = False
    green_down: bool = False
    materials: dict[str, dict[str, str]] = field(default_factory=dict)
    notes: list[Note] = field(default_factory=list)


@dataclass(frozen=True)
class Image:
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
    meshes, owners : its meshes, of :func:`facezip.character.mesh_names.meshes_in`.
    materials : as of :func:`facezip.files.mtl.images_by_material`.
    refuse : takes the errors of single images.

    Raises
    ------
    FaceZipError
        ``BAD_CHARACTER`` for two files of one texture, or a name that says no map or tile; ``MISSING_FILE`` for a
        texture without a mesh; ``UNREADABLE_IMAGE`` for a texture of a format that is not read.
    """
    files = visible_files(folder)
    images = [taken_apart(path, owners) for path in files if path.suffix.lower() in TEXTURE_SUFFIXES]
    others = [taken_apart(path, owners) for path in files if path.suffix.lower() in OTHER_SUFFIXES]
    if are_sizes(image.parts.tile for image in images if image.owner is not None):
        images, others = _without_tiles(images), _without_tiles(others)
    tiles = [image.parts.tile for image in images if image.owner is not None]
    found, first = Found(meshes, numbered=any(tiles), materials=materials), first_tile(tiles)
    if first == 0:
        found.notes.append(counted_from_zero((image.path.name, image.parts.tile) for image in images))
    for sort_in, some in ((_sort_in, images), (_check_unread, others)):
        for image in some:
            try:
                sort_in(found, image, first)
            except FaceZipError as error:
                refuse(error)
    return asking(found)


def counted_from_zero(written: Iterable[tuple[str, str]]) -> Note:
    """The note on tiles that are counted so, of files and their tiles as they are written."""
    named = next(file for file, tile in written if re.search(r"[uv]0(?!\d)", tile, re.IGNORECASE))
    return Note(named, f"tiles are counted from u0, v0, which is {FIRST_TILE}")


def asking(found: Found) -> Found:
    """The same; what is called nearly like the mask may be meant where there is no mask alone."""
    tiles_without = {tile for _, tile in found.maps.get(ALBEDO, {})} - {*found.masks}
    if tiles_without:
        return found
    of_mask = [is_like_a_mask(Path(note.file).stem) for note in found.notes]
    notes = [replace(note, asks=note.asks and not mask) for note, mask in zip(found.notes, of_mask, strict=True)]
    return replace(found, notes=notes)


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
    name, remedy = beside.name, "keep one of them"
    if beside.parent != path.parent:
        name, remedy = f"{beside.parent.name}/{name}", f"{remedy}, or say in character.toml (docs/maps.md) which it is"
    return FaceZipError(ErrorCode.BAD_CHARACTER, f"{path}: a second {what} beside {name}; {remedy}")


def taken_apart(path: Path, owners: dict[str, str]) -> Image:
    """A texture by the longest name that a mesh, or the mask, has: such a name is a name, whatever it ends in."""
    known = {**owners, folded(MASK): MASK}
    for parts in readings(path.stem):
        owner = known.get(folded(parts.name))
        if owner is not None and not (owner == MASK and parts.map):
            return Image(path, parts, owner)
    return Image(path, Parts(path.stem), None)


def _without_tiles(images: list[Image]) -> list[Image]:
    return [replace(image, parts=replace(image.parts, tile="")) for image in images]


def _sort_in(found: Found, image: Image, first: int) -> None:
    path, parts, owner = image.path, image.parts, image.owner
    if owner is None:
        note = other_note(path, found.materials)
        if note is None:
            raise without_mesh(path, found.meshes)
        found.notes.append(note)
        return
    tile = number_of(path, parts.tile, first)
    if owner == MASK:
        put(found.masks, tile, path)
        return
    if one_form(parts.name) != one_form(found.meshes[owner].stem) and owner != NEUTRAL:
        found.notes.append(Note(path.name, f"taken for a texture of {found.meshes[owner].name}"))
    put(found.maps.setdefault(parts.map or ALBEDO, {}), (owner, tile), path)


def other_note(path: Path, materials: dict[str, dict[str, str]]) -> Note | None:
    """The note on an image that is no texture of the character's; None where nothing says what it is."""
    if whose := [material for material, images in materials.items() if folded(path.name) in images]:
        return Note(path.name, f"left out: a texture of the material {listed(whose)}")
    if is_like_a_mask(path.stem):
        return Note(path.name, "not taken for the mask; call it mask.png if it is the face's", asks=True)
    return None


def put(files: dict[Any, Path], key: Any, path: Path, what: str = "texture") -> None:
    """Add a texture, or mesh; ``BAD_CHARACTER`` where there is one."""
    if key in files:
        raise second_texture(path, files[key], what)
    files[key] = path


def number_of(path: Path, written: str, first: int) -> int:
    """The UDIM number of a tile in a file's name; ``BAD_CHARACTER`` where it is none."""
    try:
        return tile_number(written, first)
    except ValueError as fault:
        raise FaceZipError(ErrorCode.BAD_CHARACTER, f"{path}: {fault}; rename it") from None


def unread_note(path: Path) -> Note:
    """The note on an image of a format that is not read, and of no mesh."""
    like_a_mask = is_like_a_mask(path.stem)
    words = "not read; save it as mask.png if it is the face's" if like_a_mask else "not read, and of no mesh"
    return Note(path.name, words, asks=like_a_mask)


def _check_unread(found: Found, image: Image, first: int) -> None:
    """Refuse an image of a format that is not read where no other is in its place."""
    path, parts, owner = image.path, image.parts, image.owner
    if owner is None:
        found.notes.append(unread_note(path))
        return
    tile = number_of(path, parts.tile, first)
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
    return no_map(texture, owner, stem[len(owner) + 1 :], stem[len(owner)] == ".")


def no_map(texture: Path, owner: str, behind: str, dotted: bool = False) -> FaceZipError:
    """The error for a texture of which what stands behind its owner's name is no map; ``dotted`` where a dot does."""
    nearest = _nearest(behind.split(".") if dotted else re.split(r"[._ -]", behind))
    known = f"there are {', '.join(KNOWN)}, then a UDIM tile such as {FIRST_TILE}"
    remedy = f"call it {owner}.{nearest}{texture.suffix}" if nearest else "rename it"
    return FaceZipError(
        ErrorCode.BAD_CHARACTER,
        f"{texture}: '{behind}' is no map of '{owner}'; {known}; {remedy}, or list it in character.toml, which facezip "
        "doctor prints for these files",
    )


def another_space(texture: Path, words: str) -> FaceZipError:
    """The error for a texture whose name states a colour space, in these words, in which it is not read."""
    read_in = "linear sRGB" if texture.suffix.lower() == ".exr" else "sRGB"
    return FaceZipError(
        ErrorCode.BAD_CHARACTER,
        f"{texture}: its name says that its colours are of '{words}', and files are not converted by their names; "
        f"convert it to {read_in}, and leave '{words}' out of its name",
    )


def is_a_folder(path: Path, what: str) -> FaceZipError:
    """The error for a folder that is called as a file of these words should be."""
    reason = f"is a folder, and {what} has to be a file; put the file in its place"
    return FaceZipError(ErrorCode.MISSING_FILE, f"{path}: {reason}")


def _no_mesh(texture: Path, name: str) -> FaceZipError:
    if (place := folder_called(texture.with_name(f"{name}{MESH_SUFFIX}"), [MESH_SUFFIX])) is not None:
        return is_a_folder(place, f"the mesh of '{name}'")
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
