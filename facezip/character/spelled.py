"""A folder without ``character.toml`` whose textures are called as other programs do, beside the meshes or below them.

Every texture that is so recognised has a note. What can be meant in two ways is refused, with the ways.
"""

from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path, PurePosixPath

from facezip.character.custom import (
    Found,
    another_space,
    asking,
    counted_from_zero,
    no_map,
    number_of,
    other_note,
    put,
    taken_apart,
    unread_note,
    without_mesh,
)
from facezip.character.filenames import (
    ALSO_A_SIZE,
    MASK,
    are_sizes,
    files_near,
    first_tile,
    is_like_a_mask,
    visible_files,
    within,
)
from facezip.character.map_words import MapWord
from facezip.character.maps import ALBEDO
from facezip.character.mesh_names import NamedMeshes
from facezip.character.notes import Note
from facezip.character.spellings import Ambiguous, Reading, called, chosen, meanings, readings_of
from facezip.errors import ErrorCode, FaceZipError, Refuse, raised
from facezip.files.opening import OTHER_SUFFIXES, TEXTURE_SUFFIXES, not_read

NORMAL = "normal"


@dataclass(frozen=True)
class Spelled:
    """Images by their path in the folder, how each is taken apart, and what its pattern means.

    Attributes
    ----------
    files : all images that are looked at.
    readings : of those that have a mesh's name.
    says : by :attr:`facezip.character.spellings.Reading.like` the map; None where the words mean none.
    beside : whether these are beside the meshes; otherwise they are in folders.
    """

    files: dict[str, Path]
    readings: dict[str, Reading]
    says: dict[str, MapWord | None]
    beside: bool


def spelled(folder: Path, meshes: NamedMeshes) -> Spelled:
    """The images of a folder; those in folders within it where no image in it has a mesh's name.

    Raises
    ------
    FaceZipError
        ``BAD_CHARACTER``: a name can be taken apart in two ways.
    """
    names = called(meshes.called)
    images = _images(folder, visible_files(folder))
    ways = {name: [*readings_of(name, names)] for name in images}
    beside = any(ways.values())
    if not beside:
        images = _images(folder, files_near(folder))
        ways = {name: [*readings_of(name, names)] for name in images}
    try:
        readings = chosen(ways)
    except Ambiguous as doubt:
        reason = f"{doubt}; rename one of these meshes, or say what is what in character.toml (docs/maps.md)"
        raise FaceZipError(ErrorCode.BAD_CHARACTER, f"{folder}: {reason}") from None
    if are_sizes(reading.tile for reading in readings.values()):
        readings = {name: reading.without_tile() for name, reading in readings.items()}
    return Spelled(images, readings, _settled(images, readings, meshes), beside)


def _settled(images: dict[str, Path], readings: dict[str, Reading], meshes: NamedMeshes) -> dict[str, MapWord | None]:
    """What patterns mean; of images beside meshes, or above them, the name of the folder need not say it."""
    says = meanings(readings.values())
    homes = {parent for path in meshes.files.values() for parent in path.parents}
    for name, reading in readings.items():
        if (said := says[reading.like]) is not None and images[name].parent in homes:
            says[reading.like] = replace(said, guessed=False)
    return says


def unused_below(folder: Path, meshes: NamedMeshes, found: Found) -> list[Note]:
    """Notes on images in folders beside textures that are used: they are of maps that those have not, and left out."""
    images = _images(folder, (path for path in files_near(folder) if path.parent.parent == folder))
    if not images or any(path.parent != folder for of in found.maps.values() for path in of.values()):
        return []
    names = called(meshes.called)
    with suppress(Ambiguous):
        readings = chosen({name: [*readings_of(name, names)] for name in sorted(images)})
        says = meanings(readings.values())
        words = "not used: the textures beside the meshes are; put it there, or say in character.toml where it is"
        return [
            Note(name, words, asks=True)
            for name, reading in readings.items()
            if (map := says[reading.like]) and map.map and map.map not in found.maps
        ]
    return []


def _images(folder: Path, files: Iterable[Path]) -> dict[str, Path]:
    suffixes = (*TEXTURE_SUFFIXES, *OTHER_SUFFIXES)
    return {within(folder, path): path for path in files if path.suffix.lower() in suffixes}


def is_custom(folder: Path, meshes: NamedMeshes) -> bool:
    """Whether custom says what every image in a folder is that has a mesh's name; so too where none has."""
    images = [path for path in visible_files(folder) if path.suffix.lower() in TEXTURE_SUFFIXES]
    owners = {path: taken_apart(path, meshes.owners).owner for path in images}
    plain = [path for path, owner in owners.items() if owner not in (None, MASK)]
    names = called(meshes.called)
    others = [path for path, owner in owners.items() if owner is None and not is_like_a_mask(path.stem)]
    if plain and others:
        return not any(True for path in others for _ in readings_of(path.name, names))
    return bool(plain) or not any(True for path in files_near(folder) for _ in readings_of(within(folder, path), names))


def files_by_spelling(
    folder: Path, meshes: NamedMeshes, materials: dict[str, dict[str, str]], refuse: Refuse = raised
) -> Found:
    """As :func:`facezip.character.custom.files_by_custom`, by what programs call maps."""
    return _Sorting(folder, meshes, materials, spelled(folder, meshes)).found(refuse)


class _Sorting:
    """One look through a folder's images."""

    def __init__(self, folder: Path, meshes: NamedMeshes, materials: dict[str, dict[str, str]], look: Spelled) -> None:
        self._folder, self._meshes, self._look = folder, meshes, look
        self._up = [says.green_down for says in look.says.values() if says and says.map == NORMAL]
        self._knows_albedo = any(says.map == ALBEDO and not says.guessed for says in look.says.values() if says)
        used = [reading.tile for reading in look.readings.values() if self._is_used(look.says[reading.like])]
        self._first = first_tile(used)
        down = True in self._up and False not in self._up
        self._found = Found(meshes.files, numbered=any(used), green_down=down, materials=materials)
        if self._first == 0:
            tiles = ((name, reading.tile) for name, reading in look.readings.items())
            self._found.notes.append(counted_from_zero(tiles))

    def found(self, refuse: Refuse) -> Found:
        """All of it; what ``refuse`` does not raise is left out."""
        read = {name: path for name, path in self._look.files.items() if path.suffix.lower() in TEXTURE_SUFFIXES}
        for name, path in (*read.items(), *((n, p) for n, p in self._look.files.items() if n not in read)):
            try:
                self._sort_in(name, path, name in read)
            except FaceZipError as error:
                refuse(error)
        return asking(self._found)

    def _is_used(self, says: MapWord | None) -> bool:
        return says is not None and says.map != "" and not (says.guessed and self._knows_albedo)

    def _sort_in(self, name: str, path: Path, is_read: bool) -> None:
        reading, mask = self._look.readings.get(name), taken_apart(path, {})
        if mask.owner == MASK:
            is_size = mask.parts.tile == ALSO_A_SIZE and not self._found.numbered
            self._put_mask(path, number_of(path, "" if is_size else mask.parts.tile, self._first), is_read)
        elif reading is None:
            self._sort_out(name, path, is_read)
        elif (says := self._look.says[reading.like]) is None:
            self._refuse_unknown(path, reading)
        elif not says.map:
            self._note(name, f"left out: {says.says}, which no map takes")
        elif not self._is_used(says):
            self._note(name, "left out: the name of its folder says no map, and the albedo is elsewhere")
        elif says.green_down and False in self._up:
            self._note(name, "left out: normals with green down; those with green up are there")
        else:
            self._put(name, path, reading, says, is_read)

    def _put_mask(self, path: Path, tile: int, is_read: bool) -> None:
        if is_read:
            put(self._found.masks, tile, path)
        elif tile not in self._found.masks:
            raise not_read(path)

    def _put(self, name: str, path: Path, reading: Reading, says: MapWord, is_read: bool) -> None:
        tile, map = number_of(path, reading.tile, self._first), self._found.maps.setdefault(says.map, {})
        if not is_read:
            if (reading.owner, tile) not in map:
                raise not_read(path)
            return
        if says.map == NORMAL and says.green_down is None and self._found.green_down:
            reason = 'and others say that green is down; say green = "down" or "up" in character.toml (docs/maps.md)'
            raise FaceZipError(ErrorCode.BAD_CHARACTER, f"{path}: normals whose name says nothing of green, {reason}")
        put(map, (reading.owner, tile), path)
        plain = taken_apart(path, self._meshes.owners)
        if not self._look.beside or (plain.owner, plain.parts.map or ALBEDO) != (reading.owner, says.map):
            self._note(name, _taken(says), says.guessed)

    def _sort_out(self, name: str, path: Path, is_read: bool) -> None:
        """An image of no mesh."""
        if not is_read:
            self._found.notes.append(replace(unread_note(path), file=name))
        elif (note := other_note(path, self._found.materials)) is not None:
            self._found.notes.append(replace(note, file=name))
        elif self._look.beside:
            raise without_mesh(path, self._meshes.files)
        else:
            self._note(name, "left out: of no mesh")

    def _refuse_unknown(self, path: Path, reading: Reading) -> None:
        note = other_note(path, self._found.materials)
        if note is None and reading.space:
            raise another_space(path, " ".join(reading.space))
        if note is None:
            behind = PurePosixPath(reading.pattern).name.removeprefix("{name}").replace("{tile}", reading.tile)
            raise no_map(path, reading.owner, behind.lstrip("._ -"), behind.startswith("."))
        self._found.notes.append(note)

    def _note(self, name: str, words: str, asks: bool = False) -> None:
        self._found.notes.append(Note(name, words, asks))


def _taken(says: MapWord) -> str:
    if says.guessed:
        return f"taken for the {says.map}, which its folder's name does not say; if it is, call the folder {says.map}"
    if says.map != NORMAL:
        return f"taken for the {says.map}"
    if says.green_down is None:
        return 'taken for the normals, with green up; if green is down, say so in character.toml (green = "down")'
    return f"taken for the normals, with green {'down' if says.green_down else 'up'}, as its name says"
