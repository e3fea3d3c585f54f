"""One kernel, K textures: the original and every compressed version, shaded on the same light paths.

Geometry, visibility and light do not depend on the texture. A camera ray and a light sample are traced once; the skin
is affine in its albedo, so each texture costs one lookup and one multiplication, and the differences between the
images carry no noise but their own.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.meshes import Topology
from facezip.textures import decode_srgb
from render.llvm import start
from render.mesh import HeadMesh
from scenes.cameras import Frame, View, camera, pixel_bounds
from scenes.materials import MATERIALS, grey
from scenes.stage import stage

# First column and row, width and height of the pixels that are traced.
Window = tuple[int, int, int, int]


@dataclass(frozen=True, eq=False)
class Images:
    """K renders of one pose.

    Attributes
    ----------
    linear : ``(K, H, W, 3)`` float32 scene-linear radiance of the head, premultiplied with its coverage.
    coverage : ``(H, W)`` float32 in [0, 1], how much of a pixel the head fills.
    """

    linear: NDArray[np.float32]
    coverage: NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Paths:
    """A camera ray and a light sample each, ``count`` to a pixel, pixel after pixel, as Dr.Jit arrays.

    Attributes
    ----------
    window : the pixels.
    count : samples of a pixel.
    head : whether a sample sees the head; what follows holds where it does.
    uv : where in the texture, row 0 at v = 0.
    diffuse, specular : its radiance is albedo · diffuse + specular.
    """

    window: Window
    count: int
    head: Any
    uv: Any
    diffuse: Any
    specular: Any


class PairedRenderer:
    """Renders poses of one character, each with any number of textures, under direct light.

    Parameters
    ----------
    topology : of the character's meshes.
    frame : where the neutral head is.
    rigs : names of the light rigs that will be used.
    material : a key of :data:`scenes.materials.MATERIALS`.
    resolution : width and height of the images.
    """

    def __init__(self, topology: Topology, frame: Frame, rigs: Sequence[str], material: str, resolution: int) -> None:
        start()
        import mitsuba as mi

        skin = MATERIALS[material]
        self._frame, self._resolution = frame, resolution
        self._heads = {rig: HeadMesh(topology, skin(grey(0.5))) for rig in rigs}
        self._scenes = {rig: mi.load_dict(stage(head.shape, frame, rig)) for rig, head in self._heads.items()}
        self._parameters = {rig: mi.traverse(scene) for rig, scene in self._scenes.items()}
        # The two ends of the affine function: all that the kernel needs to know of the skin.
        self._black, self._white = (mi.load_dict(skin(grey(albedo))) for albedo in (0.0, 1.0))
        self._cameras: dict[View, Any] = {}
        self._vertices = np.zeros((0, 3), np.float32)

    def pose(self, vertices: NDArray[np.float32]) -> None:
        """Move the head to vertex positions ``(V, 3)``."""
        self._vertices = vertices
        for rig, head in self._heads.items():
            head.move(self._parameters[rig], vertices)

    def render(self, maps: Sequence[Any], view: View, rig: str, spp: int, seed: int) -> Images:
        """Shade the posed head with each of K textures that :func:`upload` gave.

        The same seed gives the same bits, whatever K, the other textures, and the number of threads.
        """
        return self.shade(self.trace(view, rig, spp, seed), maps)

    def shade(self, paths: Paths, maps: Sequence[Any]) -> Images:
        """Images of what :meth:`trace` gave, with each of K textures that :func:`upload` gave."""
        import drjit as dr
        import mitsuba as mi

        colours = [mi.Color3f(texture.eval(paths.uv, paths.head)) for texture in maps]
        radiance = [dr.select(paths.head, colour * paths.diffuse + paths.specular, 0) for colour in colours]
        covered = dr.select(paths.head, 1.0, 0.0)
        # Summed in fixed order; the samples have to be in memory before, or each sum traces them again.
        dr.eval(radiance, covered)
        means = [[self._mean(channel, paths) for channel in colour] for colour in radiance]
        return Images(np.moveaxis(np.array(means), 1, 3), self._mean(covered, paths))

    def trace(self, view: View, rig: str, spp: int, seed: int) -> Paths:
        """The light paths that :meth:`render` takes with the same arguments; traced when they are first used."""
        import mitsuba as mi

        window = pixel_bounds(view, self._frame, self._resolution, self._vertices)
        sampler = mi.load_dict({"type": "multijitter", "sample_count": spp})
        count = sampler.sample_count()
        sampler.set_samples_per_wavefront(count)
        sampler.seed(seed, window[2] * window[3] * count)
        scene = self._scenes[rig]
        ray = self._primary_rays(self._camera(view), sampler, window)
        surface = scene.ray_intersect(ray, int(mi.RayFlags.All), True)
        head = surface.is_valid() & (surface.shape == mi.ShapePtr(self._heads[rig].shape))
        light, arriving = _sample_light(scene, surface, sampler.next_2d(head), head)
        outgoing = surface.to_local(light.d)
        context = mi.BSDFContext()
        specular = self._black.eval(context, surface, outgoing, head)
        diffuse = self._white.eval(context, surface, outgoing, head) - specular
        return Paths(window, count, head, surface.uv, diffuse * arriving, specular * arriving)

    def _mean(self, samples: Any, paths: Paths) -> NDArray[np.float32]:
        import drjit as dr

        left, top, width, height = paths.window
        image = np.zeros((self._resolution, self._resolution), np.float32)
        sums = np.array(dr.block_sum(samples, paths.count)).reshape(height, width)
        image[top : top + height, left : left + width] = sums
        return image / np.float32(paths.count)

    def _camera(self, view: View) -> Any:
        import mitsuba as mi

        if view not in self._cameras:
            self._cameras[view] = mi.load_dict(camera(view, self._frame, self._resolution))
        return self._cameras[view]

    def _primary_rays(self, sensor: Any, sampler: Any, window: Window) -> Any:
        import drjit as dr
        import mitsuba as mi

        left, top, width, height = window
        pixel = dr.arange(mi.UInt32, width * height * sampler.sample_count()) // sampler.sample_count()
        corner = mi.Point2f(mi.Float(pixel % width + left), mi.Float(pixel // width + top))
        position = (corner + sampler.next_2d()) / self._resolution
        ray, _ = sensor.sample_ray(0.0, 0.5, position, mi.Point2f(0.5))
        return ray


def _sample_light(scene: Any, surface: Any, sample: Any, active: Any) -> tuple[Any, Any]:
    """A direction to a light and what arrives from there, with its shadow.

    The scene's own sampling numbers the lights as they lie in memory, differently in every process; here they are
    taken in the order of their names.
    """
    import drjit as dr
    import mitsuba as mi

    lights = sorted(scene.emitters(), key=lambda emitter: str(emitter.id()))
    weights = np.array([float(np.array(light.sampling_weight()).item()) for light in lights])
    share = weights / weights.sum()
    first = np.cumsum(share) - share
    index = dr.zeros(mi.UInt32, dr.width(sample))
    for begin in first[1:]:
        index += dr.select(sample.x >= float(begin), mi.UInt32(1), mi.UInt32(0))
    offset, chance = (dr.gather(mi.Float, mi.Float(values), index) for values in (first, share))
    light = dr.gather(mi.EmitterPtr, dr.concat([mi.EmitterPtr(light) for light in lights]), index, active)
    reused = mi.Point2f((sample.x - offset) / chance, sample.y)
    direction, arriving = light.sample_direction(surface, reused, active)
    shadowed = scene.ray_test(surface.spawn_ray_to(direction.p), True, active)
    return direction, dr.select(shadowed, 0.0, arriving / chance)


def upload(encoded: NDArray[np.float32]) -> Any:
    """A texture ``(H, W, C)`` of encoded values in [0, 1] for the kernel: linear, bilinear, clamped at its borders."""
    start()
    import drjit as dr
    import mitsuba as mi

    colour = encoded if encoded.shape[2] == 3 else np.repeat(encoded[:, :, :1], 3, axis=2)
    texture = mi.Texture2f(
        mi.TensorXf(decode_srgb(colour)), filter_mode=dr.FilterMode.Linear, wrap_mode=dr.WrapMode.Clamp
    )
    # A texture uploads itself on first use; inside a recorded kernel that would be too late.
    dr.eval(texture.eval(mi.Point2f(0.5)))
    return texture
