"""Colour spaces that files state, and the way from their numbers to linear light of sRGB's primaries."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from facezip.files.srgb import decode_srgb, encode_srgb

Transfer = Callable[[NDArray[np.float32]], NDArray[np.float32]]

# x and y of red, green, blue and white.
SRGB_PRIMARIES = ((0.64, 0.33), (0.30, 0.60), (0.15, 0.06), (0.3127, 0.3290))
# Files state them with four digits or fewer, and white in several roundings.
NEAR = 2e-3
# A profile moves no colour by more than a level of eight bits where it is one of the many spellings of sRGB.
LEVEL = 1 / 255
# How they round a gamma of 2.2, as 5/11, 0.45 or 0.46.
NEAR_GAMMA = 0.05
# Codes of ITU-T H.273 that are red, green and blue of displays.
PRIMARIES = (1, 4, 5, 6, 7, 9, 11, 12, 22)


class ColourFault(Exception):
    """Why colours cannot be converted to sRGB, in words that follow "its colours are"."""


@dataclass(frozen=True, eq=False)
class ColourSpace:
    """What the numbers of an image stand for.

    Attributes
    ----------
    name : as people know it.
    transfer : linear light of stored values in [0, 1], channel by channel on the last axis; None where they are that.
    matrix : ``(3, 3)`` from its linear light to that of sRGB's primaries and white; None where they are the same.
    """

    name: str
    transfer: Transfer | None = None
    matrix: NDArray[np.float64] | None = None

    def light(self, values: NDArray[np.float32]) -> NDArray[np.float32]:
        """Linear light of sRGB's primaries ``(..., C)`` of stored values; what it is outside of [0, 1] is kept."""
        return self.mixed(values if self.transfer is None else self.transfer(values))

    def mixed(self, light: NDArray[np.float32]) -> NDArray[np.float32]:
        """The same light by sRGB's primaries; grey is grey by any."""
        if self.matrix is None or light.shape[-1] == 1:
            return light
        return light @ self.matrix.T.astype(np.float32)

    @property
    def has_srgb_primaries(self) -> bool:
        """Whether its colours are mixed as sRGB's are, but for the rounding of a profile."""
        return self.matrix is None or bool(np.abs(self.matrix - np.eye(3)).max() < 0.01)

    @property
    def is_light(self) -> bool:
        """Whether stored values are linear light of sRGB's primaries."""
        return self.transfer is None and self.has_srgb_primaries

    @cached_property
    def is_srgb(self) -> bool:
        """Whether stored values are sRGB's, but for the rounding of a profile."""
        steps = np.linspace(0, 1, 9, dtype=np.float32)
        colours = np.stack(np.meshgrid(steps, steps, steps), axis=-1).reshape(-1, 3)
        greys = np.repeat(np.linspace(0, 1, 256, dtype=np.float32)[:, None], 3, axis=1)
        stored = np.concatenate([colours, greys])
        return bool(np.abs(encode_srgb(np.clip(self.light(stored), 0, 1)) - stored).max() <= LEVEL)


SRGB = ColourSpace("sRGB", decode_srgb)
LINEAR = ColourSpace("linear sRGB")


def of_primaries(name: str, primaries: ArrayLike, transfer: Transfer | None) -> ColourSpace:
    """The space of chromaticities ``(4, 2)``: x and y of red, green, blue and white.

    White becomes sRGB's (Bradford's adaptation), as neutral colours stay neutral in every colour management.

    Raises
    ------
    ColourFault
        They span no colours.
    """
    points = np.asarray(primaries, np.float64)
    if points.size != 8:
        raise ColourFault(f"of {name}, which are not whole")
    points = points.reshape(4, 2)
    if np.abs(points - SRGB_PRIMARIES).max() <= NEAR:
        return ColourSpace(name, transfer)
    # It takes a second to be imported, and few files need it.
    import colour

    with np.errstate(all="ignore"):
        try:
            theirs, ours = (
                colour.RGB_Colourspace(name, p[:3], p[3]) for p in (points, np.array(SRGB_PRIMARIES, np.float64))
            )
            matrix = np.asarray(colour.matrix_RGB_to_RGB(theirs, ours, "Bradford"), np.float64)
        except np.linalg.LinAlgError:
            matrix = np.full((3, 3), np.nan)
    # Of no real primaries is it larger: sRGB's own from those of every colour that there is are below 4.
    if not np.abs(matrix).max() < 100:
        raise ColourFault(f"of {name}, which span no colours")
    return ColourSpace(name, transfer, matrix)


def of_gamma(exponent: float) -> Transfer | None:
    """Linear light as a power of stored values, None for 1.

    2.2 is the curve of sRGB: writers round it so where they have room for one number, and libpng reads it so.

    Raises
    ------
    ColourFault
        No display or camera has it.
    """
    if not 0.2 < exponent < 5:
        raise ColourFault(f"of a gamma of {exponent:.3g}")
    if abs(exponent - 2.2) < NEAR_GAMMA:
        return decode_srgb
    return None if exponent == 1 else power(exponent)


def power(exponent: float) -> Transfer:
    """Linear light as a power of stored values."""
    return lambda values: np.power(np.maximum(values, 0), np.float32(exponent))


def of_rgb_space(name: str, transfer: Transfer | None) -> ColourSpace:
    """The space of that name in colour-science, with another curve."""
    import colour

    found = colour.RGB_COLOURSPACES[name]
    return of_primaries(name, [*found.primaries, found.whitepoint], transfer)


@lru_cache
def of_code_points(primaries: int, transfer: int) -> ColourSpace:
    """The space of two code points of ITU-T H.273 (cICP in PNG); raises ``ColourFault`` where it is none of a still."""
    name = f"the code points {primaries} and {transfer} of cICP"
    curves: dict[int, Transfer | None] = {4: power(2.2), 5: power(2.8), 8: None, 13: decode_srgb}
    if primaries not in PRIMARIES or transfer not in curves:
        raise ColourFault(f"of {name}, which are not converted here")
    import colour.models.rgb.itut_h_273 as h273

    points = [*h273.COLOUR_PRIMARIES_ITUTH273[primaries], h273.CCS_WHITEPOINTS_ITUTH273[primaries]]
    return of_primaries(name, points, curves[transfer])


@lru_cache
def of_interop_id(identifier: str) -> ColourSpace:
    """The space of an id of the Color Interop Forum (``colorInteropID`` in OpenEXR), such as ``lin_ap1_scene``."""
    import colour

    curves: dict[str, Transfer | None]
    curves = {"lin": None, "srgb": decode_srgb, "g18": power(1.8), "g22": power(2.2)}
    curve, _, rest = identifier.partition("_")
    if curve not in curves or not rest.endswith("_scene") or identifier not in colour.RGB_COLOURSPACES:
        raise ColourFault(f"of the space '{identifier}', which is not known here")
    return of_rgb_space(identifier, curves[curve])
