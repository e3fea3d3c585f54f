"""How much a texel's error counts in the images of given views and lights: the weight of an importance-weighted fit.

A pack's error δ is made in encoded (sRGB) texels and judged in encoded pixels. With x = decode(e) the linear texture
and y = encode(A x + s) the displayed image, to first order an image changes by J δ with

    J = diag(encode'(A x + s)) · A · diag(decode'(e)),

zero in pixels without the head and where the display clips. The squared image error ‖J δ‖² is no sum over texels, as a
pixel sees several of them; but as J ≥ 0, by Cauchy and Schwarz

    ‖J δ‖² ≤ Σ_t w_t δ_t²   with   w = Jᵀ J 1,

with equality where the error is the same in all the texels of a pixel. That is the weight here, divided by the number
of values of an image and summed over images and channels: twice through the operator, in milliseconds. The other
candidates are the diagonal w_t = Σ_p J_pt², right for errors that are independent from texel to texel, and plain Aᵀ1,
which knows neither of display encoding nor that errors are squared. Measured, they are close to each other, and this
one alone gained on every character and floor that was tried (docs/importance.md).

Light is linear in the albedo alone, about whatever the other maps are: normals, roughness, specular and cavity are
part of A and s, and the weight is exact for errors of the albedo. The others have no such operator, and a fit has one
weight a texel: theirs is the albedo's. Where a texel is seen, how large and in how much light is the same for all of
them; what it leaves out are highlights, in which they count and the albedo does not.

Tiles are looked at as one texture (:class:`facezip.character.tiles.Atlas`), and the weights given back tile by tile.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import ALBEDO
from facezip.character.scans import NEUTRAL, Character
from facezip.character.tiles import Atlas
from facezip.files.srgb import decode_srgb
from facezip.machine.progress import task
from render.operator import ImageOperator, image_operator
from render.paired import PairedRenderer
from render.staging import staged_map, staged_original, staged_topology
from scenes.cameras import View, frame_of

# Of the mean weight: what a texel counts that no camera of the set sees. Others may.
FLOOR = 0.3

Look = tuple[View, str]


@dataclass(frozen=True)
class Sight:
    """What looks at a character.

    Attributes
    ----------
    looks : pairs of a view and the name of a light rig.
    resolution : width and height of the images in pixels.
    spp : samples per pixel.
    seed : of the random numbers.
    material : a key of :data:`scenes.materials.MATERIALS`.
    """

    looks: tuple[Look, ...]
    resolution: int = 512
    spp: int = 16
    seed: int = 0
    material: str = "skin"

    def renderer(self, character: Character) -> PairedRenderer:
        """For all the lights of the looks."""
        rigs = list(dict.fromkeys(rig for _, rig in self.looks))
        frame = frame_of(character.meshes.neutral)
        return PairedRenderer(staged_topology(character), frame, rigs, self.material, self.resolution)

    def operators(self, character: Character, renderer: PairedRenderer, expression: str) -> Iterator[ImageOperator]:
        """The operator of every look at an expression with all its maps, in their order.

        It acts on :func:`staged_albedo`.
        """
        renderer.pose(character.mesh_vertices(expression))
        maps = staged_original(character)(expression)
        for view, rig in self.looks:
            yield image_operator(renderer, maps, view, rig, self.spp, self.seed)


def staged_albedo(character: Character, expression: str) -> NDArray[np.float32]:
    """``(H, W, 3)`` encoded values in [0, 1], all tiles in one texture, three channels even of grey."""
    joined = np.clip(staged_map(character, ALBEDO, expression, character.texels), 0, 1)
    return joined if joined.shape[2] == 3 else np.repeat(joined[:, :, :1], 3, axis=2)


def seen_importance(character: Character, sight: Sight) -> dict[int, NDArray[np.float32]]:
    """By tile, the weight ``(H, W)`` ≥ 0 of a texel's squared error, summed over expressions, looks and channels.

    Exactly zero where no camera of ``sight`` sees the texel in any expression. Multiplied by squared errors of the
    albedo (encoded, 0..1) and summed, it bounds the mean squared error of an image, to first order, times the number of
    images.
    """
    total = np.zeros(staged_albedo(character, NEUTRAL).shape[:2], np.float64)
    renderer = sight.renderer(character)
    with task("Looking at texels", len(character.expressions) * len(sight.looks)) as advance:
        for name in character.expressions:
            encoded = staged_albedo(character, name)
            for operator in sight.operators(character, renderer, name):
                total += squared_error_weight(operator, encoded)
                advance()
    sizes = {tile: stack.resolution for tile, stack in character.of_map(ALBEDO).items()}
    return Atlas.of(character.tiles).summed(total.astype(np.float32), sizes)


def squared_error_weight(operator: ImageOperator, encoded: NDArray[np.float32]) -> NDArray[np.float32]:
    """Jᵀ J 1 of one image, over its number of head pixels and channels, summed over channels: ``(h, w)`` ≥ 0.

    Parameters
    ----------
    operator : of the image.
    encoded : ``(h, w, 3)`` texture in [0, 1], about which the error is small.
    """
    head = operator.coverage >= 0.5
    slope = _decode_slope(encoded)
    shown = _encode_slope(operator.image(decode_srgb(encoded))) * head[:, :, None]
    weights = slope * operator.transposed(np.square(shown) * operator.apply(slope))
    total: NDArray[np.float32] = weights.sum(axis=2) / np.float32(max(3 * int(head.sum()), 1))
    return total


def regularised(
    seen: Mapping[int, NDArray[np.float32]], inside: Mapping[int, NDArray[np.float32]], floor: float = FLOOR
) -> dict[int, NDArray[np.float32]]:
    """The weights to fit with, by tile: scaled to a mean of 1 over the face of all tiles, and mixed with a uniform one.

    Parameters
    ----------
    seen : ``(H, W)`` by tile, of :func:`seen_importance`.
    inside : ``(H, W)`` by tile, the mask of the character.
    floor : in [0, 1], the share of the uniform weight: 0 trusts the cameras alone, 1 ignores them.
    """
    total = sum(np.vdot(seen[tile], inside[tile]) for tile in seen)
    mean = np.float32(total / sum(inside[tile].sum(dtype=np.float64) for tile in seen))
    scaled = {tile: one / mean if mean > 0 else np.ones_like(one) for tile, one in seen.items()}
    return {tile: (np.float32(1 - floor) * one + np.float32(floor)).astype(np.float32) for tile, one in scaled.items()}


def _decode_slope(encoded: NDArray[np.float32]) -> NDArray[np.float32]:
    """Derivative of :func:`facezip.files.srgb.decode_srgb`."""
    high = 2.4 / 1.055 * np.power((np.maximum(encoded, 0.04045) + 0.055) / 1.055, 1.4)
    return np.where(encoded <= 0.04045, 1 / 12.92, high).astype(np.float32)


def _encode_slope(linear: NDArray[np.float32]) -> NDArray[np.float32]:
    """Derivative of what a display shows: of clipping to [0, 1] and :func:`facezip.files.srgb.encode_srgb`."""
    high = 1.055 / 2.4 * np.power(np.maximum(linear, 0.0031308), 1 / 2.4 - 1)
    slope = np.where(linear <= 0.0031308, 12.92, high)
    return np.where((linear < 0) | (linear > 1), 0, slope).astype(np.float32)
