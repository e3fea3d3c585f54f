"""Alternations of what moves: first all weights, then those where a fit gains most, under Nesterov's momentum.

Much of what a fit of scans can gain lies in few places, such as about the eyes and the mouth, and goes on long after
all others are as good as they will be. So after a few alternations each takes only those tiles of weight texels that
gained most when they were last taken (Southwell's rule; Nutini et al., Coordinate Descent Converges Faster with the
Gauss-Southwell Rule Than Random Selection, 2015). Others come to the front as soon as what those gain has fallen below
what they did.

A tile has a momentum of its own, which is forgotten where it led past the goal: where the error falls back the way it
came (O'Donoghue & Candès, Adaptive Restart for Accelerated Gradient Schemes, 2015, the gradient scheme).
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.fit.nonnegative import Limits
from facezip.fit.weights import Moves
from facezip.machine.kernels import kernel
from facezip.machine.rows import by_rows, map_rows

# Weight texels of a tile each way: as many as make so many tiles of a map, and few texels beside a tile to look at.
ACROSS = 16
LEAST = 4
# Of tiles, that an alternation takes once all have been taken so many times; of few tiles it takes all.
SHARE = 0.4
WHOLE = 3
MANY = 64
# So many of those for each further alternation that was asked for: they take twice its time, since neighbours of tiles
# have to be looked at too, and gain more than two of all texels.
EACH = 4


def tile_of(shape: tuple[int, ...]) -> int:
    """The side of a tile of weights ``(h, R, N, w)``."""
    return max(LEAST, -(-max(shape[0], shape[3]) // ACROSS))


class Descent:
    """Weights on their way to the least error.

    Attributes
    ----------
    weights : ``(h, R, N, w)``, changed in place.
    """

    def __init__(self, start: NDArray[np.float32], limits: Limits | None = None, choosing: bool = True) -> None:
        """``limits`` bound where momentum leads; what is held has none. Not ``choosing``, all weights always move."""
        self.weights = by_rows(lambda rows: start[rows], start.shape, np.float32)
        self._before = by_rows(lambda rows: start[rows], start.shape, np.float32)
        high = np.full(start.shape[1:3], np.inf, np.float32)
        bounds = (-high, high) if limits is None else (limits.low, limits.high)
        self._bounds = np.ascontiguousarray(bounds[0]), np.ascontiguousarray(bounds[1])
        self._tile = tile_of(start.shape)
        tiles = -(-len(start) // self._tile), -(-start.shape[3] // self._tile)
        self._ages, self._gains = np.zeros(tiles, np.float32), np.zeros(tiles)
        self._chooses, self._taken_whole = choosing and self._gains.size >= MANY, 0

    def steps(self, alternations: int) -> int:
        """How many calls of :meth:`ahead` stand for so many alternations of all texels."""
        if not self._chooses or alternations <= WHOLE:
            return alternations
        return WHOLE + EACH * (alternations - WHOLE)

    def ahead(self) -> Moves:
        """Choose tiles and follow their momentum; where weights may now be improved."""
        moving = self._spread(self._taken())
        momentum = self._spread(self._ages / (self._ages + 2))
        map_rows(lambda top, bottom: self._follow(top, bottom, moving, momentum), len(moving))
        return Moves.of(moving, self._before)

    def settle(self, moves: Moves) -> None:
        """Take notice of what was gained."""
        taken = moves.moving[:: self._tile, :: self._tile]
        past = self._by_tile(moves.along) < 0
        self._ages[taken] = np.where(past, 0, self._ages + 1)[taken]
        self._gains[taken] = self._by_tile(moves.gains)[taken]

    def _taken(self) -> NDArray[np.bool_]:
        if not self._chooses or self._taken_whole < WHOLE:
            self._taken_whole += 1
            return np.ones(self._gains.shape, np.bool_)
        first = np.argsort(-self._gains, axis=None, kind="stable")[: int(SHARE * self._gains.size)]
        taken = np.zeros(self._gains.shape, np.bool_)
        taken.flat[first] = True
        return taken

    def _follow(self, top: int, bottom: int, moving: NDArray[np.bool_], momentum: NDArray[np.float32]) -> None:
        _follow(top, bottom, moving, momentum, *self._bounds, self.weights, self._before)

    def _spread(self, tiles: NDArray[Any]) -> NDArray[Any]:
        h, w = len(self.weights), self.weights.shape[3]
        return np.ascontiguousarray(tiles.repeat(self._tile, axis=0).repeat(self._tile, axis=1)[:h, :w])

    def _by_tile(self, texels: NDArray[np.float32]) -> NDArray[np.float64]:
        rows = np.add.reduceat(texels, np.arange(0, len(texels), self._tile), axis=0, dtype=np.float64)
        return np.add.reduceat(rows, np.arange(0, rows.shape[1], self._tile), axis=1)


@kernel()
def _follow(
    top: int,
    bottom: int,
    moving: NDArray[np.bool_],
    momentum: NDArray[np.float32],
    low: NDArray[np.float32],
    high: NDArray[np.float32],
    weights: NDArray[np.float32],
    before: NDArray[np.float32],
) -> None:
    """``W + μ (W - before)`` of what moves, within bounds; W is what was before."""
    _, slots, count, w = weights.shape
    for y in range(top, bottom):
        if moving[y].any():
            for i in range(slots):
                for n in range(count):
                    for x in range(w):
                        here = weights[y, i, n, x]
                        step = momentum[y, x] * (here - before[y, i, n, x])
                        if moving[y, x] and step != 0:
                            weights[y, i, n, x] = min(max(here + step, low[i, n]), high[i, n])
                        if moving[y, x]:
                            before[y, i, n, x] = here
