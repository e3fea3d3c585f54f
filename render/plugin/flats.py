"""Scenes with regions of one exact value, as tests have them: skies, backdrops, emitters, 8 bits, no noise at all."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from facezip.files.srgb import encode_srgb
from render.plugin.sources import scene_renderer
from scenes.plugins import Plugin

Image = NDArray[np.float32]

# Of the noisy part, and of the flat one: seen in floats, and in the codes of 8 bits.
NOISY_GAIN, FLAT_GAIN, FLAT_GAIN_8 = 1.05, 1.01, 1.05
# The least that what is flat changes by.
LIFT = np.float32(0.001)
# Renders that differ by less, relatively, differ by how sums of floats are rounded.
STILL = 1e-5
# How many scenes there are.
FLATS = 7


@dataclass(frozen=True)
class FlatScene:
    """A scene to be rendered.

    Attributes
    ----------
    name : what is flat about it.
    light : from a seed to ``(H, W, 3)`` linear values.
    in_8_bits : whether a test has them as an encoded 8-bit picture.
    """

    name: str
    light: Callable[[int], Image]
    in_8_bits: bool = False

    def pictures(self, light: Image) -> dict[str, Image]:
        """What tests compare of ``(n, H, W, 3)`` linear renders: ``equal``, or ``flat`` or ``noisy`` parts changed."""
        is_flat = np.ptp(light, axis=0) <= STILL * light.mean(axis=0)
        brighter = light + np.maximum((FLAT_GAIN_8 if self.in_8_bits else FLAT_GAIN) * light - light, LIFT)
        changed = {"equal": light, "flat": np.where(is_flat, brighter, light)}
        if not is_flat.all():
            changed["noisy"] = np.where(is_flat, light, np.float32(NOISY_GAIN) * light)
        return {name: self._picture(linear) for name, linear in changed.items()}

    def _picture(self, light: Image) -> Image:
        return np.round(255 * encode_srgb(np.clip(light, 0, 1))) / np.float32(255) if self.in_8_bits else light


def flat_scenes(value: NDArray[np.float64], resolution: int, spp: int) -> Iterator[FlatScene]:
    """Scenes of ``resolution`` pixels a side whose flat region has the three linear values ``value``, in [0, 0.95]."""
    sky = scene_renderer(_ball(value, resolution, {"type": "path", "max_depth": 3}), spp)
    yield FlatScene("sky of one value", sky)
    yield FlatScene("the same in 8 bits", sky, in_8_bits=True)
    yield FlatScene("emitter behind a ball", scene_renderer(_lit(value, resolution), spp))
    yield FlatScene("depth, no noise but at edges", scene_renderer(_ball(value, resolution, {"type": "depth"}), spp))
    yield FlatScene("ball before a sky, the same every time", lambda seed: sky(0))
    yield FlatScene("backdrop with Gaussian noise before it", lambda seed: _backdrop(value, resolution, seed))
    yield FlatScene("one value, no noise, 8 bits", lambda seed: _flat(value, resolution), in_8_bits=True)


def _ball(value: NDArray[np.float64], resolution: int, integrator: Plugin) -> Plugin:
    """A ball before a sky of one value, which is all its light."""
    film = {"type": "hdrfilm", "width": resolution, "height": resolution, "rfilter": {"type": "box"}}
    return {
        "type": "scene",
        "integrator": integrator,
        "ball": {"type": "sphere", "center": [0, 0, 4], "bsdf": {"type": "diffuse"}},
        "sky": {"type": "constant", "radiance": {"type": "rgb", "value": value.tolist()}},
        "sensor": {"type": "perspective", "fov": 45, "film": film},
    }


def _lit(value: NDArray[np.float64], resolution: int) -> Plugin:
    """A ball between the camera and a wall that shines."""
    import mitsuba as mi

    wall = mi.ScalarTransform4f().translate([0, 0, 7]).rotate([0, 1, 0], 180).scale(9)
    radiance = {"type": "area", "radiance": {"type": "rgb", "value": value.tolist()}}
    scene = _ball(value, resolution, {"type": "path", "max_depth": 3})
    del scene["sky"]
    return {
        **scene,
        "wall": {"type": "rectangle", "to_world": wall, "emitter": radiance},
        "lamp": {"type": "point", "position": [3, 3, -2], "intensity": {"type": "rgb", "value": 10.0}},
    }


def _flat(value: NDArray[np.float64], resolution: int) -> Image:
    return np.broadcast_to(value.astype(np.float32), (resolution, resolution, 3)).copy()


def _backdrop(value: NDArray[np.float64], resolution: int, seed: int) -> Image:
    image, quarter = _flat(value, resolution), resolution // 4
    inside = image[quarter : 3 * quarter, quarter : 3 * quarter]
    inside[:] = np.random.default_rng(seed).normal(0.5, 0.05, inside.shape)
    return image
