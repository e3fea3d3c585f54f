"""One character at several texture sizes: halved by a box filter, never enlarged; the first tile's width names them."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from facezip.character.scans import Character, Stack
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.images import Texels

SMALLEST = 256


def widths_of(character: Character, wanted: Sequence[int] = ()) -> list[int]:
    """Widths at which a character can be had, largest first: its own, and every half of it down to 256 texels.

    Parameters
    ----------
    character : the scans.
    wanted : widths in texels to which the answer is limited, smaller ones too; no limit where empty.

    Raises
    ------
    FaceZipError
        ``BAD_VALUE`` for a width that halving does not reach.
    """
    width, count = character.first.resolution[1], _halvings(character, min((SMALLEST, *wanted)))
    widths = [width >> step for step in range(count + 1)]
    unreachable = [width for width in wanted if width not in widths]
    if unreachable:
        raise FaceZipError(
            ErrorCode.BAD_VALUE,
            f"--resolution {unreachable[0]}: textures of {character.name} are halved, never enlarged; "
            f"choose from {', '.join(map(str, widths))}",
        )
    return [width for width in widths if width in wanted] if wanted else widths


def at_widths(character: Character, widths: Sequence[int]) -> Iterator[Character]:
    """The character at each of the widths that :func:`widths_of` gave, one after the other."""
    for width in widths:
        while character.first.resolution[1] > width:
            character = halved(character)
        yield character


def reduced(character: Character, most: int) -> Character:
    """The character halved until no side is longer than ``most`` texels, or until a side is odd."""
    for _ in range(_halvings(character, 1)):
        if max(max(size) for size in _sizes(character)) <= most:
            break
        character = halved(character)
    return character


def halved(character: Character) -> Character:
    """Textures and masks at half the size, each texel the mean of four encoded ones; sides must be even."""
    stacks = {
        key: Stack(
            _halved(stack.neutral),
            _halved(stack.textures),
            None if stack.mask is None else _means(stack.mask[:, :, None])[:, :, 0],
        )
        for key, stack in character.stacks.items()
    }
    return replace(character, stacks=stacks)


def _halvings(character: Character, smallest: int) -> int:
    """How often all textures can be halved: sides stay whole, and the first tile's width not below ``smallest``."""
    sides, count = [side for size in _sizes(character) for side in size], 0
    while not any(side >> count & 1 for side in sides) and character.first.resolution[1] >> count + 1 >= smallest:
        count += 1
    return count


def _sizes(character: Character) -> list[tuple[int, int]]:
    return [stack.resolution for stack in character.stacks.values()]


def _halved(texels: Texels) -> Texels:
    """``(..., H, W, C)`` at half the size, of the same type; a texture at a time, for the memory."""
    *count, height, width, channels = texels.shape
    out: Texels = np.empty((*count, height // 2, width // 2, channels), texels.dtype)
    for index in np.ndindex(*count):
        means = _means(texels[index])
        out[index] = means if out.dtype.kind == "f" else np.rint(means)
    return out


def _means(texels: Texels) -> NDArray[np.float32]:
    height, width, channels = texels.shape
    blocks = texels.reshape(height // 2, 2, width // 2, 2, channels)
    means: NDArray[np.float32] = blocks.mean(axis=(1, 3), dtype=np.float32)
    return means
