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

Light is linear in the albedo alone, about whatever the other maps are: they are part of A and s. In normals,
roughness, specular and cavity it is not; there A is what an image makes of their small changes, by central differences
of the light of every sample, with |A| in the place of A: their changes brighten here and darken there. So the bound
holds for them to first order of their own errors, and each texel of each map has a weight in the same unit, by which
maps weigh against each other as well: a slope is seen or not, whatever its size beside a colour's.

Tiles are looked at as one texture (:class:`facezip.character.tiles.Atlas`), and the weights given back tile by tile.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import ALBEDO, Key
from facezip.character.scans import Character
from facezip.character.tiles import Atlas
from facezip.machine.progress import task
from render.operator import Channels, ImageOperator, image_operator, map_slopes
from render.paired import PairedRenderer
from render.sensitivity import display_slope, slope_weight, squared_error_weight
from render.skins import Skin, upload
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

    def operators(self, renderer: PairedRenderer, skin: Skin) -> Iterator[ImageOperator]:
        """The operator of every look at what is :func:`posed`, in their order; it acts on :func:`staged_albedo`."""
        for view, rig in self.looks:
            yield image_operator(renderer, skin, view, rig, self.spp, self.seed)

    def slopes(self, renderer: PairedRenderer, skin: Skin) -> Iterator[dict[str, tuple[Channels, ...]]]:
        """As :meth:`operators`, what small changes of the further maps do."""
        for view, rig in self.looks:
            yield map_slopes(renderer, skin, view, rig, self.spp, self.seed)


def posed(character: Character, renderer: PairedRenderer, expression: str) -> Skin:
    """Move the head into an expression; its skin, with all maps."""
    renderer.pose(character.mesh_vertices(expression))
    return upload(staged_original(character)(expression))


def staged_albedo(character: Character, expression: str) -> NDArray[np.float32]:
    """``(H, W, 3)`` encoded values in [0, 1], all tiles in one texture, three channels even of grey."""
    joined = np.clip(staged_map(character, ALBEDO, expression, character.texels), 0, 1)
    return joined if joined.shape[2] == 3 else np.repeat(joined[:, :, :1], 3, axis=2)


def seen_importance(character: Character, sight: Sight) -> dict[Key, NDArray[np.float32]]:
    """By map and tile, the weight ``(H, W)`` ≥ 0 of a texel's squared error, summed over expressions and looks.

    Exactly zero where no camera of ``sight`` sees the texel in any expression. Multiplied by squared errors of texels
    (0..1) and summed over texels and channels, it bounds the mean squared error of an image, to first order, times the
    number of images. Of the maps that renderers know.
    """
    total: dict[str, NDArray[np.float64]] = {}
    renderer = sight.renderer(character)
    with task("Looking at texels", len(character.expressions) * len(sight.looks)) as advance:
        for name in character.expressions:
            encoded, skin = staged_albedo(character, name), posed(character, renderer, name)
            looks = zip(sight.operators(renderer, skin), sight.slopes(renderer, skin), strict=True)
            for operator, changes in looks:
                for kind, weight in _weights(character, operator, changes, encoded).items():
                    total[kind] = total.get(kind, np.zeros(weight.shape)) + weight
                advance()
    atlas, found = Atlas.of(character.tiles), dict[Key, NDArray[np.float32]]()
    for kind, whole in total.items():
        sizes = {tile: stack.resolution for tile, stack in character.of_map(kind).items()}
        parts = atlas.summed(whole.astype(np.float32), sizes)
        found |= {(kind, tile): part for tile, part in parts.items()}
    return found


def _weights(
    character: Character,
    operator: ImageOperator,
    slopes: Mapping[str, tuple[Channels, ...]],
    encoded: NDArray[np.float32],
) -> dict[str, NDArray[np.float32]]:
    """Of one image, by map: means over its channels, the tiles in one texture."""
    found = {ALBEDO: squared_error_weight(operator, encoded) / np.float32(character.first.channels)}
    shown, values = display_slope(operator, encoded)
    for name, channels in slopes.items():
        # Of texels from 0 to 1, which span so many values.
        unit = np.float32(character.kind(name).unit ** 2 / (values * len(channels)))
        sizes = [stack.resolution for stack in character.of_map(name).values()]
        whole = Atlas.of(character.tiles).size(sizes)
        found[name] = unit * np.sum([slope_weight(matrices, shown) for matrices in channels], axis=0).reshape(whole)
    return found


def regularised(
    seen: Mapping[Key, NDArray[np.float32]], inside: Mapping[Key, NDArray[np.float32]], floor: float = FLOOR
) -> dict[Key, NDArray[np.float32]]:
    """The weights to fit with: in units of the albedo's mean over the face of all tiles, mixed with uniform ones.

    A map that does not show at all, as the roughness of a matte skin, has none.

    Parameters
    ----------
    seen : ``(H, W)`` by map and tile, of :func:`seen_importance`.
    inside : ``(H, W)`` by map and tile, the mask of the character.
    floor : in [0, 1], the share of each map's uniform weight: 0 trusts the cameras alone, 1 knows of them only how much
        maps count beside each other.
    """
    means = face_means(seen, inside)
    share, unit = np.float32(floor), np.float32(means[ALBEDO])
    return {
        key: (((1 - share) * one + share * np.float32(means[key[0]])) / unit).astype(np.float32)
        for key, one in seen.items()
        if means[key[0]] > 0
    }


def face_means(seen: Mapping[Key, NDArray[np.float32]], inside: Mapping[Key, NDArray[np.float32]]) -> dict[str, float]:
    """The mean of each map's weights over the face of all its tiles."""
    keys = {name: [key for key in seen if key[0] == name] for name in dict.fromkeys(name for name, _ in seen)}
    return {
        name: float(sum(np.vdot(seen[key], inside[key]) for key in own))
        / max(float(sum(inside[key].sum(dtype=np.float64) for key in own)), 1e-30)
        for name, own in keys.items()
    }
