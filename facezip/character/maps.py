"""What a map holds, and as which texels between 0 and 1 it is stored and fitted, so that expressions add linearly.

Colours are stored as their encoded (sRGB) values and data as they are. Unit vectors do not add: normals are stored as
the slopes (x/z, y/z) of the surface that they stand on, which do as its heights do, and become unit vectors again at
the end.
"""

import re
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from facezip.files.images import Texels, to_float
from facezip.machine.rows import by_rows

ALBEDO = "albedo"
# A map on a UDIM tile.
Key = tuple[str, int]
Encoding = Literal["srgb", "data", "normal"]
ENCODINGS: tuple[Encoding, ...] = get_args(Encoding)
# tan 84°. What stands steeper has no business in a tangent-space normal map.
MAX_SLOPE = 10.0
# A normal's z is at least this where x and y are divided by it.
LEAST_DIVISOR = 1e-3
MAX_RANGE = 1e6

_NAME = re.compile(r"[a-z][a-z0-9_]{0,31}")


@dataclass(frozen=True)
class Map:
    """A kind of map of the skin.

    Attributes
    ----------
    name : small letters, digits and ``_``, as in file names.
    encoding : ``srgb`` for colours, ``data`` for numbers, ``normal`` for unit vectors of tangent space, y up.
    low, high : the values that t = 0 and t = 1 stand for; within, a blend is clipped. -1 and 1 for normals, which are
        never clipped.
    """

    name: str
    encoding: Encoding
    low: float = 0.0
    high: float = 1.0

    @property
    def is_normal(self) -> bool:
        """Whether texels are directions."""
        return self.encoding == "normal"

    @property
    def is_plain(self) -> bool:
        """Whether texels are the values themselves."""
        return not self.is_normal and (self.low, self.high) == (0, 1)

    @property
    def unit(self) -> float:
        """How much of a value, or of a slope, texels from 0 to 1 span."""
        return 2 * MAX_SLOPE if self.is_normal else self.high - self.low

    def decode(self, texels: Texels) -> NDArray[np.float32]:
        """The values ``(H, W, C)`` that texels stand for, encoded (sRGB) of colours; unit vectors ``(H, W, 3)``."""
        if self.is_plain:
            return to_float(texels)
        shape = (*texels.shape[:-1], 3) if self.is_normal else texels.shape

        def values(rows: slice) -> NDArray[np.float32]:
            stored = to_float(texels[rows])
            if self.is_normal:
                return normals_of((stored - np.float32(0.5)) * np.float32(self.unit))
            return np.float32(self.low) + np.float32(self.unit) * stored

        return by_rows(values, shape, np.float32)

    def encode(self, values: NDArray[np.float32]) -> NDArray[np.float32]:
        """Inverse of :meth:`decode`: texels, float32 in [0, 1]."""
        shape = (*values.shape[:-1], 2) if self.is_normal else values.shape

        def texels(rows: slice) -> NDArray[np.float32]:
            some = values[rows]
            if self.is_normal:
                slopes = some[..., :2] / np.maximum(some[..., 2:], LEAST_DIVISOR)
                return np.clip(np.float32(0.5) + slopes / np.float32(self.unit), 0, 1).astype(np.float32)
            return ((some - np.float32(self.low)) / np.float32(self.unit)).astype(np.float32)

        return by_rows(texels, shape, np.float32)


# Channels that a file may have beyond these are alpha, or repeat the first.
KNOWN = {
    kind.name: kind
    for kind in (
        Map(ALBEDO, "srgb"),
        Map("normal", "normal", -1.0, 1.0),
        Map("roughness", "data"),
        Map("specular", "data"),
        Map("cavity", "data"),
    )
}


def is_map_name(name: object) -> bool:
    """Whether a map may be called so."""
    return isinstance(name, str) and _NAME.fullmatch(name) is not None and name not in ("weights", "mask")


def normals_of(slopes: NDArray[np.float32]) -> NDArray[np.float32]:
    """Unit vectors ``(..., 3)`` with slopes ``(..., 2)``: (p, q, 1) / ‖(p, q, 1)‖."""
    vectors = np.concatenate([slopes, np.ones_like(slopes[..., :1])], axis=-1)
    return vectors / np.sqrt(np.einsum("...c,...c->...", vectors, vectors))[..., None]


def angles(one: NDArray[np.float32], other: NDArray[np.float32]) -> NDArray[np.float32]:
    """Degrees between unit vectors ``(..., 3)``, exact for small ones: 2 asin(‖a - b‖ / 2)."""
    half = np.sqrt(np.square(one - other).sum(axis=-1)) / 2
    return np.degrees(2 * np.arcsin(np.minimum(half, np.float32(1)))).astype(np.float32)
