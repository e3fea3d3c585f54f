"""Which textures and meshes are copies of another expression's: a file that was saved over another reads as any."""

from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import ALBEDO, Key
from facezip.character.notes import Note
from facezip.character.scans import NEUTRAL, Character, Stack

# Every so many of the means a side are compared first.
STEP = 4

# Of each copy, by name, what it is a copy of.
Copies = dict[str, str]


class Known:
    """The textures of a stack that were seen, the neutral first: two are compared whole where their means agree.

    Parameters
    ----------
    stack : which.
    neutral : the means of blocks of the neutral's texels.
    """

    def __init__(self, stack: Stack, neutral: NDArray[np.float32]) -> None:
        self._seen = {_sample(neutral): [(NEUTRAL, stack.neutral)]}
        self._stack = stack
        self.copies: Copies = {}

    def add(self, n: int, name: str, means: NDArray[np.float32]) -> None:
        """Look at an expression's texture, with the means of the same blocks."""
        texture = self._stack.textures[n]
        alike = self._seen.setdefault(_sample(means), [])
        # By rows, as they may live in a file.
        of = next((of for of, other in alike if all(map(np.array_equal, other, texture))), None)
        if of is None:
            alike.append((name, texture))
        else:
            self.copies[name] = of


def notes_on_meshes(character: Character) -> Iterator[Note]:
    """Notes on meshes that are another's; none where textures alone tell expressions apart."""
    meshes = character.meshes
    seen, copies = {meshes.neutral.tobytes(): NEUTRAL}, Copies()
    for name, vertices in zip(character.expressions, meshes.vertices, strict=True):
        of = seen.setdefault(vertices.tobytes(), name)
        if of != name:
            copies[name] = of
    if set(copies.values()) != {NEUTRAL} or len(copies) < len(character.expressions):
        for name, of in copies.items():
            whose = "the neutral's" if of == NEUTRAL else f"that of '{of}'"
            yield Note(name, f"its mesh is {whose}, vertex for vertex; is it the right file?", asks=True)


def notes_on(character: Character, copies: Mapping[Key, Copies]) -> tuple[Note, ...]:
    """Notes on copies by map and tile.

    A map need not change on every tile, or be one for all expressions. So what is the neutral's is noted where it is
    the albedo on all tiles, and a map that all expressions share is not.
    """
    found = list[Note]()
    for (map, tile), some in copies.items():
        where = f"{map} on tile {tile}" if len(character.tiles) > 1 else map
        is_shared = len(some) == len(character.expressions) - 1 and len({*some.values()}) == 1
        if map == ALBEDO or not is_shared:
            found += (_note(name, where, f"that of '{of}'") for name, of in some.items() if of != NEUTRAL)
    albedo = [some for (map, _), some in copies.items() if map == ALBEDO]
    still = [name for name in character.expressions if albedo and all(some.get(name) == NEUTRAL for some in albedo)]
    return (*found, *(_note(name, ALBEDO, "the neutral's") for name in still))


def _note(name: str, where: str, of: str) -> Note:
    return Note(name, f"its {where} is {of}, texel for texel; is it the right file?", asks=True)


def _sample(means: NDArray[np.float32]) -> bytes:
    return means[::STEP, ::STEP].tobytes()
