"""How the textures of expressions lie on the neutral's: each tile's neutral is made ready once, for all of them.

Wrinkles are structure that the neutral has not: robust weights leave out most of it, and as slopes are the neutral's
alone, the rest is uncorrelated with them. Single features that slipped, and textures that are turned, are looked for
apart (:mod:`facezip.character.features`).
"""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from facezip.character import features
from facezip.character.alignment import GRID, LEAST_KNOWN, SURE, Alignment, Alignments
from facezip.character.displacement import Still, registered
from facezip.character.features import Feature
from facezip.character.maps import ALBEDO
from facezip.character.pyramids import DARK, in_cells, pyramid, reduced, steps_down
from facezip.character.scans import Character, Stack
from facezip.machine.cores import cores
from facezip.machine.progress import track

# Textures are reduced to at most so many texels a side.
SIDE = 512


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


class _Neutral:
    """What every expression of a stack is compared with."""

    def __init__(self, stack: Stack) -> None:
        self._stack, self._factor = stack, -(-max(SIDE, *stack.resolution) // SIDE)
        weight = reduced(np.ascontiguousarray(stack.weight)[:, :, None], self._factor)
        neutral = reduced(np.ascontiguousarray(stack.neutral), self._factor)
        self._fixed = [Still(image, *np.gradient(image)) for image in pyramid(neutral, stack.scale)]
        # Features are looked for on half of that.
        self._step = -(-max(neutral.shape) // features.SIDE)
        self._features, self._cells = self._log(neutral), in_cells(weight)
        self._weights = [reduced(weight[:, :, None], step) for step in steps_down(weight)]
        self._face = gaussian_filter(in_cells(weight), 0.5)

    def alignment(self, n: int) -> Alignment:
        """How expression n lies; where the mask shows nothing of a tile, nothing is known."""
        unit = max(512, *self._stack.resolution) / 512
        if not self._face.any():
            nothing = np.zeros((GRID, GRID, 2), np.float32)
            return Alignment(nothing, np.zeros((GRID, GRID), np.float32), 0.0, unit, face=False)
        texture = reduced(np.ascontiguousarray(self._stack.textures[n]), self._factor)
        moving = pyramid(texture, self._stack.scale)
        displacement, certainty = registered(self._fixed, moving, self._weights)
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
        return np.log(reduced(texture[:, :, None], self._step) * self._stack.scale + np.float32(DARK))

    def _looked_for(self, other: NDArray[np.float32]) -> tuple[Feature | None, str | None]:
        """A feature that is not in its place, in texels of the texture, and how the whole is turned."""
        how = features.turned(self._features, other)
        feature = None if how else features.worst_feature(self._features, other, self._cells)
        if feature is not None:
            feature = feature._replace(texels=feature.texels * self._step * self._factor)
        return feature, how
