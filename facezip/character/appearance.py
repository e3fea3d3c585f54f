"""What scans show that headers do not say: a texture of an expression that is empty, a copy, or turned against the
neutral's; a mesh that is a copy, or inside out; a mask that is inverted.

They are read, and compressed, as any others. So they are asked about.
"""

from collections.abc import Container, Iterator

import numpy as np
from numpy.typing import NDArray

from facezip.character import features
from facezip.character.copies import Copies, Known, notes_on, notes_on_meshes
from facezip.character.displacement import DARK, reduced
from facezip.character.maps import ALBEDO, Key
from facezip.character.masks import is_swapped
from facezip.character.notes import Note
from facezip.character.scans import Character, Stack
from facezip.character.winding import notes_on_winding

# Of the range of texels: means of blocks that differ by less are one value.
ONE_VALUE = 1 / 1024
# Normals that correlate so far below zero are turned over: those of the embedded heads have 0.49 and more.
OPPOSITE = 0.3
# As high a share of it at most is black.
BLACK = 1 / 255


def seen(character: Character, placeholders: Container[tuple[str, Key]] = ()) -> tuple[Note, ...]:
    """Notes on masks, meshes, and the textures of expressions.

    Of textures there are none where the neutral is of one value.

    Parameters
    ----------
    character : whose.
    placeholders : the textures, by expression and key, of which it is said already that they are of one value.
    """
    copies: dict[Key, Copies] = {}
    found = [
        note
        for key, stack in character.stacks.items()
        for note in _of_stack(character, key, stack, placeholders, copies)
    ]
    of_meshes = (*notes_on_winding(character), *notes_on_meshes(character))
    return (*_of_masks(character), *of_meshes, *found, *notes_on(character, copies))


def _of_masks(character: Character) -> Iterator[Note]:
    for (map, tile), stack in character.stacks.items():
        if map == ALBEDO and stack.mask is not None and is_swapped(character.chart(tile), stack.mask):
            mask = f"mask on tile {tile}" if len(character.tiles) > 1 else "mask"
            words = f"its {mask} is white beside the mesh and mostly black on it; invert it, so that the face is white"
            yield Note(character.name, words, asks=True)


def _of_stack(
    character: Character,
    key: Key,
    stack: Stack,
    placeholders: Container[tuple[str, Key]],
    copies: dict[Key, Copies],
) -> Iterator[Note]:
    factor = -(-max(stack.resolution) // features.SIDE)
    neutral = _small(stack.neutral, stack.scale, factor)
    if np.ptp(neutral) < ONE_VALUE:
        return
    known = Known(stack, neutral)
    copies[key] = known.copies
    map, tile = key
    where = f"{map} on tile {tile}" if len(character.tiles) > 1 else map
    for n, name in enumerate(character.expressions):
        other = _small(stack.textures[n], stack.scale, factor)
        if np.ptp(other) < ONE_VALUE:
            if (name, key) not in placeholders:
                colour = "black" if map == ALBEDO and other.max() <= BLACK else "of one value"
                words = f"its {where} is {colour} everywhere, and the neutral's is not; is it the right file?"
                yield Note(name, words, asks=True)
            continue
        known.add(n, name, other)
        if map == ALBEDO and (how := features.turned(*(np.log(each + DARK) for each in (neutral, other)))):
            words = f"its {where} is {how} against the neutral's; turn the image, or export it again"
            yield Note(name, words, asks=True)
        if character.kind(map).is_normal and (flipped := _flipped(stack.neutral, stack.textures[n], factor)):
            words = (
                f"its {where} has {flipped} the other way than the neutral's; bake both for OpenGL, or both for DirectX"
            )
            yield Note(name, words, asks=True)


def _flipped(neutral: NDArray[np.generic], other: NDArray[np.generic], step: int) -> str:
    """Which channels of a normal map go the other way than the neutral's, whose pores and wrinkles it shares."""
    found = []
    for channel, colour in enumerate(("red", "green")):
        one, two = (texels[::step, ::step, channel].astype(np.float64) for texels in (neutral, other))
        one, two = one - one.mean(), two - two.mean()
        if (one * two).sum() < -OPPOSITE * np.sqrt(np.square(one).sum() * np.square(two).sum()):
            found.append(colour)
    return " and ".join(found)


def _small(texels: NDArray[np.generic], scale: np.float32, factor: int) -> NDArray[np.float32]:
    """Means over channels and blocks of texels, in [0, 1]."""
    values: NDArray[np.float32] = reduced(np.ascontiguousarray(texels), factor) * scale
    return values
