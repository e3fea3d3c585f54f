"""What scans show at every texel of a weight map: how much their changes have in common, place by place."""

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from facezip.character.scans import Character, Stack
from facezip.machine.kernels import kernel
from facezip.machine.rows import sum_rows

# So many texels a side of a cell are enough to know its products.
SIDE = 4


class Agreement:
    """Products of scans' changes I_n - I_0 on a tile, over all its maps.

    Each map's changes count alike in sum, as in the fit.
    """

    def __init__(self, character: Character, tile: int, size: tuple[int, int], energies: Mapping[str, float]) -> None:
        self._stacks = [character.stacks[kind.name, tile] for kind in character.maps]
        self._factors = [1 / energies[kind.name] for kind in character.maps]
        self._size = size

    @property
    def least(self) -> float:
        """The least variance that noise can have, > 0: of both textures' rounding."""
        steps = [0.0 if stack.neutral.dtype.kind == "f" else float(stack.scale) for stack in self._stacks]
        rounding = sum(factor * step**2 / 6 for factor, step in zip(self._factors, steps, strict=True))
        return max(float(rounding), float(np.finfo(np.float32).tiny))

    def rows(self, top: int, bottom: int) -> NDArray[np.float64]:
        """``(rows, w, N, N)``: means over the values of a texel's footprint."""
        count = len(self._stacks[0].textures)
        total = np.zeros((bottom - top, self._size[1], count, count))
        for stack, factor in zip(self._stacks, self._factors, strict=True):
            found = np.zeros_like(total)
            _multiply(top, bottom, self._size[0], stack.textures, stack.neutral, float(stack.scale), found)
            total += factor * found
        return total


def energies(character: Character) -> dict[str, float]:
    """By map, the mean square of all scans' changes: what one value's change counts is its inverse."""
    found = {}
    for kind in character.maps:
        stacks = character.of_map(kind.name).values()
        total = sum(float(sum_rows(_squares(stack), stack.resolution[0])) for stack in stacks)
        count = sum(stack.textures.size for stack in stacks)
        found[kind.name] = max(total / count, float(np.finfo(np.float32).tiny))
    return found


def _squares(stack: Stack) -> Callable[[int, int], NDArray[np.float64]]:
    return lambda top, bottom: np.array(_energy(top, bottom, stack.textures, stack.neutral, stack.scale))


@kernel()
def _energy(top: int, bottom: int, textures: NDArray[np.uint8], neutral: NDArray[np.uint8], scale: np.float32) -> float:
    total = np.float64(0)
    for n in range(len(textures)):
        for y in range(top, bottom):
            row = np.float32(0)
            for x in range(neutral.shape[1]):
                for c in range(neutral.shape[2]):
                    change = scale * (np.float32(textures[n, y, x, c]) - np.float32(neutral[y, x, c]))
                    row += change * change
            total += row
    return float(total)


@kernel()
def _multiply(
    top: int,
    bottom: int,
    rows: int,
    textures: NDArray[np.uint8],
    neutral: NDArray[np.uint8],
    scale: float,
    found: NDArray[np.float64],
) -> None:
    count, height, width, channels = textures.shape
    columns = found.shape[1]
    change = np.empty(count)
    for row in range(top, bottom):
        above, below = row * height // rows, max((row + 1) * height // rows, row * height // rows + 1)
        down = max((below - above) // SIDE, 1)
        for column in range(columns):
            left = column * width // columns
            right = max((column + 1) * width // columns, left + 1)
            across = max((right - left) // SIDE, 1)
            cell = found[row - top, column]
            values = 0
            for y in range(above + down // 2, below, down):
                for x in range(left + across // 2, right, across):
                    for c in range(channels):
                        values += 1
                        still = float(neutral[y, x, c])
                        for n in range(count):
                            change[n] = scale * (float(textures[n, y, x, c]) - still)
                        for n in range(count):
                            for m in range(n + 1):
                                cell[n, m] += change[n] * change[m]
            for n in range(count):
                for m in range(n + 1):
                    cell[n, m] /= values
                    cell[m, n] = cell[n, m]
