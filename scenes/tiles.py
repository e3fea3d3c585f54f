"""A character whose chart is spread over several UDIM tiles."""

from dataclasses import replace

import numpy as np

from facezip.character.maps import Key
from facezip.character.scans import Character, Stack
from facezip.character.tiles import FIRST_TILE


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
