"""How well scans show the texture of every shape, as a whole and by regions of each tile: for a record to read."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.rigging.evidence import Estimate

# Regions are squares of a tile, so many a side.
GRID = 4
# A region counts where it has at least this part of what a shape is expected to change.
LEAST = 0.02


def shown(estimates: Mapping[int, Estimate], shapes: tuple[str, ...]) -> dict[str, dict[str, Any]]:
    """By shape ``shown`` and ``uncertainty``, and both by ``regions``; nothing where there are no estimates.

    ``shown`` is the part of a shape's expected change, in variance, that scans determine: 0 where its texture is the
    neutral's for want of evidence, 1 where it is known. ``uncertainty`` is the standard deviation of what is left,
    0..255 of the albedo.
    """
    if not estimates:
        return {}
    return {
        shape: _facts(*_sums(part for _, part in parts)) | {"regions": _regions(parts)}
        for m, shape in enumerate(shapes)
        for parts in [[(region, part) for tile, made in estimates.items() for region, part in _squares(tile, made, m)]]
    }


Part = tuple[NDArray[np.float64], NDArray[np.float64]]


def _squares(tile: int, made: Estimate, m: int) -> Iterator[tuple[dict[str, Any], Part]]:
    """Regions, and of their texels a shape's expected variance and the evidence for it."""
    height, width = made.evidence.shape[1:]
    rows, columns = (np.linspace(0, size, GRID + 1).round().astype(int) for size in (height, width))
    for i in range(GRID):
        for j in range(GRID):
            some = (m, slice(rows[i], rows[i + 1]), slice(columns[j], columns[j + 1]))
            # Image row 0 is at v = 1.
            region = {"tile": tile, "u": [j / GRID, (j + 1) / GRID], "v": [1 - (i + 1) / GRID, 1 - i / GRID]}
            yield region, (np.square(made.expected[some], dtype=np.float64), made.evidence[some].astype(np.float64))


def _sums(parts: Iterator[Part]) -> tuple[float, float, int]:
    """What is expected and what of it is known, summed over texels, and their number."""
    expected = known = 0.0
    texels = 0
    for variance, evidence in parts:
        expected, known = expected + float(variance.sum()), known + float((variance * evidence).sum())
        texels += variance.size
    return expected, known, texels


def _facts(expected: float, known: float, texels: int) -> dict[str, Any]:
    left = np.sqrt(max(expected - known, 0.0) / max(texels, 1))
    return {"shown": round(known / expected, 4) if expected > 0 else 0.0, "uncertainty": round(float(left), 4)}


def _regions(parts: list[tuple[dict[str, Any], Part]]) -> list[dict[str, Any]]:
    total = sum(float(variance.sum()) for _, (variance, _) in parts)
    return [
        region | _facts(*_sums(iter([part]))) for region, part in parts if 0 < LEAST * total <= float(part[0].sum())
    ]
