"""The compressed textures in memory: equation (1) for one expression, (8) and (12) for any blend."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from facezip.errors import ErrorCode, FaceZipError
from facezip.files.obj import Topology
from facezip.machine.rows import by_rows
from facezip.pack.footprint import Footprint
from facezip.pack.sampling import Grid, bilinear_grid

# Blendshape weights lie within 0 and 1, and somewhat beyond where an animator exaggerates.
MAX_BLEND = 1000


@dataclass(frozen=True, eq=False)
class Meshes:
    """Neutral mesh and displacements, so that a pack renders and views on its own (equation 7).

    Attributes
    ----------
    topology : faces and UV layout.
    neutral : ``(V, 3)`` float32.
    deltas : ``(N, V, 3)`` float32, expression minus neutral.
    """

    topology: Topology
    neutral: NDArray[np.float32]
    deltas: NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class CompressedTextures:
    """One neutral, R difference textures and N low-resolution weight maps (equation 1).

    Attributes
    ----------
    neutral : ``(H, W, C)`` float32 in [0, 1], encoded values.
    differences : ``(R, H, W, C)`` float32, encoded values, signed.
    weights : ``(N, h, w, R)`` float32; sampled bilinearly. PCA is the special case of one texel, ``h = w = 1``.
    expressions : N names in the order of ``weights``.
    method : what fitted them: paper, paper-optimised, paper-unpermuted, pca, refined.
    meshes : the geometry, or None.
    difference_range : ``(R, C)`` float32, the largest value of a difference texture that a pack has to hold where the
        fit chose one; None for the largest there is.
    """

    neutral: NDArray[np.float32]
    differences: NDArray[np.float32]
    weights: NDArray[np.float32]
    expressions: tuple[str, ...]
    method: str
    meshes: Meshes | None = None
    difference_range: NDArray[np.float32] | None = None

    @property
    def footprint(self) -> Footprint:
        """Bytes and fetches at run time."""
        slots, height, width, channels = self.differences.shape
        n, h, w, _ = self.weights.shape
        return Footprint((height, width), channels, slots, n, (h, w))

    def reconstruct(self, expression: str) -> NDArray[np.float32]:
        """The texture of one expression, equation (1): ``(H, W, C)`` float32 in [0, 1]; neutral for ``"neutral"``."""
        return self.blend({} if expression == "neutral" else {expression: 1.0})

    def blend(self, weights: Mapping[str, float]) -> NDArray[np.float32]:
        """The texture of a blend β, equations (8) and (12): ``(H, W, C)`` float32 clipped to [0, 1].

        The weight maps are combined at low resolution first, as a shader does once a frame.

        Raises
        ------
        FaceZipError
            ``UNKNOWN_NAME`` for a name that is no expression, ``BAD_VALUE`` for a weight outside ±1000.
        """
        return by_rows(self.rows_of(weights), self.neutral.shape, np.float32)

    def rows_of(self, weights: Mapping[str, float]) -> Callable[[slice], NDArray[np.float32]]:
        """As :meth:`blend`, but only those rows that are asked for, so that no whole texture need be held."""
        combined = np.zeros(self.weights.shape[1:], np.float32)
        for name, weight in weights.items():
            combined += np.float32(self._checked(name, weight)) * self.weights[self.expressions.index(name)]
        return blended_rows(self.neutral, self.differences, combined)

    def _checked(self, name: str, weight: float) -> float:
        if name not in self.expressions:
            known = ", ".join(self.expressions)
            raise FaceZipError(ErrorCode.UNKNOWN_NAME, f"no expression '{name}' in this pack; it has {known}")
        if not abs(weight) <= MAX_BLEND:
            raise FaceZipError(ErrorCode.BAD_VALUE, f"weight {weight} of '{name}': must lie within ±{MAX_BLEND}")
        return weight


def blend_differences(
    neutral: NDArray[np.float32], differences: NDArray[np.float32], weights: NDArray[np.float32]
) -> NDArray[np.float32]:
    """Equation (1) with one weight map ``(h, w, R)``: ``(H, W, C)`` float32 clipped to [0, 1]."""
    return by_rows(blended_rows(neutral, differences, weights), neutral.shape, np.float32)


def blended_rows(
    neutral: NDArray[np.float32], differences: NDArray[np.float32], weights: NDArray[np.float32]
) -> Callable[[slice], NDArray[np.float32]]:
    """Some rows of :func:`blend_differences`, whichever are asked for."""
    height, width, channels = neutral.shape
    grid = bilinear_grid((height, width), weights.shape[:2])
    maps = neutral, differences, np.ascontiguousarray(weights)

    def blended(rows: slice) -> NDArray[np.float32]:
        out = np.empty((rows.stop - rows.start, width, channels), np.float32)
        _blend(rows.start, *maps, grid, out)
        return out

    return blended


@njit(cache=True, nogil=True)
def _blend(
    top: int,
    neutral: NDArray[np.float32],
    differences: NDArray[np.float32],
    weights: NDArray[np.float32],
    grid: Grid,
    out: NDArray[np.float32],
) -> None:
    slots, _, width, channels = differences.shape
    rows, columns = grid
    for y in range(top, top + len(out)):
        upper, lower, v = weights[rows.first[y]], weights[rows.second[y]], rows.fraction[y]
        for x in range(width):
            a, b, u = columns.first[x], columns.second[x], columns.fraction[x]
            for c in range(channels):
                out[y - top, x, c] = neutral[y, x, c]
            for i in range(slots):
                above = upper[a, i] + u * (upper[b, i] - upper[a, i])
                below = lower[a, i] + u * (lower[b, i] - lower[a, i])
                weight = above + v * (below - above)
                for c in range(channels):
                    out[y - top, x, c] += weight * differences[i, y, x, c]
            for c in range(channels):
                out[y - top, x, c] = min(max(out[y - top, x, c], np.float32(0)), np.float32(1))
