"""Hair as strokes that follow its growth: the shaved scalp, a beard's stubble, brows, lashes.

A hair has a root on the skin, a direction in which it grows there, and a length; it is drawn on the chart as the sum of
what its points cover. Thinner than a texel, it covers a part of it.
"""

import numpy as np
from numpy.typing import NDArray

from facezip.machine.kernels import inner, kernel
from scenes.face.features import LID_HALF_WIDTH, Rows
from scenes.face.head import Head
from scenes.face.skin.eye import EYE_X
from scenes.face.skin.noise import hashed, smooth, value_noise
from scenes.face.skin.sampling import TexelGrid, at_texel
from scenes.face.skin.strokes import area, stroke
from scenes.face.skin.zones import beard, brow, scalp
from scenes.face.traits import Traits

SCALP, BEARD, BROW = 0, 1, 2
# Hairs to a square centimetre where they are densest, and how thick they are there (cm).
DENSITY = (120.0, 90.0, 210.0)
THICKNESS = (0.0085, 0.0080, 0.0100)
# Where the hair of the scalp whirls, and texels (cm) finer than which every hair is drawn.
WHORL = (0.8, 10.9, -5.0)
FINE = 0.1


def grown(head: Head, texels: TexelGrid, person: Traits) -> NDArray[np.float32]:
    """``(R, R)`` float32 in [0, 1]: how much of a texel hair covers."""
    cover = np.zeros((len(texels.row_of), len(texels.column_of)), np.float32)
    _grow(texels, person, cover)
    for side in (-1.0, 1.0):
        _lashes(texels, head.rows, side, person, cover)
    return np.float32(1) - np.exp(-cover)


@kernel()
def _grow(texels: TexelGrid, person: Traits, cover: NDArray[np.float32]) -> None:
    """Every cell of the chart's grid grows as many hairs of a kind as its area and the zone's density say."""
    grid, p, way = texels.grid, np.empty(3), np.empty(3)
    share = min(1.0, (FINE / texels.texel) ** 2)
    for j in range(grid.shape[0] - 2):
        for i in range(grid.shape[1] - 1):
            whole = area(grid, j, i) * share
            for kind in range(3):
                if not _near(grid, j, i, kind, person):
                    continue
                amount = whole * DENSITY[kind] + hashed(j, i, kind, person.seed + 501)
                for n in range(int(amount)):
                    number = person.seed + 503 + 97 * n + 11 * kind
                    row, column = j + hashed(j, i, 1, number), i + hashed(j, i, 2, number)
                    at_texel(grid, row, column, p)
                    dense = _density(kind, p[0], p[1], p[2], person)
                    if hashed(j, i, 3, number) > dense:
                        continue
                    luck = hashed(j, i, 4, number), hashed(j, i, 5, number), hashed(j, i, 6, number)
                    length, bend = _growth(kind, p, luck, person, way)
                    stroke(texels, row, column, way, length, bend, THICKNESS[kind] / share, cover)


@inner()
def _near(grid: NDArray[np.float32], j: int, i: int, kind: int, person: Traits) -> bool:
    for b in range(2):
        for a in range(2):
            p = grid[j + b, i + a]
            if _density(kind, p[0], p[1], p[2], person) > 0.01:
                return True
    return False


@inner()
def _density(kind: int, x: float, y: float, z: float, person: Traits) -> float:
    if kind == SCALP:
        ragged = 0.30 * value_noise(x * 1.1, y * 1.1, z * 1.1, person.seed + 91)
        ragged += 0.22 * value_noise(x * 3.1, y * 3.1, z * 3.1, person.seed + 92)
        return scalp(x, y + ragged, z, person.female)
    if kind == BEARD:
        return person.beard * beard(x, y, z) if person.beard > 0 else 0.0
    return brow(x, y, person.brow, person.female)[0] if z > 3 else 0.0


@inner()
def _growth(
    kind: int, p: NDArray[np.float64], luck: tuple[float, float, float], person: Traits, way: NDArray[np.float64]
) -> tuple[float, float]:
    """The direction of growth into ``way``; the length in cm, and how far the hair bends (radians)."""
    x, y, z = p
    side = 1.0 if x > 0 else -1.0
    if kind == SCALP:
        # Away from the whorl and around it; forwards above, downwards at the sides.
        way[0], way[1], way[2] = x - WHORL[0] - 0.5 * (z - WHORL[2]), y - WHORL[1] - 2.0, z - WHORL[2] + 0.5 * x
        length, bend = 0.16 + 0.16 * luck[0], 0.0
    elif kind == BEARD:
        lip = smooth(-6.0, -5.0, y) * smooth(3.2, 2.2, abs(x))
        way[0], way[1] = side * (0.25 + 0.5 * lip) - 0.12 * x * (1 - lip), -1.0
        way[2] = -0.15
        length, bend = 0.05 + 0.13 * luck[0] * luck[0], 0.0
    else:
        _, angle, reach = brow(x, y, person.brow, person.female)
        angle += 0.28 * (luck[2] - 0.5)
        way[0], way[1], way[2] = side * np.cos(angle), np.sin(angle), 0.0
        length, bend = reach * (0.55 + 0.45 * luck[0]), -0.45 * side
    size = max(np.sqrt(way[0] ** 2 + way[1] ** 2 + way[2] ** 2), 1e-9)
    for c in range(3):
        way[c] = way[c] / size + (0.22 if kind != BROW else 0.0) * (luck[(c + 1) % 3] - 0.5) * 2
    return length, bend


@kernel()
def _lashes(texels: TexelGrid, rows: Rows, side: float, person: Traits, cover: NDArray[np.float32]) -> None:
    """Two rows of lashes on the margins of one eye: they stand out from it, so that they are seen foreshortened.

    The upper ones are so dense that from the front they hide the margin, and reach up over the lid; the lower ones
    are few.
    """
    p, way = np.empty(3), np.empty(3)
    share = min(1.0, FINE / texels.texel)
    for upper in range(2):
        margin = rows.upper_lid - 0.35 if upper else rows.lower_lid - 0.10
        count = int((230 if upper else 80) * share)
        for n in range(count):
            luck = hashed(n, upper, 1, person.seed + 521), hashed(n, upper, int(side), person.seed + 523)
            s = (n + luck[0]) / count * 1.84 - 0.92
            column = _column_at(texels.grid, int(margin), side * (EYE_X + s * LID_HALF_WIDTH))
            at_texel(texels.grid, margin, column, p)
            lift = 1.0 if upper else -1.0
            # Lashes grow in groups, and longest towards the temple.
            group = 0.5 * value_noise(n * 0.31 / share, upper * 5.0, side, person.seed + 527)
            way[0], way[1], way[2] = side * (0.75 * s + 0.12 + group), lift, 0.0
            length = (0.27 if upper else 0.15) * (0.45 + 0.55 * luck[1]) * (1 + 0.3 * s) * (1 + 0.3 * person.female)
            root = margin + 0.35 * lift * (luck[1] - 0.5)
            stroke(texels, root, column, way, length, -0.6 * side * s, (0.012 if upper else 0.009) / share, cover)


@inner()
def _column_at(grid: NDArray[np.float32], row: int, x: float) -> float:
    """The column at which a row of the front passes ``x``."""
    for i in range(grid.shape[1] - 1):
        a, b = grid[row, i], grid[row, i + 1]
        if a[2] > 4 and a[0] <= x < b[0]:
            return i + (x - a[0]) / (b[0] - a[0])
    return grid.shape[1] / 2
