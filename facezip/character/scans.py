"""A character: one neutral and N expressions, with every map on every UDIM tile."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from facezip.character.facts import CharacterFacts, MapName
from facezip.character.maps import ALBEDO, Key, Map
from facezip.character.meshes import Meshes
from facezip.character.neutrals import neutral_bits
from facezip.character.notes import Note, lines
from facezip.character.tiles import shifted
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.images import Texels
from facezip.files.obj import Topology
from facezip.machine.rows import by_rows
from facezip.names import MAX_CHARACTERS, first_unusable, folded, one_form

NEUTRAL = "neutral"
MAX_EXPRESSIONS = 4096
# Expressions that a fit needs: one alone is a difference texture, and has no weights.
FEWEST = 2


@dataclass(frozen=True, eq=False)
class Stack:
    """One map on one tile, as texels (:class:`facezip.character.maps.Map` says what they stand for).

    Attributes
    ----------
    neutral : ``(H, W, C)`` uint8, uint16, or float32 in [0, 1].
    textures : ``(N, H, W, C)`` of the same type.
    mask : ``(H, W)`` float32 in [0, 1], the face region and weight of errors; None for the whole texture.
    """

    neutral: Texels
    textures: Texels
    mask: NDArray[np.float32] | None = None

    @property
    def resolution(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.neutral.shape[0], self.neutral.shape[1]

    @property
    def channels(self) -> int:
        """C, of a texel."""
        return int(self.neutral.shape[2])

    @property
    def weight(self) -> NDArray[np.float32]:
        """``(H, W)`` float32: the mask, or 1 everywhere."""
        one = np.ones(1, np.float32)
        return by_rows(lambda _: one, self.resolution, np.float32) if self.mask is None else self.mask

    @property
    def scale(self) -> np.float32:
        """Factor from stored texels to values in [0, 1]."""
        dtype = self.neutral.dtype
        return np.float32(1 if dtype.kind == "f" else 1 / np.iinfo(str(dtype)).max)


@dataclass(frozen=True, eq=False)
class Character:
    """The scans of one person.

    Attributes
    ----------
    name : what reports call the character.
    expressions : the N names, without the neutral.
    meshes : the geometry, whose UV layout spans all tiles.
    maps : the kinds of maps, albedo first.
    stacks : the texels by map and tile.
    notes : what its files say that is not ordinary, and what was done about it.
    """

    name: str
    expressions: tuple[str, ...]
    meshes: Meshes
    maps: tuple[Map, ...]
    stacks: Mapping[Key, Stack]
    notes: tuple[Note, ...] = ()

    def __post_init__(self) -> None:
        """Names are kept in one Unicode form, whoever makes a character."""
        object.__setattr__(self, "expressions", tuple(map(one_form, self.expressions)))

    @property
    def tiles(self) -> tuple[int, ...]:
        """UDIM numbers, ascending."""
        return tuple(sorted({tile for _, tile in self.stacks}))

    @property
    def first(self) -> Stack:
        """The first map on the first tile: its size stands for the character's where one size is asked for."""
        return self.stacks[self.maps[0].name, self.tiles[0]]

    @property
    def masked(self) -> bool:
        """Whether a mask limits the face region."""
        return any(stack.mask is not None for stack in self.stacks.values())

    @property
    def facts(self) -> CharacterFacts:
        """Name, expressions, maps, tiles and sizes, as documents state them."""
        return CharacterFacts(
            name=self.name,
            expressions=self.expressions,
            resolution=self.first.resolution,
            channels=self.first.channels,
            vertices=len(self.meshes.neutral),
            triangles=len(self.meshes.topology.faces),
            maps=[MapName(name=kind.name, encoding=kind.encoding) for kind in self.maps],
            tiles=self.tiles,
            notes=lines(self.notes),
        )

    @property
    def neutral_bits(self) -> dict[Key, int]:
        """By map and tile, the bits a channel of a stored neutral that keep what its file held: 8 or 16."""
        normal = {kind.name: kind.is_normal for kind in self.maps}
        return {key: neutral_bits(stack.neutral.dtype, normal[key[0]]) for key, stack in self.stacks.items()}

    def kind(self, name: str) -> Map:
        """The map of a name; ``UNKNOWN_NAME`` where there is none."""
        return map_named(name, self.maps, self.name)

    def of_map(self, name: str) -> dict[int, Stack]:
        """A map's texels by tile."""
        return {tile: self.stacks[name, tile] for tile in self.tiles}

    def only(self, *names: str) -> "Character":
        """The same scans with some of their maps."""
        kinds = tuple(kind for kind in self.maps if kind.name in names)
        return replace(self, maps=kinds, stacks={key: stack for key, stack in self.stacks.items() if key[0] in names})

    def chart(self, tile: int) -> Topology:
        """The UV layout with a tile in the unit square."""
        return shifted(self.meshes.topology, tile)

    def texture(self, expression: str, map: str = ALBEDO, tile: int | None = None) -> NDArray[np.float32]:
        """Values of an expression or of ``"neutral"``, float32; of the first tile where none is named.

        Returns
        -------
        ``(H, W, C)`` in [0, 1], encoded, of a colour; values ``(H, W, 1)`` of data; unit vectors ``(H, W, 3)``.

        Raises
        ------
        FaceZipError
            ``UNKNOWN_NAME``: no such expression, map or tile.
        """
        return self.kind(map).decode(self.texels(expression, (map, self.tile(tile))))

    def texels(self, expression: str, key: Key) -> Texels:
        """``(H, W, C)`` as stored of an expression or of ``"neutral"``."""
        stack = self.stacks[key]
        return stack.neutral if expression == NEUTRAL else stack.textures[self.index(expression)]

    def tile(self, tile: int | None) -> int:
        """A tile that is there, the first for None; ``UNKNOWN_NAME`` for any other."""
        return tile_among(tile, self.tiles, self.name)

    def mesh_vertices(self, expression: str) -> NDArray[np.float32]:
        """``(V, 3)`` float32 of an expression or of ``"neutral"``."""
        return self.meshes.neutral if expression == NEUTRAL else self.meshes.vertices[self.index(expression)]

    def index(self, expression: str) -> int:
        """Position of an expression on axis 0, in whatever Unicode form it is typed; ``UNKNOWN_NAME`` for none."""
        expression = one_form(expression)
        if expression not in self.expressions:
            raise unknown("expression", expression, self.expressions, self.name)
        return self.expressions.index(expression)


def map_named(name: str, maps: Iterable[Map], whose: str) -> Map:
    """The map of a name among some; ``UNKNOWN_NAME`` where there is none."""
    by_name = {kind.name: kind for kind in maps}
    if name not in by_name:
        raise unknown("map", name, by_name, whose)
    return by_name[name]


def tile_among(tile: int | None, tiles: tuple[int, ...], whose: str) -> int:
    """A tile among some, the first for None; ``UNKNOWN_NAME`` where there is none."""
    if tile is not None and tile not in tiles:
        raise unknown("tile", tile, tiles, whose)
    return tiles[0] if tile is None else tile


def at_least(fewest: int) -> str:
    """How many expressions there have to be, for people."""
    return f"at least {'two' if fewest == FEWEST else 'one'} besides the neutral"


def unknown(what: str, name: object, known: Iterable[object], whose: str) -> FaceZipError:
    """The error for a name that is none of those that there are."""
    there = ", ".join(map(str, known))
    return FaceZipError(ErrorCode.UNKNOWN_NAME, f"no {what} '{name}' in {whose or 'the pack'}; it has {there}")


def check_names(expressions: tuple[str, ...], whose: str | Path) -> None:
    """Raise ``UNSAFE_NAME`` for the first expression whose name cannot be a file name, before any file bears it."""
    unusable = first_unusable(expressions)
    if unusable is not None:
        alike = next((name for name in expressions if name != unusable and folded(name) == folded(unusable)), None)
        why = f"is that of '{alike}' to many file systems" if alike else "cannot be a file name"
        raise FaceZipError(
            ErrorCode.UNSAFE_NAME, f"{whose}: expression name '{unusable[:MAX_CHARACTERS]}' {why}; rename it"
        )
