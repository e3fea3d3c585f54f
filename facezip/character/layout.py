"""Which file of a folder is which map of which expression on which tile: by custom, or as ``character.toml`` says."""

from collections.abc import Collection
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from facezip.character.custom import files_by_custom, is_a_folder, put
from facezip.character.filenames import MASK, files_below, folder_called, is_litter, readings, within
from facezip.character.maps import ALBEDO, KNOWN, Map
from facezip.character.mesh_names import MESH_SUFFIX, OTHER_MESHES, meshes_in, neutral_among, owners_of
from facezip.character.notes import Note
from facezip.character.patterns import matches_nothing, matching
from facezip.character.scans import FEWEST, NEUTRAL, at_least
from facezip.character.settings import MASK_FILE, SETTINGS, Patterns, Settings
from facezip.character.spelled import NORMAL, files_by_spelling, is_custom, unused_below
from facezip.character.tiles import FIRST_TILE
from facezip.errors import ErrorCode, FaceZipError, Refuse, raised
from facezip.files.mtl import images_by_material
from facezip.files.opening import OTHER_SUFFIXES, TEXTURE_SUFFIXES, not_read
from facezip.files.packs import MANIFEST
from facezip.files.reading import reading
from facezip.names import folded


@dataclass(frozen=True)
class MapFiles:
    """How the files of one map are read.

    Attributes
    ----------
    kind : what it holds.
    files : its textures by expression (``neutral`` too) and tile.
    keeps_floats : whether values outside [0, 1] are kept, with their range, instead of refused.
    green_down : whether normals have y down, as Direct3D does.
    """

    kind: Map
    files: dict[tuple[str, int], Path] = field(default_factory=dict)
    keeps_floats: bool = False
    green_down: bool = False


@dataclass(frozen=True)
class Layout:
    """The files of a character.

    Attributes
    ----------
    folder : where they are.
    meshes : by name, ``neutral`` among them.
    maps : albedo first.
    masks : by tile; a tile without one counts wholly.
    numbered : whether names of textures say tiles; otherwise there is one texture, which renderers repeat.
    materials : images that material libraries name, as of :func:`facezip.files.mtl.images_by_material`.
    part : the material that is the face, where that is said.
    notes : what is not used, and what is certain but not called as it should be.
    """

    folder: Path
    meshes: dict[str, Path]
    maps: tuple[MapFiles, ...]
    masks: dict[int, Path]
    numbered: bool = False
    materials: dict[str, dict[str, str]] = field(default_factory=dict)
    part: str | None = None
    notes: tuple[Note, ...] = ()

    @property
    def expressions(self) -> tuple[str, ...]:
        """Names in their order, without the neutral."""
        return tuple(sorted(name for name in self.meshes if name != NEUTRAL))

    def note(self, path: Path, words: str, asks: bool = False) -> Note:
        """A note on one of the files."""
        return Note(within(self.folder, path), words, asks)

    @property
    def tiles(self) -> tuple[int, ...]:
        """UDIM numbers of the neutral's albedo."""
        return tuple(sorted(tile for name, tile in self.maps[0].files if name == NEUTRAL))


def read_layout(folder: Path, settings: Settings, refuse: Refuse = raised, fewest: int = FEWEST) -> Layout:
    """The files of a character folder; a texture that ``refuse`` does not raise an error for is left out.

    Parameters
    ----------
    folder : which.
    settings : what its ``character.toml`` says.
    refuse : takes the errors of single images.
    fewest : expressions that there have to be.

    Raises
    ------
    FaceZipError
        ``MISSING_FILE`` for a mesh, or a map of an expression on a tile, that others have; ``TOO_FEW_EXPRESSIONS``;
        ``BAD_CHARACTER`` for patterns that are none, two files for one texture, or no albedo.
    """
    if not folder.is_dir():
        what = "is a file" if folder.exists() else "no such folder or glTF"
        raise FaceZipError(ErrorCode.MISSING_FILE, f"{folder}: {what}; give the folder with neutral.obj in it")
    if (folder / MANIFEST).is_file():
        reason = "is a pack; give the folder of scans that it was made of"
        raise FaceZipError(ErrorCode.BAD_CHARACTER, f"{folder}: {reason}")
    with reading(folder):
        patterns = settings.patterns
        if patterns is None:
            layout = _by_custom(folder, settings.neutral, refuse, fewest)
        else:
            layout = _by_patterns(folder, patterns, settings.neutral, fewest)
        layout = replace(layout, part=settings.part)
        _check_complete(layout, refuse)
    return _with_fitting_masks(layout)


def holds_neutral(folder: Path, below: bool = False) -> bool:
    """Whether a folder has a mesh that is the neutral, or has it ``below``, whatever is wrong with it."""
    try:
        return NEUTRAL in meshes_in(folder, below=below).files
    except FaceZipError:
        # Two may be it.
        return True
    except OSError:
        return False


def _by_custom(folder: Path, neutral: str | None, refuse: Refuse, fewest: int) -> Layout:
    meshes = meshes_in(folder, neutral, below=True)
    _check_meshes(folder, meshes.files, fewest)
    materials = images_by_material(meshes.files[NEUTRAL].parent)
    if is_custom(folder, meshes):
        found = files_by_custom(folder, meshes.files, meshes.owners, materials, refuse)
    else:
        found = files_by_spelling(folder, meshes, materials, refuse)
    maps = {
        name: MapFiles(KNOWN[name], files, green_down=found.green_down and name == NORMAL)
        for name, files in found.maps.items()
    }
    notes = [*meshes.notes, *found.notes, *unused_below(folder, meshes, found)]
    if (place := folder_called(folder / MASK_FILE, TEXTURE_SUFFIXES)) is not None:
        words = "a folder, and no mask; save the mask as a file of that name"
        notes.append(Note(within(folder, place), words, asks=True))
    albedo_first = _albedo_first(folder, maps, at_rest=meshes.files[NEUTRAL])
    return Layout(folder, found.meshes, albedo_first, found.masks, found.numbered, materials, notes=tuple(notes))


def _by_patterns(folder: Path, patterns: Patterns, neutral: str | None, fewest: int) -> Layout:
    files = files_below(folder)
    try:
        found = {name: matching(folder, files, stated.files) for name, stated in patterns.maps.items()}
        called = {name: file for (name, _), file in matching(folder, files, patterns.meshes)[0].items()}
        masks = {tile: file for (_, tile), file in matching(folder, files, patterns.masks)[0].items()}
    except ValueError as error:
        raise FaceZipError(ErrorCode.BAD_CHARACTER, f"{folder / SETTINGS}: {error}") from None
    stated_patterns: dict[str, tuple[str, Collection[Any]]]
    stated_patterns = {f"files of maps.{name}": (patterns.maps[name].files, of) for name, (of, _) in found.items()}
    stated_patterns |= {"meshes": (patterns.meshes, called), "mask": (patterns.masks, masks)}
    for key, (pattern, of) in stated_patterns.items():
        if not of and (key, pattern) != ("mask", MASK_FILE):
            raise matches_nothing(folder / SETTINGS, key, pattern, files)
    owners, notes = owners_of(called, neutral_among(called, neutral), folder, stated=neutral is not None)
    meshes: dict[str, Path] = {}
    for name, file in called.items():
        put(meshes, owners[folded(name)], file, "mesh")
    _check_meshes(folder, meshes, fewest)
    maps = {}
    for map, (caught, _) in found.items():
        stated = patterns.maps[map]
        maps[map] = MapFiles(stated.kind, {}, stated.keeps_floats, stated.green_down)
        # A pattern may catch more than the scans.
        for (name, tile), file in caught.items():
            if folded(name) in owners:
                put(maps[map].files, (owners[folded(name)], tile), file)
    numbered = any(is_numbered for _, is_numbered in found.values())
    materials = images_by_material(meshes[NEUTRAL].parent)
    albedo_first = _albedo_first(folder, maps, patterns)
    return Layout(folder, meshes, albedo_first, masks, numbered, materials, notes=tuple(notes))


def _albedo_first(
    folder: Path, maps: dict[str, MapFiles], patterns: Patterns | None = None, at_rest: Path | None = None
) -> tuple[MapFiles, ...]:
    if ALBEDO not in maps or not any(name == NEUTRAL for name, _ in maps[ALBEDO].files):
        if at_rest is not None and (place := folder_called(at_rest, TEXTURE_SUFFIXES)) is not None:
            raise is_a_folder(place, "the albedo of the neutral")
        reason = "no albedo of the neutral; it needs a neutral.png, and every expression a NAME.png"
        if patterns is not None and ALBEDO not in maps:
            reason = f"{SETTINGS} names files, and not those of the albedo; add [maps.{ALBEDO}] with files"
        elif patterns is not None:
            reason = f"'{patterns.maps[ALBEDO].files}' in {SETTINGS} matches no albedo of the neutral"
        raise FaceZipError(ErrorCode.BAD_CHARACTER, f"{folder}: {reason}")
    return tuple(maps[name] for name in [ALBEDO, *sorted({*maps} - {ALBEDO})])


def _check_complete(layout: Layout, refuse: Refuse) -> None:
    for how in layout.maps:
        for name in (NEUTRAL, *layout.expressions):
            for tile in layout.tiles:
                if (name, tile) not in how.files:
                    refuse(_missing(layout, how, name, tile))
        for (_, tile), file in how.files.items():
            if tile not in layout.tiles:
                words = f"{file}: the neutral has no albedo on tile {tile}; add it, or remove this file"
                refuse(FaceZipError(ErrorCode.BAD_CHARACTER, words))


def _missing(layout: Layout, how: MapFiles, name: str, tile: int) -> FaceZipError:
    """The error for a texture that others have, under the name that it has beside them."""
    file = _expected(layout, how, name, tile)
    if (place := folder_called(file, TEXTURE_SUFFIXES)) is not None:
        return is_a_folder(place, f"the {how.kind.name} of '{name}'")
    there = sorted(file.parent.iterdir()) if file.parent.is_dir() else []
    other = [path for path in there if folded(path.stem) == folded(file.stem) and path.suffix.lower() in OTHER_SUFFIXES]
    if other:
        return not_read(other[0])
    where = f" on tile {tile}" if layout.numbered else ""
    return FaceZipError(
        ErrorCode.MISSING_FILE,
        f"{file}: missing, there is no {how.kind.name} of '{name}'{where}; add the file or remove {name}'s mesh",
    )


def _expected(layout: Layout, how: MapFiles, name: str, tile: int) -> Path:
    """What a texture would be called: as another one of that tile is; otherwise by custom."""
    for beside, path in ((one, how.files.get((one, tile))) for one in layout.meshes):
        stem, like = layout.meshes[beside].stem, path and path.relative_to(layout.folder).as_posix()
        if like and stem in like:
            return layout.folder / like.replace(stem, layout.meshes[name].stem)
    behind = "" if how.kind.name == ALBEDO else f".{how.kind.name}"
    return layout.folder / f"{name}{behind}{f'.{tile}' if layout.numbered else ''}.png"


def _with_fitting_masks(layout: Layout) -> Layout:
    """A mask without a tile's number is that of the only tile; what it is of several is said, as is a tile too many."""
    masks, tiles, notes = dict(layout.masks), layout.tiles, list(layout.notes)
    whole = masks.get(FIRST_TILE)
    if whole and layout.numbered and not any(parts.tile for parts in readings(whole.stem)):
        if len(tiles) == 1:
            masks = {tiles[0]: whole}
        else:
            number = FIRST_TILE if FIRST_TILE in tiles else tiles[0]
            words = f"taken for the mask of tile {number} alone; call it {MASK}.{number}{whole.suffix}"
            notes.append(layout.note(whole, words, asks=True))
    elif {*masks} & {*tiles}:
        words = "its tile has no mask, as others have, and counts as face wholly"
        bare = (layout.maps[0].files[NEUTRAL, tile] for tile in tiles if tile not in masks)
        notes += [layout.note(path, words, asks=True) for path in bare]
    for tile in sorted({*masks} - {*tiles}):
        words = f"not used: there are no textures on tile {tile}"
        notes.append(layout.note(masks.pop(tile), words, asks=True))
    return replace(layout, masks=masks, notes=tuple(notes))


def _check_meshes(folder: Path, meshes: dict[str, Path], fewest: int) -> None:
    if NEUTRAL not in meshes:
        raise _without_neutral(folder, meshes)
    if len(meshes) <= fewest:
        reason = f"{len(meshes) - 1} expression(s); {at_least(fewest)}"
        raise FaceZipError(ErrorCode.TOO_FEW_EXPRESSIONS, f"{folder}: {reason}")


def _without_neutral(folder: Path, meshes: dict[str, Path]) -> FaceZipError:
    """The error for a folder without a neutral mesh, of what is there instead."""
    if (place := folder_called(folder / f"{NEUTRAL}{MESH_SUFFIX}", [MESH_SUFFIX])) is not None:
        return is_a_folder(place, "the mesh of the neutral")
    there = sorted(path for path in folder.iterdir() if not is_litter(Path(path.name)))
    others = [path for path in there if path.suffix.lower() in OTHER_MESHES]
    nested = [
        path for path in there if path.is_dir() and any(file.suffix.lower() == MESH_SUFFIX for file in path.iterdir())
    ]
    remedy = "a character needs a neutral mesh"
    if meshes:
        few = ", ".join(path.name for path in [*meshes.values()][:3])
        remedy = (
            f"its meshes are {few}{' …' if len(meshes) > 3 else ''}: call that of the face at rest {NEUTRAL}.obj, or "
        )
        remedy += f'say neutral = "NAME" in {SETTINGS}'
    elif others:
        remedy = f"{others[0].name} is not read here: export OBJ" + (
            ", or give that file itself" if others[0].suffix.lower() in (".glb", ".gltf") else ""
        )
    elif nested:
        remedy = f"give the folder with the meshes, such as {nested[0].name}, or say where they are in {SETTINGS}"
    return FaceZipError(ErrorCode.MISSING_FILE, f"{folder}: no {NEUTRAL}.obj; {remedy}")
