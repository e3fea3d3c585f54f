"""LDR-FLIP (Andersson et al. 2020), what a person sees when alternating between two images, fused and shared.

The authors' evaluator filters both images for every pair. Here an image is filtered once, however many others it is
compared with, and every filter runs as two vectorised passes.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from facezip.machine.kernels import kernel
from render.colour import lab_curve, linear

# Pixels per degree: a 0.7 m wide 4K display seen from 0.7 m, the FLIP authors' default.
PIXELS_PER_DEGREE = 67.02

Map = NDArray[np.float32]

_XYZ = np.array(
    [
        [10135552 / 24577794, 8788810 / 24577794, 4435075 / 24577794],
        [2613072 / 12288897, 8788810 / 12288897, 887015 / 12288897],
        [1425312 / 73733382, 8788810 / 73733382, 70074185 / 73733382],
    ]
)
_WHITE = _XYZ.sum(axis=1)
# Linear RGB to XYZ relative to white, and back.
_TO, _BACK = (_XYZ / _WHITE[:, None]).astype(np.float32), np.linalg.inv(_XYZ / _WHITE[:, None]).astype(np.float32)


@dataclass(frozen=True, eq=False)
class Seen:
    """An image as FLIP sees it, ready to be compared.

    Attributes
    ----------
    lab : ``(3, h, w)`` what the eye's contrast sensitivity leaves of it: L*, and a*, b* after Hunt.
    edges, points : ``(h, w)`` strengths of its edges and points.
    """

    lab: Map
    edges: Map
    points: Map


def seen(encoded: Map) -> Seen:
    """Filter an sRGB image ``(h, w, 3)`` with values in [0, 1]."""
    luma, red_green, yellow_blue = _opponent(np.ascontiguousarray(encoded, np.float32), _TO)
    (a,), (rg,), by = _sensitivities()
    first, second = (weight * _blur(yellow_blue, taps, taps) for weight, taps in by)
    filtered = _blur(luma, a[1], a[1]), _blur(red_green, rg[1], rg[1]), first + second
    smooth, slope, bend = _feature_taps()
    rows = [_along_rows(luma, taps) for taps in (smooth, slope, bend)]
    edges = np.hypot(_along_columns(rows[1], smooth), _along_columns(rows[0], slope))
    points = np.hypot(_along_columns(rows[2], smooth), _along_columns(rows[0], bend))
    # Feature filters are for luminance in 0..1 and blind to constants: 116 Y - 16 differs from it by the factor alone.
    return Seen(_hunt(*filtered, _TO, _BACK), edges / np.float32(116), points / np.float32(116))


def flip(a: Seen, b: Seen) -> Map:
    """The error ``(h, w)``, 0 for none to 1, between two images of one size; symmetric."""
    return _combine(a.lab, b.lab, a.edges, b.edges, a.points, b.points, _largest_colour_error())


@cache
def _sensitivities() -> tuple[tuple[tuple[np.float32, Map], ...], ...]:
    """Contrast sensitivity of lightness, red-green and yellow-blue: sums of weighted Gaussians of separable taps."""
    bands = (((1.0, 0.0047),), ((1.0, 0.0053),), ((34.1, 0.04), (13.5, 0.025)))
    radius = int(np.ceil(3 * np.sqrt(0.04 / (2 * np.pi**2)) * PIXELS_PER_DEGREE))
    x = np.arange(-radius, radius + 1) / PIXELS_PER_DEGREE
    found = []
    for band in bands:
        gaussians = [np.exp(-(np.pi**2) * x**2 / b) for _, b in band]
        masses = [a * np.sqrt(np.pi / b) * g.sum() ** 2 for (a, b), g in zip(band, gaussians, strict=True)]
        pairs = zip(masses, gaussians, strict=True)
        found.append(tuple((np.float32(mass / sum(masses)), _trimmed(g / g.sum())) for mass, g in pairs))
    return tuple(found)


def _trimmed(taps: NDArray[np.float64]) -> Map:
    """Symmetric taps without those that a float cannot tell from nothing."""
    count = int((taps < 1e-8).sum()) // 2
    return taps[count : len(taps) - count].astype(np.float32)


@cache
def _feature_taps() -> tuple[Map, Map, Map]:
    """A Gaussian, its first and its second derivative, positive and negative parts each of sum one."""
    deviation = 0.5 * 0.082 * PIXELS_PER_DEGREE
    radius = int(np.ceil(3 * deviation))
    x = np.arange(-radius, radius + 1)
    gaussian = np.exp(-(x**2) / (2 * deviation**2))
    slope, bend = -x * gaussian, (x**2 / deviation**2 - 1) * gaussian
    smooth, *derivatives = gaussian / gaussian.sum(), slope, bend
    halves = [np.where(d > 0, d / d[d > 0].sum(), d / -d[d < 0].sum()) for d in derivatives]
    return smooth.astype(np.float32), halves[0].astype(np.float32), halves[1].astype(np.float32)


@cache
def _largest_colour_error() -> np.float32:
    green, blue = (
        _hunt(*_opponent(np.array([[colour]], np.float32), _TO), _TO, _BACK)[:, 0, 0] for colour in np.eye(3)[1:]
    )
    distance = abs(green[0] - blue[0]) + np.hypot(green[1] - blue[1], green[2] - blue[2])
    return np.float32(distance**0.7)


def _blur(image: Map, row_taps: Map, column_taps: Map) -> Map:
    return _along_columns(_along_rows(image, row_taps), column_taps)


@kernel(fastmath={"contract", "reassoc"})
def _along_rows(image: Map, taps: Map) -> Map:
    height, width = image.shape
    radius = len(taps) // 2
    padded = np.empty(width + 2 * radius, np.float32)
    out = np.empty((height, width), np.float32)
    for y in range(height):
        # Not by slices: their check of shapes takes longer to compile than all else here.
        for x in range(len(padded)):
            padded[x] = image[y, min(max(x - radius, 0), width - 1)]
        line = np.zeros(width, np.float32)
        for t in range(len(taps)):
            tap = taps[t]
            for x in range(width):
                line[x] += tap * padded[x + t]
        for x in range(width):
            out[y, x] = line[x]
    return out


@kernel(fastmath={"contract", "reassoc"})
def _along_columns(image: Map, taps: Map) -> Map:
    height, width = image.shape
    radius = len(taps) // 2
    out = np.empty((height, width), np.float32)
    for y in range(height):
        line = np.zeros(width, np.float32)
        for t in range(len(taps)):
            source, tap = image[min(max(y + t - radius, 0), height - 1)], taps[t]
            for x in range(width):
                line[x] += tap * source[x]
        for x in range(width):
            out[y, x] = line[x]
    return out


@kernel()
def _opponent(encoded: Map, to: Map) -> Map:
    """sRGB to the linear opponent space YCxCz, ``(3, h, w)``."""
    height, width, _ = encoded.shape
    out = np.empty((3, height, width), np.float32)
    for y in range(height):
        for x in range(width):
            red, green, blue = linear(encoded[y, x, 0]), linear(encoded[y, x, 1]), linear(encoded[y, x, 2])
            big_x = to[0, 0] * red + to[0, 1] * green + to[0, 2] * blue
            big_y = to[1, 0] * red + to[1, 1] * green + to[1, 2] * blue
            big_z = to[2, 0] * red + to[2, 1] * green + to[2, 2] * blue
            out[0, y, x] = np.float32(116) * big_y - np.float32(16)
            out[1, y, x] = np.float32(500) * (big_x - big_y)
            out[2, y, x] = np.float32(200) * (big_y - big_z)
    return out


@kernel()
def _hunt(luma: Map, red_green: Map, yellow_blue: Map, to: Map, back: Map) -> Map:
    """YCxCz, clipped to what a display has, as CIELAB with the Hunt effect: colours count less in the dark."""
    height, width = luma.shape
    out = np.empty((3, height, width), np.float32)
    for y in range(height):
        for x in range(width):
            big_y = (luma[y, x] + np.float32(16)) / np.float32(116)
            big_x = big_y + red_green[y, x] / np.float32(500)
            big_z = big_y - yellow_blue[y, x] / np.float32(200)
            red = min(max(back[0, 0] * big_x + back[0, 1] * big_y + back[0, 2] * big_z, np.float32(0)), np.float32(1))
            green = min(max(back[1, 0] * big_x + back[1, 1] * big_y + back[1, 2] * big_z, np.float32(0)), np.float32(1))
            blue = min(max(back[2, 0] * big_x + back[2, 1] * big_y + back[2, 2] * big_z, np.float32(0)), np.float32(1))
            f_x = lab_curve(to[0, 0] * red + to[0, 1] * green + to[0, 2] * blue)
            f_y = lab_curve(to[1, 0] * red + to[1, 1] * green + to[1, 2] * blue)
            f_z = lab_curve(to[2, 0] * red + to[2, 1] * green + to[2, 2] * blue)
            lightness = np.float32(116) * f_y - np.float32(16)
            out[0, y, x] = lightness
            out[1, y, x] = np.float32(0.01) * lightness * np.float32(500) * (f_x - f_y)
            out[2, y, x] = np.float32(0.01) * lightness * np.float32(200) * (f_y - f_z)
    return out


@kernel()
def _combine(
    lab_a: Map, lab_b: Map, edges_a: Map, edges_b: Map, points_a: Map, points_b: Map, largest: np.float32
) -> Map:
    height, width = edges_a.shape
    knee = np.float32(0.4) * largest
    out = np.empty((height, width), np.float32)
    for y in range(height):
        for x in range(width):
            red_green, yellow_blue = lab_a[1, y, x] - lab_b[1, y, x], lab_a[2, y, x] - lab_b[2, y, x]
            colour = abs(lab_a[0, y, x] - lab_b[0, y, x]) + np.sqrt(red_green**2 + yellow_blue**2)
            colour = colour ** np.float32(0.7)
            if colour < knee:
                colour *= np.float32(0.95) / knee
            else:
                colour = np.float32(0.95) + (colour - knee) / (largest - knee) * np.float32(0.05)
            feature = max(abs(edges_a[y, x] - edges_b[y, x]), abs(points_a[y, x] - points_b[y, x]))
            out[y, x] = colour ** (np.float32(1) - np.sqrt(feature * np.float32(0.70710678)))
    return out
