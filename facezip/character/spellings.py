"""Names of textures as other programs write them: whose they are, and by the words around that name of which map.

A name of a mesh is looked for in the name of every texture, or in that of its folder. What stands around it is a
pattern, such as ``T_{name}_N.{tile}``, and all textures of a map share one. So where a name can be taken apart in
two ways (``Jaw_N`` is a normal of ``Jaw``, or of an expression ``Jaw_N``) that pattern is right which more meshes have.
"""

import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import PurePosixPath

from facezip.character.filenames import ALSO_A_SIZE, TILE
from facezip.character.map_words import MapWord, meant, meant_by_folder, other_space, says_nothing
from facezip.character.maps import ALBEDO
from facezip.character.scans import NEUTRAL
from facezip.names import folded

Words = tuple[str, ...]

_WORD = re.compile(r"[^._ \-]+")
_TILE = re.compile(rf"(?<![^._ \-])(?:{TILE})(?![^._ \-])", re.IGNORECASE)


@dataclass(frozen=True)
class Reading:
    """One way to take the path of a texture apart.

    Attributes
    ----------
    owner : the mesh that it is of.
    pattern : the path without its suffix, with ``{name}`` and ``{tile}``.
    words : what the file is called besides, in small letters; ``before`` of them stand before the name.
    folder : what the nearest folder is called that has not that name, likewise; nothing where there is none.
    tile : as it is written; "" where none is said.
    """

    owner: str
    pattern: str
    words: Words
    before: int
    folder: Words
    tile: str

    @property
    def like(self) -> str:
        """What patterns are compared as."""
        return folded(self.pattern)

    @property
    def says(self) -> MapWord | None:
        """The map that the file's own words mean, or else the folder's; None where they mean none."""
        return _said(self.words[: self.before], self.words[self.before :], self.folder)

    @property
    def space(self) -> Words:
        """Those of the words that state a colour space in which files are not read."""
        return _space(self.words[: self.before], self.words[self.before :], self.folder)

    def without_tile(self) -> "Reading":
        """The same, with what looked like a tile as a part of the name that says nothing."""
        return replace(self, pattern=self.pattern.replace("{tile}", self.tile), tile="")


class Ambiguous(ValueError):
    """A name that can be taken apart in two ways, in words."""


def words_of(text: str) -> Words:
    """The words of a name, as they are compared: what joins them does not count."""
    return tuple(folded(word) for word in _WORD.findall(text))


def called(meshes: Mapping[str, str]) -> dict[Words, str]:
    """By the words of their names the meshes, given as owners by stem; also without words that all of them share."""
    words = {stem: words_of(stem) for stem in meshes}
    begin, end = _shared([*words.values()]), _shared([each[::-1] for each in words.values()])
    cores = {each[begin : len(each) - end]: meshes[stem] for stem, each in words.items()}
    named = {(NEUTRAL,): NEUTRAL} | {each: meshes[stem] for stem, each in words.items()}
    return ({core: owner for core, owner in cores.items() if core} if len(meshes) > 1 else {}) | named


def readings_of(path: str, names: Mapping[Words, str]) -> Iterator[Reading]:
    """The ways to take the path of a texture, with slashes, apart, by the names of meshes (:func:`called`)."""
    *folders, file = PurePosixPath(path).parts
    stem = PurePosixPath(file).stem
    spans = [match.span() for match in _WORD.finditer(stem)]
    found = False
    for start in range(len(spans)):
        for stop in range(start + 1, len(spans) + 1):
            begin, end = spans[start][0], spans[stop - 1][1]
            owner = names.get(words_of(stem[begin:end]))
            if owner is not None:
                found = True
                yield _reading(owner, folders, names, stem[:begin], stem[end:])
    if not found:
        for owner in dict.fromkeys(names[words_of(part)] for part in folders if words_of(part) in names):
            yield _reading(owner, folders, names, None, stem)


def _reading(
    owner: str, folders: Sequence[str], names: Mapping[Words, str], before: str | None, behind: str
) -> Reading:
    """That of a name with something before and behind it; ``before`` is None where the file's folder alone has it."""
    places = ["{name}" if names.get(words_of(part)) == owner else part for part in folders]
    tile = _tile_in(behind)
    rest = behind if tile is None else f"{behind[: tile.start()]}{{tile}}{behind[tile.end() :]}"
    pattern = "/".join([*places, rest if before is None else f"{before}{{name}}{rest}"])
    first, last = words_of(before or ""), words_of(rest.replace("{tile}", ""))
    folder = words_of(next((part for part in reversed(places) if part != "{name}"), ""))
    return Reading(owner, pattern, (*first, *last), len(first), folder, tile[0] if tile else "")


def _tile_in(behind: str) -> re.Match[str] | None:
    """The tile behind a name, the last of what may be one; what is also a size is that beside another."""
    found = sorted(_TILE.finditer(behind), key=lambda match: (match[0] != ALSO_A_SIZE, match.start()))
    return found[-1] if found else None


def _shared(words: Sequence[Words]) -> int:
    """How many words all begin with."""
    count = 0
    for each in zip(*words, strict=False):
        if len({*each}) > 1:
            break
        count += 1
    return count


def _space(first: Words, last: Words, folder: Words) -> Words:
    # Before a name, Lin is a person.
    return (*(word for word in other_space(first) if word != "lin"), *other_space(last), *other_space(folder))


def _said(first: Words, last: Words, folder: Words) -> MapWord | None:
    """What words before and behind a name mean, and those of its folder; None for colours of another space."""
    space = _space(first, last, folder)
    if space:
        # Data have none.
        first, last, folder = (tuple(word for word in words if word not in space) for words in (first, last, folder))
        said = _said(first, last, folder)
        return None if said is None or said.map == ALBEDO else said
    if says_nothing((*first, *last)):
        return meant_by_folder(folder)
    # A letter before a name is no custom: 'T' of Unreal, or somebody's initials.
    if any(len(word) == 1 and not says_nothing((word,)) for word in first):
        return None
    return meant((*first, *last))


def chosen(readings: Mapping[str, Sequence[Reading]]) -> dict[str, Reading]:
    """For each path the reading whose pattern most meshes have.

    Raises
    ------
    Ambiguous
        Two patterns have equally many, and both mean a map.
    """
    owners: dict[str, set[str]] = {}
    for some in readings.values():
        for reading in some:
            owners.setdefault(reading.like, set()).add(reading.owner)
    found = {}
    for path, some in readings.items():
        if some:
            found[path] = _best(path, some, owners)
    return found


def _best(path: str, some: Sequence[Reading], owners: Mapping[str, Collection[str]]) -> Reading:
    ranks = [(len(owners[each.like]), each.says is not None) for each in some]
    best = [each for each, rank in zip(some, ranks, strict=True) if rank == max(ranks)]
    if len({(each.owner, each.like) for each in best}) > 1:
        ways = " or ".join(f"'{each.pattern}' of '{each.owner}'" for each in best[:3])
        raise Ambiguous(f"{path} may be {ways}, and as many textures are called in either way")
    return best[0]


def meanings(readings: Iterable[Reading]) -> dict[str, MapWord | None]:
    """What each pattern means, by :attr:`Reading.like`; words that all have, such as a person's name, do not count."""
    patterns = {each.like: each for each in readings}
    shared = _in_all([{*each.words} - {*each.space} for each in patterns.values()])
    without = {like: _without(each, shared) for like, each in patterns.items()}
    # One of them has to be called by a map's name for that: otherwise the word that all have may be one.
    telling = any(says is not None and words for words, says in without.values())
    return {like: each.says or (without[like][1] if telling else None) for like, each in patterns.items()}


def _in_all(words: Sequence[set[str]]) -> set[str]:
    return {word for word in set.intersection(*words) if meant((word,)) is None} if words else set()


def _without(reading: Reading, shared: Collection[str]) -> tuple[Words, MapWord | None]:
    first, last = (
        tuple(word for word in words if word not in shared)
        for words in (reading.words[: reading.before], reading.words[reading.before :])
    )
    telling = tuple(word for word in (*first, *last) if not says_nothing((word,)))
    return telling, _said(first, last, reading.folder)
