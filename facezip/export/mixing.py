"""How engines mix pictures: whole ones over a neutral, as strongly as masks say, where FaceZip adds differences.

Colours are mixed as linear light, and normals as the x and y of unit vectors; y points down in what both engines read.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import LEAST_DIVISOR, Map
from facezip.files.images import to_float
from facezip.files.srgb import decode_srgb, encode_srgb
from facezip.pack.sampling import bilinear_grid

Rows = Callable[[slice], NDArray[np.float32]]
# Of what later layers leave, below which nothing is left.
LEAST_SHARE = 1e-5
Y_DOWN = np.array([1, -1], np.float32)


@dataclass(frozen=True)
class Rule:
    """What an engine makes of a neutral N, layers L_i and weights w_i of a texel.

    Attributes
    ----------
    in_turn : whether each layer is laid over what those before it gave, c ← c + w_i (L_i - c); otherwise all changes
        are added, N + Σ_i w_i (L_i - N).
    keeps_z : whether a mixed normal keeps the z of the neutral's; otherwise it is rebuilt from x and y.
    """

    in_turn: bool
    keeps_z: bool

    def shares(self, weights: NDArray[np.float32]) -> NDArray[np.float32]:
        """How much of each L_i - N a texel shows, ``(..., R)``, by its weights ``(..., R)``."""
        if not self.in_turn:
            return weights
        later = np.cumprod((1 - weights)[..., ::-1], axis=-1)[..., ::-1]
        return weights * np.concatenate([later[..., 1:], np.ones_like(later[..., :1])], axis=-1)

    def strengths(self, shares: NDArray[np.float32]) -> NDArray[np.float32]:
        """Inverse of :meth:`shares`, of what is not negative and at most 1 together."""
        if not self.in_turn:
            return shares
        left = 1 - (np.cumsum(shares[..., ::-1], axis=-1)[..., ::-1] - shares)
        parts = np.divide(shares, left, out=np.zeros_like(shares), where=left > LEAST_SHARE)
        clipped: NDArray[np.float32] = np.clip(parts, 0, 1).astype(np.float32)
        return clipped

    def wanted(self, kind: Map, texels: NDArray[np.float32], neutral: NDArray[np.float32]) -> NDArray[np.float32]:
        """What mixing has to give to show texels ``(..., C)`` (:class:`Map`) on a mixed ``neutral`` ``(..., C)``."""
        if not (kind.is_normal and self.keeps_z):
            return unmixed(kind, texels)
        vectors = kind.decode(texels)
        across: NDArray[np.float32] = vectors[..., :2] / vectors[..., 2:] * _z_of(neutral)
        return across

    def shown(self, kind: Map, mixed: NDArray[np.float32], neutral: NDArray[np.float32]) -> NDArray[np.float32]:
        """What is seen of mixed values: encoded colours ``(..., C)``, unit vectors ``(..., 3)`` of normals, y up."""
        if not kind.is_normal:
            return encode_srgb(np.clip(mixed, 0, 1))
        vectors = np.concatenate([mixed, _z_of(neutral if self.keeps_z else mixed)], axis=-1)
        units: NDArray[np.float32] = vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
        return units


def unmixed(kind: Map, texels: NDArray[np.float32]) -> NDArray[np.float32]:
    """What an engine mixes of texels ``(..., C)`` (:class:`Map`): linear light; of normals x and y."""
    values = kind.decode(texels)
    return values[..., :2] if kind.is_normal else decode_srgb(values)


def mixed_of(kind: Map, stored: NDArray[np.uint8]) -> NDArray[np.float32]:
    """What an engine mixes of an image ``(..., C)``: linear light; x and y of normals, y up."""
    if not kind.is_normal:
        return decode_srgb(to_float(stored))
    across: NDArray[np.float32] = (2 * to_float(stored[..., :2]) - 1) * Y_DOWN
    return across


def stored_of(kind: Map, mixed: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Inverse of :func:`mixed_of` up to rounding, and to what lies beyond 8 bits; normals have three channels."""
    if kind.is_normal:
        vectors = np.concatenate([np.clip(mixed, -1, 1) * Y_DOWN, _z_of(mixed)], axis=-1)
        return np.rint(255 * (vectors / 2 + 0.5)).astype(np.uint8)
    return np.rint(255 * encode_srgb(np.clip(mixed, 0, 1))).astype(np.uint8)


def limits(kind: Map) -> tuple[float, float]:
    """Between which values an image holds what is mixed."""
    return (-1.0, 1.0) if kind.is_normal else (0.0, 1.0)


def sampled(maps: NDArray[np.float32], size: tuple[int, int]) -> Rows:
    """Weight maps ``(h, w, R)`` as a sampler sees them: gives rows ``(rows, W, R)`` of a texture of ``size``."""
    grid = bilinear_grid(size, (maps.shape[0], maps.shape[1]))
    (above, below, down), (left, right, across) = grid.rows, grid.columns

    def rows_of(rows: slice) -> NDArray[np.float32]:
        upper, lower = maps[above[rows]], maps[below[rows]]
        lines = upper + down[rows, None, None] * (lower - upper)
        near = lines[:, left]
        values: NDArray[np.float32] = near + across[:, None] * (lines[:, right] - near)
        return values

    return rows_of


def _z_of(across: NDArray[np.float32]) -> NDArray[np.float32]:
    """``(..., 1)``: the z of unit vectors whose x and y are these."""
    z = np.sqrt(np.maximum(1 - np.square(across).sum(axis=-1, keepdims=True), 0))
    return np.maximum(z, LEAST_DIVISOR)
