"""How well scans show the texture of every shape, as a whole and by regions of each tile: for a record to read."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facezip.rigging.evidence import Estimate

# Regions are squares of a tile, so many a side.
GRID = 4
# A region counts where it has at least this part of what a shape is expected to change.
LEAST = 0.02


@dataclass(frozen=True, kw_only=True)
class Square:
    """A square of a tile.

    Attributes
    ----------
    tile : its UDIM number.
    u, v : from and to, 0..1 of the tile.
    """

    tile: int
    u: tuple[float, float]
    v: tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class Known:
    """How much of a shape's texture is known.

    Attributes
    ----------
    shown : the part of its expected change, in variance, that scans determine: 0 where its texture is the neutral's for
        want of evidence, 1 where it is known.
    uncertainty : the standard deviation of what is left, 0..255 of the albedo.
    """

    shown: float
    uncertainty: float


@dataclass(frozen=True, kw_only=True)
class Region(Square, Known):
    """The same of a square of a tile."""


@dataclass(frozen=True, kw_only=True)
class Shown(Known):
    """The same of a shape.

    Attributes
    ----------
    regions : those in which it changes something.
    """

    regions: Sequence[Region]


Part = tuple[NDArray[np.float64], NDArray[np.float64]]


def shown(estimates: Mapping[int, Estimate], shapes: tuple[str, ...]) -> dict[str, Shown]:
    """By shape how well scans show its texture; nothing where there are no estimates."""
    if not estimates:
        return {}
    return {
        shape: Shown(**vars(_known(*_sums(part for _, part in parts))), regions=_regions(parts))
        for m, shape in enumerate(shapes)
        for parts in [[(square, part) for tile, made in estimates.items() for square, part in _squares(tile, made, m)]]
    }


def _squares(tile: int, made: Estimate, m: int) -> Iterator[tuple[Square, Part]]:
    """Regions, and of their texels a shape's expected variance and the evidence for it."""
    height, width = made.evidence.shape[1:]
    rows, columns = (np.linspace(0, size, GRID + 1).round().astype(int) for size in (height, width))
    for i in range(GRID):
        for j in range(GRID):
            some = (m, slice(rows[i], rows[i + 1]), slice(columns[j], columns[j + 1]))
            # Image row 0 is at v = 1.
            square = Square(tile=tile, u=(j / GRID, (j + 1) / GRID), v=(1 - (i + 1) / GRID, 1 - i / GRID))
            yield square, (np.square(made.expected[some], dtype=np.float64), made.evidence[some].astype(np.float64))


def _sums(parts: Iterator[Part]) -> tuple[float, float, int]:
    """What is expected and what of it is known, summed over texels, and their number."""
    expected = known = 0.0
    texels = 0
    for variance, evidence in parts:
        expected, known = expected + float(variance.sum()), known + float((variance * evidence).sum())
        texels += variance.size
    return expected, known, texels


def _known(expected: float, known: float, texels: int) -> Known:
    left = np.sqrt(max(expected - known, 0.0) / max(texels, 1))
    return Known(shown=round(known / expected, 4) if expected > 0 else 0.0, uncertainty=round(float(left), 4))


def _regions(parts: list[tuple[Square, Part]]) -> list[Region]:
    total = sum(float(variance.sum()) for _, (variance, _) in parts)
    return [
        Region(**vars(square), **vars(_known(*_sums(iter([part])))))
        for square, part in parts
        if 0 < LEAST * total <= float(part[0].sum())
    ]
