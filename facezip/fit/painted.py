"""Weight maps that an artist painted: they stay byte for byte, and the rest is fitted around them.

All weights of a slot on a tile share a range in a pack. Where one of its maps is painted, that is such that a byte b of
128 is no weight at all, and 255 the slot's unit u::

    W = (b - 128) / 127 · u            where weights are not negative:  W = b / 255 · u

The unit is free, since textures are fitted to it. It is the least that holds the weights of a fit without painted maps,
which is the start; so the same fit's own maps (:func:`as_painted`), given back, change nothing but their rounding.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facezip.fit.held import Held
from facezip.machine import memory
from facezip.machine.rows import map_rows
from facezip.pack.quantise import STEPS, ZERO, StoredWeights


@dataclass(frozen=True, eq=False)
class Painted:
    """Weight maps of an expression on a tile that stay as they are.

    Attributes
    ----------
    expression, tile : whose they are.
    texels : by slot, ``(h, w)`` uint8.
    """

    expression: str
    tile: int
    texels: Mapping[int, NDArray[np.uint8]]


@dataclass(frozen=True)
class Scale:
    """What the bytes of a slot's weight maps stand for.

    Attributes
    ----------
    unit : u, what a byte of 255 stands for.
    nonnegative : whether a byte of 0, rather than of 128, is no weight.
    """

    unit: np.float32
    nonnegative: bool

    @classmethod
    def of(cls, low: float, high: float, nonnegative: bool) -> "Scale":
        """That of the least unit which holds weights from ``low`` to ``high``."""
        unit = np.float32(high if nonnegative else max(high, -low * STEPS / ZERO))
        return cls(unit if unit > 0 else np.float32(1), nonnegative)

    @property
    def offset(self) -> np.float32:
        """The weight of a byte of 0."""
        return np.float32(0) if self.nonnegative else np.float32(-ZERO / STEPS) * self.unit

    @property
    def span(self) -> np.float32:
        """From there to that of 255."""
        return self.unit if self.nonnegative else np.float32(255 / STEPS) * self.unit

    def weights(self, texels: NDArray[np.uint8]) -> NDArray[np.float32]:
        """What bytes stand for."""
        return texels.astype(np.float32) * (self.span / np.float32(255)) + self.offset

    def texels(self, weights: NDArray[np.float32]) -> NDArray[np.uint8]:
        """The nearest bytes."""
        steps = weights / self.unit * np.float32(255 if self.nonnegative else STEPS)
        return np.rint(np.clip(steps + (0 if self.nonnegative else ZERO), 0, 255)).astype(np.uint8)


def scales_of(painted: Sequence[Painted], weights: NDArray[np.float32], nonnegative: bool) -> dict[int, Scale]:
    """Of each slot of which a map is painted, by the weights ``(h, R, N, w)`` of a fit without."""

    def extents(top: int, bottom: int) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        part = weights[top:bottom]
        return part.min(axis=(0, 2, 3)), part.max(axis=(0, 2, 3))

    parts = map_rows(extents, len(weights))
    low, high = np.min([low for low, _ in parts], axis=0), np.max([high for _, high in parts], axis=0)
    slots = sorted({slot for one in painted for slot in one.texels})
    return {slot: Scale.of(float(low[slot]), float(high[slot]), nonnegative) for slot in slots}


def held_by(
    painted: Sequence[Painted],
    scales: Mapping[int, Scale],
    expressions: Sequence[str],
    shape: tuple[int, ...],
    nonnegative: bool,
) -> Held:
    """What stays of weights of a ``shape`` ``(h, R, N, w)``, and the bounds of the others."""
    where: NDArray[np.bool_] = memory.zeros(shape, np.bool_)
    values: NDArray[np.float32] = memory.zeros(shape, np.float32)
    low = np.full(shape[1:3], 0 if nonnegative else -np.inf, np.float32)
    high = np.full(shape[1:3], np.inf, np.float32)
    for slot, scale in scales.items():
        low[slot], high[slot] = scale.offset, scale.offset + scale.span
    for one in painted:
        n = expressions.index(one.expression)
        for slot, texels in one.texels.items():
            where[:, slot, n], values[:, slot, n] = True, scales[slot].weights(texels)
    return Held(where, values, low, high)


def ranges_of(scales: Mapping[int, Scale], slots: int) -> NDArray[np.float32]:
    """Offset and span ``(2, R)`` in a pack; NaN for slots of which nothing is painted."""
    ranges = np.full((2, slots), np.nan, np.float32)
    for slot, scale in scales.items():
        ranges[:, slot] = scale.offset, scale.span
    return ranges


def as_painted(stored: StoredWeights, nonnegative: bool) -> NDArray[np.uint8]:
    """What the bytes of a tile's weight maps in a pack are as those of painted ones: a table ``(R, 256)``."""
    bytes_ = np.arange(256, dtype=np.float32)
    tables = []
    for offset, span in zip(stored.offset, stored.span, strict=True):
        scale = Scale.of(float(offset), float(offset + span), nonnegative)
        tables.append(scale.texels(bytes_ * (span / np.float32(255)) + offset))
    return np.stack(tables)
