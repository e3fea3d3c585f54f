"""Is every expression's texture registered to the neutral's: a smooth displacement, in texels, and how sure it is.

Equation (1) mixes textures texel by texel; where a pore of one lies beside that of another, the mixture blurs (the
paper's main limitation).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from facezip.character.features import Feature

# Displacements are found on so many windows a side.
GRID = 32
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


def worst_tile(tiles: Mapping[int, Alignment]) -> int:
    """The tile that is off the most, as far as its size goes; what is misregistered counts before what is unknown."""
    states = ("registered", "unknown", "misregistered")
    return max(tiles, key=lambda tile: (states.index(_told(tiles, tile)), tiles[tile].rms / tiles[tile].unit))


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
