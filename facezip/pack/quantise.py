"""From float maps to the bytes that a pack stores and a GPU samples, and back."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import Key, Map
from facezip.character.meshes import Meshes
from facezip.character.neutrals import packed_neutral, unpacked_neutral
from facezip.files.images import Texels, to_float
from facezip.machine import memory
from facezip.machine.kernels import kernel
from facezip.machine.rows import by_rows, map_rows, sum_rows
from facezip.pack.masked import MaskedWeights
from facezip.pack.model import CompressedTextures, Part

# Zero is this byte exactly, so that texels which no expression changes stay untouched.
ZERO = 128
# Steps from there to the end of a difference texture's range, on either side.
STEPS = 127
_BINS = 2048


@dataclass(frozen=True, eq=False)
class StoredPart:
    """One map on one tile as integers, with the spans that turn texels t = byte / 255 back into values.

    Attributes
    ----------
    neutral : the image ``(H, W, C)``, uint8 or uint16; of three channels for normals
        (:mod:`facezip.character.neutrals`).
    differences : ``(R, H, W, C)`` uint8; D = (t - 128/255) · ``span``.
    span : ``(R, C)`` float32, one a texture and channel.
    """

    neutral: Texels
    differences: NDArray[np.uint8]
    span: NDArray[np.float32]

    @property
    def bits(self) -> int:
        """Of a channel of the neutral."""
        return 8 * self.neutral.itemsize


@dataclass(frozen=True, eq=False)
class StoredWeights:
    """The weight maps of a tile.

    Attributes
    ----------
    texels : ``(N, h, w, R)`` uint8, W = t · ``span`` + ``offset``; or float32 ``(N, 1, 1, R)`` as they are where
        weights are uniform: those are shader constants, not texels.
    span, offset : ``(R,)`` float32, one a slot; 1 and 0 for uniform weights.
    """

    texels: NDArray[np.uint8] | NDArray[np.float32]
    span: NDArray[np.float32]
    offset: NDArray[np.float32]

    @property
    def uniform(self) -> bool:
        """Whether every weight map is a single number (PCA)."""
        return self.texels.shape[1:3] == (1, 1)

    @property
    def values(self) -> NDArray[np.float32]:
        """``(N, h, w, R)`` float32, as a shader sees them."""
        if self.uniform:
            return self.texels.astype(np.float32)
        step = self.span / np.float32(255)
        return by_rows(lambda rows: self.texels[:, rows] * step + self.offset, self.texels.shape, np.float32, axis=1)


@dataclass(frozen=True, eq=False)
class StoredTextures:
    """What a pack holds; attributes as of :class:`facezip.pack.model.CompressedTextures`."""

    method: str
    expressions: tuple[str, ...]
    maps: tuple[Map, ...]
    parts: Mapping[Key, StoredPart]
    weights: Mapping[int, StoredWeights] | MaskedWeights
    meshes: Meshes | None = None

    def weight_maps(self, tile: int) -> StoredWeights:
        """The weight maps of a tile as bytes; those that are made of masks are rounded, each slot over its range."""
        stored = self.weights[tile]
        return quantise_weights(stored) if isinstance(stored, np.ndarray) else stored

    def dequantised(self) -> CompressedTextures:
        """The model that a reader sees; inverse of :func:`quantise` up to rounding."""
        kinds = {kind.name: kind for kind in self.maps}
        parts = {key: dequantise_part(part, kinds[key[0]]) for key, part in self.parts.items()}
        weights: Mapping[int, NDArray[np.float32]] = (
            self.weights
            if isinstance(self.weights, MaskedWeights)
            else {tile: stored.values for tile, stored in self.weights.items()}
        )
        return CompressedTextures(self.method, self.expressions, self.maps, parts, weights, self.meshes)


def quantise(model: CompressedTextures) -> StoredTextures:
    """Round a model to 8 bits a channel (neutrals to 8 or 16), each range stretched to use them fully."""
    kinds = {kind.name: kind for kind in model.maps}
    parts = {key: quantise_part(part, kinds[key[0]]) for key, part in model.parts.items()}
    ranges = model.weight_ranges
    weights = model.masked or {
        tile: quantise_weights(values, ranges.get(tile)) for tile, values in model.weights.items()
    }
    return StoredTextures(model.method, model.expressions, model.maps, parts, weights, model.meshes)


def quantise_part(part: Part, kind: Map) -> StoredPart:
    """Neutral and differences of one map on one tile, as bytes."""
    ranges = part.difference_range
    if ranges is None:
        ranges = _largest(part.differences)
    # Kernels read rows as they lie.
    values = np.require(part.differences, requirements="C")
    differences: NDArray[np.uint8] = memory.empty(values.shape, np.uint8)
    # A byte of 0 is a step beyond the range, which no fit needs, but a painted layer may have.
    low = np.array([-ZERO if slot in part.locked else -STEPS for slot in range(len(values))], np.float32)
    limits = ranges.astype(np.float32)
    map_rows(lambda top, bottom: _round_differences(top, bottom, values, limits, low, differences), len(differences[0]))
    neutral = packed_neutral(part.neutral, kind, part.bits) if part.packed is None else part.packed
    # Doubles give back the very span of another pack.
    return StoredPart(neutral, differences, (ranges * ranges.dtype.type(255 / STEPS)).astype(np.float32))


def dequantise_part(stored: StoredPart, kind: Map) -> Part:
    """Inverse of :func:`quantise_part` up to rounding."""
    steps = stored.span / np.float32(255)
    texels = np.require(stored.differences, requirements="C")
    differences: NDArray[np.float32] = memory.empty(texels.shape, np.float32)
    map_rows(lambda top, bottom: _difference_values(top, bottom, texels, steps, differences), len(differences[0]))
    return Part(to_float(unpacked_neutral(stored.neutral, kind)), differences, stored.bits)


def quantise_weights(weights: NDArray[np.float32], ranges: NDArray[np.float32] | None = None) -> StoredWeights:
    """Weight maps ``(N, h, w, R)`` as bytes, each slot's range stretched over all maps.

    ``ranges`` ``(2, R)`` are offset and span of each slot where they are chosen already, NaN where not.
    """
    if weights.shape[1:3] == (1, 1):
        slots = weights.shape[3]
        return StoredWeights(weights, np.ones(slots, np.float32), np.zeros(slots, np.float32))

    def extent(top: int, bottom: int) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        part = weights[:, top:bottom]
        return part.min(axis=(0, 1, 2)), part.max(axis=(0, 1, 2))

    parts = map_rows(extent, weights.shape[1])
    offset: NDArray[np.float32] = np.min([low for low, _ in parts], axis=0)
    span: NDArray[np.float32] = np.max([high for _, high in parts], axis=0) - offset
    if ranges is not None:
        offset, span = np.where(np.isnan(ranges), [offset, span], ranges).astype(np.float32)
    return StoredWeights(weight_bytes(weights, offset, span), span, offset)


def weight_bytes(
    weights: NDArray[np.float32], offset: NDArray[np.float32], span: NDArray[np.float32]
) -> NDArray[np.uint8]:
    """Weight maps ``(N, h, w, R)`` as bytes of a range ``(R,)`` that holds them."""
    # Where the range is empty the values are zero and stay so.
    divisor = np.where(span > 0, span, np.float32(1))

    def rounded(rows: slice) -> NDArray[np.uint8]:
        # The sum of offset and span is rounded too.
        steps = np.rint((weights[:, rows] - offset) / divisor * np.float32(255))
        return steps.clip(0, 255).astype(np.uint8)

    return by_rows(rounded, weights.shape, np.uint8, axis=1)


def best_ranges(differences: NDArray[np.float32], importance: NDArray[np.float32]) -> NDArray[np.float32]:
    """The range ``(R, C)`` of each texture and channel that costs least when stored in ±127 steps.

    A smaller range has smaller steps for all texels and clips a few: the sum of both errors is taken from a histogram
    of the values ``(R, H, W, C)`` where ``importance`` ``(H, W)`` is positive.
    """
    ranges = _largest(differences)
    counts = sum_rows(lambda top, bottom: _histogram(top, bottom, differences, importance, ranges), len(importance))
    value = (np.arange(_BINS) + 0.5) / _BINS
    # As parts of the largest value: the error of steps of a range, and of what lies beyond it.
    above = counts[..., ::-1].cumsum(axis=2)[..., ::-1]
    first = (counts * value)[..., ::-1].cumsum(axis=2)[..., ::-1]
    second = (counts * value**2)[..., ::-1].cumsum(axis=2)[..., ::-1]
    clipped = second - 2 * value * first + value**2 * above
    stepped = above[..., :1] * (value / STEPS) ** 2 / 12
    best = (clipped + stepped).argmin(axis=2)
    chosen: NDArray[np.float32] = (ranges * (best + 1) / _BINS).astype(np.float32)
    return np.maximum(chosen, np.float32(1e-12))


@kernel(error_model="numpy")
def _round_differences(
    top: int,
    bottom: int,
    values: NDArray[np.float32],
    ranges: NDArray[np.float32],
    low: NDArray[np.float32],
    out: NDArray[np.uint8],
) -> None:
    slots, _, width, channels = values.shape
    # Flat rows, with a factor beside every value, fill vector registers; three channels do not.
    per_unit = np.empty(width * channels, np.float32)
    for i in range(slots):
        for k in range(width * channels):
            per_unit[k] = np.float32(STEPS) / max(ranges[i, k % channels], np.float32(1e-30))
        for y in range(top, bottom):
            row, target = values[i, y].reshape(-1), out[i, y].reshape(-1)
            for k in range(width * channels):
                step = np.rint(row[k] * per_unit[k])
                target[k] = np.uint8(min(max(step, low[i]), np.float32(STEPS)) + np.float32(ZERO))


@kernel()
def _difference_values(
    top: int, bottom: int, stored: NDArray[np.uint8], steps: NDArray[np.float32], out: NDArray[np.float32]
) -> None:
    slots, _, width, channels = stored.shape
    step = np.empty(width * channels, np.float32)
    for i in range(slots):
        for k in range(width * channels):
            step[k] = steps[i, k % channels]
        for y in range(top, bottom):
            row, target = stored[i, y].reshape(-1), out[i, y].reshape(-1)
            for k in range(width * channels):
                target[k] = (np.float32(row[k]) - np.float32(ZERO)) * step[k]


@kernel(error_model="numpy")
def _histogram(
    top: int,
    bottom: int,
    differences: NDArray[np.float32],
    importance: NDArray[np.float32],
    ranges: NDArray[np.float32],
) -> NDArray[np.float64]:
    slots, _, width, channels = differences.shape
    counts = np.zeros((slots, channels, _BINS))
    for i in range(slots):
        per_bin = np.float32(_BINS) / np.maximum(ranges[i], np.float32(1e-30))
        for y in range(top, bottom):
            for x in range(width):
                if importance[y, x] > 0:
                    for c in range(channels):
                        part = abs(differences[i, y, x, c]) * per_bin[c]
                        counts[i, c, min(int(part), _BINS - 1)] += 1
    return counts


def _largest(differences: NDArray[np.float32]) -> NDArray[np.float32]:
    """The largest absolute value of each texture and channel, ``(R, C)``."""
    parts = map_rows(lambda top, bottom: np.abs(differences[:, top:bottom]).max(axis=(1, 2)), differences.shape[1])
    largest: NDArray[np.float32] = np.max(parts, axis=0)
    return largest
