"""The embedded character with all its maps, and on several UDIM tiles."""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import ALBEDO, KNOWN, Key, normals_of
from facezip.character.scans import Character, Stack
from facezip.character.tiles import FIRST_TILE
from facezip.files.images import Texels
from facezip.machine.progress import track
from scenes.character import Person, captures, make_character
from scenes.face.capture import Nuisances, captured
from scenes.face.expressions import expression_weights

MAPS = ("normal", "roughness")


def make_surface(
    resolution: int = 512, expressions: int = 20, seed: int = 0, nuisances: float = 1.0, tiles: tuple[int, int] = (1, 1)
) -> Character:
    """Scans of the embedded character with albedo, normals and roughness of 8 bits, misregistered alike.

    Parameters
    ----------
    resolution, expressions, seed, nuisances : as of :func:`scenes.character.make_character`, whose albedo this is.
    tiles : columns and rows of UDIM tiles that its chart is spread over, at most 10 columns; both divide
        ``resolution``.

    Raises
    ------
    FaceZipError
        ``BAD_VALUE`` for a size or number outside its range.
    """
    albedo = make_character(resolution, expressions, seed, nuisances)
    person = Person.make(resolution, seed)
    named = expression_weights(expressions, seed)
    steady = replace(Nuisances().scaled(nuisances), drift=0.0)
    stacks: dict[str, list[Texels]] = {name: [] for name in MAPS}
    scans = captures(person, named, nuisances)
    for weights, (_, rng) in zip(({}, *named.values()), track(scans, "Making the maps", 1 + len(named)), strict=True):
        skin = person.relief(weights)
        encoded = np.concatenate([(normals_of(skin.slopes) + 1) / 2, skin.roughness], axis=2)
        seen = np.rint(captured(encoded, steady, rng, registered=not weights) * 255)
        vectors = _unit(2 * seen[..., :3] / 255 - 1)
        stacks["normal"].append(np.rint(KNOWN["normal"].encode(vectors) * 65535).astype(np.uint16))
        stacks["roughness"].append(seen[..., 3:].astype(np.uint8))
    found = dict(albedo.stacks)
    for name, stack in stacks.items():
        textures: Any = np.stack(stack[1:])
        found[name, FIRST_TILE] = Stack(stack[0], textures, albedo.first.mask)
    kinds = tuple(KNOWN[name] for name in (ALBEDO, *MAPS))
    return in_tiles(replace(albedo, maps=kinds, stacks=found), *tiles)


def in_tiles(character: Character, columns: int, rows: int) -> Character:
    """A character of one tile, its chart cut into a grid of UDIM tiles, each with its part of the texels."""
    if (columns, rows) == (1, 1):
        return character
    layout = character.meshes.topology
    topology = replace(layout, uv=layout.uv * np.array([columns, rows], np.float32))
    stacks: dict[Key, Stack] = {}
    for row in range(rows):
        for column in range(columns):
            tile = FIRST_TILE + column + 10 * row
            stacks |= {
                (name, tile): _cut(stack, column, row, columns, rows) for (name, _), stack in character.stacks.items()
            }
    return replace(character, meshes=replace(character.meshes, topology=topology), stacks=stacks)


def _cut(stack: Stack, column: int, row: int, columns: int, rows: int) -> Stack:
    height, width = stack.resolution[0] // rows, stack.resolution[1] // columns
    # Row 0 of a texture is its top, tiles count from below.
    down, across = slice((rows - 1 - row) * height, (rows - row) * height), slice(column * width, (column + 1) * width)
    mask = None if stack.mask is None else stack.mask[down, across]
    return Stack(stack.neutral[down, across], stack.textures[:, down, across], mask)


def _unit(vectors: NDArray[np.float64]) -> NDArray[np.float32]:
    length = np.sqrt(np.square(vectors).sum(axis=2, keepdims=True))
    return (vectors / np.maximum(length, 1e-6)).astype(np.float32)
