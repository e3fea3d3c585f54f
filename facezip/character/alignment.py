"""Is every expression's texture registered to the neutral's: a smooth displacement, in texels, and how sure it is.

Equation (1) mixes textures texel by texel; where a pore of one lies beside that of another, the mixture blurs (the
paper's main limitation). The displacement u that minimises Σ_p w(p) (I_0(p) - I_n(p + u(p)))² is found by Gauss-Newton
steps in windows, coarse to fine (Lucas and Kanade 1981), on what remains of log luminance when its local mean is taken
away: neither light nor blood moves it. Wrinkles are structure that the neutral has not: robust weights leave out most
of it, and as slopes are the neutral's alone, the rest is uncorrelated with them. Single features that slipped, and
textures that are turned, are looked for apart (:mod:`facezip.character.features`).
"""

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, uniform_filter

from facezip.character import features
from facezip.character.features import Feature
from facezip.character.maps import ALBEDO
from facezip.character.scans import Character, Stack
from facezip.machine.cores import cores
from facezip.machine.kernels import inner, kernel
from facezip.machine.progress import track
from facezip.machine.rows import by_rows

# Displacements are found on so many windows a side ...
GRID = 32
# ... from textures reduced to at most so many texels a side, in so many steps a level.
SIDE, STEPS = 512, 3
# A pyramid level: how much smaller its image is, and the standard deviation of its windows in cells of the grid.
LEVELS = ((8, 4.0), (4, 3.0), (2, 2.0), (1, 1.25))
# Images of fewer rows or columns than this tell nothing.
SMALLEST = 4
# A character counts as registered up to here: texels of a texture of 512 x 512, or a 512th of its side.
THRESHOLD = 1.0
# A displacement counts as known where its expected error is well below this many texels of the reduced texture.
TOLERANCE = 0.25
# From this confidence on, a displacement counts as known; where it is on less of the face, nothing can be told.
SURE, LEAST_KNOWN = 0.5, 0.02
# Residuals of neighbouring texels are not independent: so many count as one.
CORRELATED = 16
# Side of the neighbourhood whose mean is taken away, in texels of a level.
NEIGHBOURHOOD = 9
# Added to values in [0, 1] before the logarithm, so that the noise of black texels does not count.
DARK = 0.05


@dataclass(frozen=True, eq=False)
class Alignment:
    """How one expression's texture lies on the neutral's.

    Attributes
    ----------
    displacement : ``(32, 32, 2)`` float32, (right, down) in texels of the texture: what the neutral has at a place,
        the expression has so far from there.
    confidence : ``(32, 32)`` float32 in [0, 1]: 0 off the face and where there is nothing to tell from.
    known : the share of the face where confidence is above a half.
    unit : texels of the texture in a 512th of its longer side, 1 at least: what counts as a texel for the eye.
    feature : one that slipped, by texels of the texture, or is lost; None where all are in their place.
    turned : how the whole texture is turned, such as ``upside down``; None where it is not.
    face : whether the tile shows any of the face.
    """

    displacement: NDArray[np.float32]
    confidence: NDArray[np.float32]
    known: float
    unit: float
    feature: Feature | None = None
    turned: str | None = None
    face: bool = True

    @property
    def length(self) -> NDArray[np.float32]:
        """``(32, 32)`` length of the displacement in texels."""
        return np.hypot(self.displacement[..., 0], self.displacement[..., 1])

    @property
    def rms(self) -> float:
        """Root mean square, weighted by confidence, of what is known of the displacement, in texels; 0 for nothing."""
        weight = np.where(self.confidence > SURE, self.confidence, 0)
        return float(np.sqrt((weight * self.length**2).sum() / max(float(weight.sum()), 1e-9)))

    @property
    def worst(self) -> tuple[float, float, float]:
        """The largest displacement that is known, in texels, never below ``rms``, and its place (u, v)."""
        sure = np.where(self.confidence > SURE, self.length, 0)
        row, column = np.unravel_index(sure.argmax(), sure.shape)
        if self.feature is not None and self.feature.texels > sure.max():
            return self.feature.texels, self.feature.u, self.feature.v
        return float(sure.max()), (float(column) + 0.5) / GRID, 1 - (float(row) + 0.5) / GRID

    @property
    def why(self) -> str:
        """In a few words, what is wrong besides the displacement; empty for nothing."""
        if self.turned is not None:
            return self.turned
        if self.feature is None:
            return ""
        slipped = f" by {self.feature.texels:.0f} texels" if self.feature.texels else ""
        return f"a feature is {self.feature.state}{slipped} at {self.feature.u:.2f}, {self.feature.v:.2f}"

    @property
    def state(self) -> Literal["registered", "misregistered", "unknown"]:
        """``registered``, ``misregistered``, or ``unknown``: it has too little in common with the neutral to tell.

        Misregistered is what is off by more than ``THRESHOLD`` (rms, of a texture of 512 x 512), has a feature that
        slipped or is lost, or is turned.
        """
        if self.why or self.rms > THRESHOLD * self.unit:
            return "misregistered"
        return "registered" if self.known > LEAST_KNOWN else "unknown"


class Still(NamedTuple):
    """An image ``(H, W)`` that the others are laid on, and its slopes down and to the right."""

    image: NDArray[np.float32]
    down: NDArray[np.float32]
    across: NDArray[np.float32]


# By expression and tile.
Alignments = dict[str, dict[int, Alignment]]


def alignments(character: Character, names: Sequence[str] | None = None) -> Alignments:
    """How the albedo of all expressions, or of ``names``, lies on every tile."""
    names = character.expressions if names is None else names
    tiles = {tile: _Neutral(stack) for tile, stack in character.of_map(ALBEDO).items()}

    def one(name: str) -> dict[int, Alignment]:
        n = character.index(name)
        return {tile: neutral.alignment(n) for tile, neutral in tiles.items()}

    with ThreadPoolExecutor(cores()) as pool:
        found = track(pool.map(one, names), "Checking alignment", len(names))
        return dict(zip(names, found, strict=True))


def worst_tile(tiles: Mapping[int, Alignment]) -> int:
    """The tile that is off the most, as far as its size goes; what is misregistered counts before what is unknown."""
    return max(tiles, key=lambda tile: severity(_told(tiles, tile), tiles[tile].rms / tiles[tile].unit))


def severity(state: str, rms: float) -> tuple[int, float]:
    """What is worse sorts higher: by :attr:`Alignment.state` first, then by ``rms`` in any unit that is one for all.

    What slipped, is lost or turned has hardly any ``rms``.
    """
    return ("registered", "unknown", "misregistered").index(state), rms


def _told(tiles: Mapping[int, Alignment], tile: int) -> str:
    # A tile that shows nothing of the face, such as that of the back of the head, says nothing about it.
    state = tiles[tile].state
    others = any(other.state != "unknown" for other in tiles.values())
    return "registered" if state == "unknown" and others and not tiles[tile].face else state


def worst_of(tiles: Mapping[int, Alignment]) -> Alignment:
    """The alignment on :func:`worst_tile`."""
    return tiles[worst_tile(tiles)]


def misregistered(found: Alignments) -> dict[str, float]:
    """The expressions that are off the neutral, and by how many texels of the albedo at the worst place."""
    worst = {name: worst_of(tiles) for name, tiles in found.items()}
    return {name: round(one.worst[0], 2) for name, one in worst.items() if one.state == "misregistered"}


def undecided(found: Alignments) -> list[str]:
    """The expressions of which nothing can be told."""
    return [name for name, tiles in found.items() if worst_of(tiles).state == "unknown"]


class _Neutral:
    """What every expression of a stack is compared with."""

    def __init__(self, stack: Stack) -> None:
        self._stack, self._factor = stack, -(-max(SIDE, *stack.resolution) // SIDE)
        weight = reduced(np.ascontiguousarray(stack.weight)[:, :, None], self._factor)
        neutral = reduced(np.ascontiguousarray(stack.neutral), self._factor)
        self._fixed = [Still(image, *np.gradient(image)) for image in _pyramid(neutral, stack.scale)]
        # Features are looked for on half of that.
        self._step = -(-max(neutral.shape) // features.SIDE)
        self._features, self._cells = self._log(neutral), _cells(weight)
        self._weights = [_means(weight[:, :, None], step) for step in _levels(weight)]
        self._face = gaussian_filter(_cells(weight), 0.5)

    def alignment(self, n: int) -> Alignment:
        """How expression n lies; where the mask shows nothing of a tile, nothing is known."""
        unit = max(512, *self._stack.resolution) / 512
        if not self._face.any():
            nothing = np.zeros((GRID, GRID, 2), np.float32)
            return Alignment(nothing, np.zeros((GRID, GRID), np.float32), 0.0, unit, face=False)
        texture = reduced(np.ascontiguousarray(self._stack.textures[n]), self._factor)
        moving = _pyramid(texture, self._stack.scale)
        displacement, certainty = _registered(self._fixed, moving, self._weights)
        confidence = certainty * np.clip(self._face, 0, 1)
        known = float(np.sum(confidence > SURE)) / max(float(np.sum(self._face > SURE)), 1.0)
        feature, how = self._looked_for(self._log(texture))
        if known <= LEAST_KNOWN and feature is not None and feature.state == "lost":
            # Where nothing is found again, no feature is lost apart.
            feature = None
        return Alignment(
            displacement * np.float32(self._factor), confidence.astype(np.float32), known, unit, feature, how
        )

    def _log(self, texture: NDArray[np.float32]) -> NDArray[np.float32]:
        return np.log(_means(texture[:, :, None], self._step) * self._stack.scale + np.float32(DARK))

    def _looked_for(self, other: NDArray[np.float32]) -> tuple[Feature | None, str | None]:
        """A feature that is not in its place, in texels of the texture, and how the whole is turned."""
        how = features.turned(self._features, other)
        feature = None if how else features.worst_feature(self._features, other, self._cells)
        if feature is not None:
            feature = feature._replace(texels=feature.texels * self._step * self._factor)
        return feature, how


def _pyramid(luminance: NDArray[np.float32], scale: np.float32) -> list[NDArray[np.float32]]:
    """Log luminance without its local mean, at every level: a gain of the exposure changes nothing."""
    levels = [_means(luminance[:, :, None], step) for step in _levels(luminance)]
    logs = [np.log(level * scale + np.float32(DARK)) for level in levels]
    return [log - uniform_filter(log, NEIGHBOURHOOD) for log in logs]


def _levels(image: NDArray[np.float32]) -> list[int]:
    """How much smaller the levels of a pyramid are, the smallest first."""
    return [step for step, _ in LEVELS if min(image.shape) >= SMALLEST * step]


def _registered(
    fixed: list[Still],
    moving: list[NDArray[np.float32]],
    weights: list[NDArray[np.float32]],
) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
    """Displacement ``(GRID, GRID, 2)`` in texels of the finest level, and how far to trust it ``(GRID, GRID)``.

    ``fixed``, ``moving`` and ``weights`` are one a level.
    """
    displacement = np.zeros((GRID, GRID, 2), np.float32)
    certainty = np.zeros((GRID, GRID))
    levels = LEVELS[len(LEVELS) - len(fixed) :]
    for (step, window), still, other, weight in zip(levels, fixed, moving, weights, strict=True):
        spread = float(np.average((still.image - other) ** 2, weights=weight)) + 1e-12
        for _ in range(STEPS):
            sums = np.zeros((GRID, GRID, 7))
            _normal_equations(still, other, weight, displacement / step, spread, sums)
            sums = gaussian_filter(sums, (window, window, 0), mode="constant")
            move, certainty = _solved(sums)
            displacement += (step * np.clip(move, -1, 1)).astype(np.float32)
            spread = float(sums[..., 5].sum() / max(sums[..., 6].sum(), 1e-12)) + 1e-12
    return displacement, certainty


def _solved(sums: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """A Gauss-Newton step for every window ``(GRID, GRID, 2)``, and how far to trust it, 0..1.

    A little is added to the structure tensor: where it says nothing, nothing moves.
    """
    xx, xy, yy, bx, by, squares, count = np.moveaxis(sums, 2, 0)
    floor = 0.02 * (xx + yy).mean()
    xx, yy = xx + floor, yy + floor
    determinant = xx * yy - xy * xy + 1e-30
    move = np.stack([yy * bx - xy * by, xx * by - xy * bx], axis=2) / determinant[:, :, None]
    least = (xx + yy) / 2 - np.sqrt(((xx - yy) / 2) ** 2 + xy**2) - floor
    variance = squares / np.maximum(count, 1e-9) / np.maximum(least, 1e-12)
    return move, TOLERANCE**2 / (TOLERANCE**2 + CORRELATED * variance)


def reduced(texels: NDArray[Any], factor: int) -> NDArray[np.float32]:
    """The mean ``(H / factor, W / factor)`` over channels and blocks of factor x factor; a part block is left out.

    Of a texture that may live in a file, and goes by rows; :func:`_means` is the same of what is in memory.
    """
    shape = texels.shape[0] // factor, texels.shape[1] // factor
    return by_rows(lambda rows: _means(texels[rows.start * factor : rows.stop * factor], factor), shape, np.float32)


@kernel()
def _means(texels: NDArray[np.uint8], factor: int) -> NDArray[np.float32]:
    height, width, channels = texels.shape
    out = np.empty((height // factor, width // factor), np.float32)
    share, many = np.float32(1 / (factor * factor * channels)), factor * channels
    # Sums of columns fill vector registers; those of blocks, a few values each, do not.
    columns = np.empty(out.shape[1] * many, np.float32)
    for y in range(out.shape[0]):
        columns[:] = 0
        for j in range(y * factor, (y + 1) * factor):
            row = texels[j].reshape(-1)
            for k in range(len(columns)):
                columns[k] += np.float32(row[k])
        for x in range(out.shape[1]):
            total = np.float32(0)
            for k in range(x * many, (x + 1) * many):
                total += columns[k]
            out[y, x] = total * share
    return out


def _cells(weight: NDArray[np.float32]) -> NDArray[np.float32]:
    """The mean weight of every cell of the grid."""
    rows, columns = (np.arange(size) * GRID // size for size in weight.shape)
    cell = (rows[:, None] * GRID + columns).ravel()
    total, count = np.bincount(cell, weight.ravel(), GRID**2), np.bincount(cell, minlength=GRID**2)
    return (total / np.maximum(count, 1)).astype(np.float32).reshape(GRID, GRID)


@kernel(error_model="numpy")
def _normal_equations(
    still: Still,
    other: NDArray[np.float32],
    weight: NDArray[np.float32],
    displacement: NDArray[np.float32],
    spread: float,
    sums: NDArray[np.float64],
) -> None:
    """Add to every cell: Σw gx², Σw gx gy, Σw gy², Σw gx r, Σw gy r, Σw r², Σw; w falls with the residual r."""
    height, width = still.image.shape
    cells = displacement.shape[0]
    for y in range(1, height - 1):
        gy = (y + 0.5) * cells / height - 0.5
        for x in range(1, width - 1):
            if weight[y, x] <= 0:
                continue
            gx = (x + 0.5) * cells / width - 0.5
            at_x = x + bilinear(displacement[:, :, 0], gx, gy)
            at_y = y + bilinear(displacement[:, :, 1], gx, gy)
            residual = still.image[y, x] - bilinear(other, at_x, at_y)
            trust = weight[y, x] * spread / (spread + residual * residual)
            across, down = still.across[y, x], still.down[y, x]
            cell = sums[y * cells // height, x * cells // width]
            cell[0] += trust * across * across
            cell[1] += trust * across * down
            cell[2] += trust * down * down
            cell[3] += trust * across * residual
            cell[4] += trust * down * residual
            cell[5] += trust * residual * residual
            cell[6] += trust


@inner(inline="always")
def bilinear(image: NDArray[np.float32], x: float, y: float) -> float:
    """The value of ``(H, W)`` at a place in texels, clamped to the edge."""
    x = min(max(x, 0.0), image.shape[1] - 1.0)
    y = min(max(y, 0.0), image.shape[0] - 1.0)
    left, top = min(int(x), image.shape[1] - 2), min(int(y), image.shape[0] - 2)
    fx, fy = x - left, y - top
    upper = (1 - fx) * image[top, left] + fx * image[top, left + 1]
    lower = (1 - fx) * image[top + 1, left] + fx * image[top + 1, left + 1]
    return (1 - fy) * upper + fy * lower
