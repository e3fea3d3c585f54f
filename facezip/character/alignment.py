"""Is every expression's texture registered to the neutral's: how far it lies off, where, and how sure that is.

Equation (1) mixes textures texel by texel; where a pore of one lies beside that of another, the mixture blurs (the
paper's main limitation). The whole is measured by a smooth displacement (:mod:`facezip.character.displacement`).
Single features that slipped, and textures that are turned, are looked for apart (:mod:`facezip.character.features`).
"""

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from facezip.character import features
from facezip.character.displacement import DARK, GRID, Still, cells_of, displaced, levels_of, means, pyramid, reduced
from facezip.character.features import Feature
from facezip.character.maps import ALBEDO
from facezip.character.scans import Character, Stack
from facezip.machine.cores import cores
from facezip.machine.progress import track

# Textures are reduced to at most so many texels a side.
SIDE = 512
# A character counts as registered up to here: texels of a texture of 512 x 512, or a 512th of its side.
THRESHOLD = 1.0
# From this confidence on, a displacement counts as known; where it is on less of the face, nothing can be told.
SURE, LEAST_KNOWN = 0.5, 0.02


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
        self._fixed = [Still(image, *np.gradient(image)) for image in pyramid(neutral, stack.scale)]
        # Features are looked for on half of that.
        self._step = -(-max(neutral.shape) // features.SIDE)
        self._features, self._cells = self._log(neutral), cells_of(weight)
        self._weights = [means(weight[:, :, None], step) for step in levels_of(weight)]
        self._face = gaussian_filter(cells_of(weight), 0.5)

    def alignment(self, n: int) -> Alignment:
        """How expression n lies; where the mask shows nothing of a tile, nothing is known."""
        unit = max(512, *self._stack.resolution) / 512
        if not self._face.any():
            nothing = np.zeros((GRID, GRID, 2), np.float32)
            return Alignment(nothing, np.zeros((GRID, GRID), np.float32), 0.0, unit, face=False)
        texture = reduced(np.ascontiguousarray(self._stack.textures[n]), self._factor)
        moving = pyramid(texture, self._stack.scale)
        displacement, certainty = displaced(self._fixed, moving, self._weights)
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
        return np.log(means(texture[:, :, None], self._step) * self._stack.scale + np.float32(DARK))

    def _looked_for(self, other: NDArray[np.float32]) -> tuple[Feature | None, str | None]:
        """A feature that is not in its place, in texels of the texture, and how the whole is turned."""
        how = features.turned(self._features, other)
        feature = None if how else features.worst_feature(self._features, other, self._cells)
        if feature is not None:
            feature = feature._replace(texels=feature.texels * self._step * self._factor)
        return feature, how
