"""What names of files say, whichever program or system wrote them: of which expression, map and tile a texture is.

Names are compared in one Unicode form and without regard to case, as most file systems do.
"""

import re
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path

from facezip.character.maps import KNOWN
from facezip.character.tiles import FIRST_TILE, LAST_TILE
from facezip.files.packs import MANIFEST, is_pack
from facezip.names import folded, one_form

MASK = "mask"
# What systems and programs leave beside people's files; all else of theirs begins with a dot.
_LITTER = {"thumbs.db", "ehthumbs.db", "desktop.ini", "icon\r", "__macosx", "@eadir", "$recycle.bin"}
# UDIM numbers, and columns and rows as sculpting programs count them; in patterns of character.toml too.
TILE = r"1(?!000)\d{3}|u\d{1,2}_?v\d{1,2}"
# Of these numbers the one that is also a usual size of textures.
ALSO_A_SIZE = "1024"
_TILE_BEHIND = re.compile(rf"[._ -](?P<tile>{TILE})$", re.IGNORECASE)
_MAP_BEHIND = re.compile(rf"\.(?P<map>{'|'.join(KNOWN)})$", re.IGNORECASE)
_MASK_LIKE = re.compile(r"(^|[^a-z])masks?|masks?([^a-z]|$)")
# What programs call a face at rest, from the surest on; without digits and what joins words.
_AT_REST = (
    {"neutral", "neutralface", "faceneutral", "neutralpose", "neutralexpression", "expressionneutral"},
    {"base", "basis", "rest", "default", "basemesh", "baseface", "restpose", "bindpose", "basepose", "defaultpose"},
)


@dataclass(frozen=True)
class Parts:
    """A texture's name without its suffix, taken apart.

    Attributes
    ----------
    name : whose it is.
    map : of :data:`facezip.character.maps.KNOWN`; "" where none is said, which is the albedo.
    tile : as it is written; "" where none is said.
    """

    name: str
    map: str = ""
    tile: str = ""


def is_litter(path: Path) -> bool:
    """Whether a file, or a folder that it is in, is hidden or a system's own; give it relative to the character's."""
    return any(part.startswith((".", "~$")) or part.casefold() in _LITTER for part in path.parts)


def visible_files(folder: Path) -> list[Path]:
    """The files in a folder that are a person's, by name."""
    return [path for path in sorted(folder.iterdir()) if not is_litter(Path(path.name)) and path.is_file()]


def files_below(folder: Path) -> list[Path]:
    """All files in a folder and those within it that are a person's."""
    return _of_a_person(folder, sorted(folder.rglob("*")))


def files_near(folder: Path) -> list[Path]:
    """The files in a folder, in those within it, and in those within these, that are a person's."""
    near = (path for pattern in ("*", "*/*", "*/*/*") for path in sorted(folder.glob(pattern)))
    return _of_a_person(folder, near)


def _of_a_person(folder: Path, paths: Iterable[Path]) -> list[Path]:
    """The files that are no litter, and not of a pack, which may have been written beside its scans."""
    files = [path for path in paths if not is_litter(path.relative_to(folder)) and path.is_file()]
    packs = {file.parent for file in files if file.name == MANIFEST and is_pack(file.parent)}
    return [file for file in files if packs.isdisjoint(file.parents)]


def folder_called(path: Path, suffixes: Collection[str]) -> Path | None:
    """A folder that is called as a file should be, with any of some suffixes; None for none."""
    there = sorted(path.parent.iterdir()) if path.parent.is_dir() else []
    alike = (one for one in there if folded(one.stem) == folded(path.stem) and one.suffix.lower() in suffixes)
    return next((one for one in alike if one.is_dir()), None)


def within(folder: Path, path: Path) -> str:
    """A file of a folder as notes and patterns have it, whatever the system: its path in the folder, with slashes."""
    return one_form(path.relative_to(folder).as_posix())


def readings(stem: str) -> Iterator[Parts]:
    """The ways to take ``smile.normal.1002`` or ``smile_u1_v1`` apart, from the longest name of an expression on."""
    yield Parts(stem)
    behind = _TILE_BEHIND.search(stem)
    shorter = [(stem, "")]
    if behind and behind.start():
        shorter.append((stem[: behind.start()], behind["tile"]))
        yield Parts(shorter[1][0], "", shorter[1][1])
    for name, tile in shorter:
        found = _MAP_BEHIND.search(name)
        if found and found.start():
            yield Parts(name[: found.start()], found["map"].lower(), tile)


def are_sizes(written: Iterable[str]) -> bool:
    """Whether what looks like tiles, of all images of a character, is their size: where it is that, and no other."""
    return {*written} - {""} == {ALSO_A_SIZE}


def first_tile(written: Iterable[str]) -> int:
    """What a program calls the first column and row: 0 where any is called so, else 1."""
    return min([1, *(int(number) for tile in written if not tile.isdigit() for number in re.findall(r"\d+", tile))])


def tile_number(written: str, first: int) -> int:
    """The UDIM number of a tile as it is written; ``first`` is that of :func:`first_tile`.

    Raises
    ------
    ValueError
        UDIM has no number for it.
    """
    if not written or written.isdigit():
        return int(written or FIRST_TILE)
    column, row = (int(number) - first for number in re.findall(r"\d+", written))
    number = FIRST_TILE + column + 10 * row
    if not 0 <= column < 10 or number > LAST_TILE:
        raise ValueError(f"'{written}' is no tile: UDIM has ten columns, and numbers from {FIRST_TILE} to {LAST_TILE}")
    return number


def is_like_a_mask(stem: str) -> bool:
    """Whether people would call a mask so."""
    return _MASK_LIKE.search(folded(stem)) is not None


def is_at_rest(name: str) -> bool:
    """Whether programs call a face at rest so; digits around it do not count."""
    core = _core(_words(name))
    return any(core in calls for calls in _AT_REST)


def at_rest(names: Collection[str]) -> list[str]:
    """Those of a character's meshes that are called as the neutral is, where none is called ``neutral``.

    Digits around a name do not count, nor words that all names begin or end with: ``000_neutral``, ``ada_base``.
    """
    words = [_words(name) for name in names]
    begin, end = _shared(words), _shared([each[::-1] for each in words])
    cores = [{_core(each), _core(each[begin : len(each) - end])} for each in words]
    for calls in _AT_REST:
        found = [name for name, core in zip(names, cores, strict=True) if core & calls]
        if found:
            return found
    return []


def _words(name: str) -> list[str]:
    return re.findall(r"[^\W_]+", folded(name))


def _shared(words: list[list[str]]) -> int:
    """How many words all begin with."""
    alike = (len({*each}) == 1 for each in zip(*words, strict=False))
    return sum(takewhile(bool, alike)) if len(words) > 1 else 0


def _core(words: list[str]) -> str:
    return re.sub(r"^\d+|\d+$", "", "".join(words))
