"""One kernel, K skins: the original and every compressed version, shaded on the same light paths.

Geometry, visibility and light do not depend on the skin. A path is traced once; at each of its points each skin costs
the lookup of its maps and the evaluation of its BSDF, and both images have the same noise, which cancels. What skins
have in common is computed once: Dr.Jit merges equal expressions, so that of skins with an albedo alone the two ends
of the affine function albedo · diffuse + specular serve all.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import ALBEDO
from facezip.files.obj import Topology
from render.bounces import further_light, random_numbers
from render.lighting import Lights
from render.llvm import start
from render.mesh import HeadMesh
from render.points import Points, place
from render.shading import SHADINGS, Finish
from render.skins import Skin
from render.slopes import slopes
from scenes.cameras import Frame, View, camera, pixel_bounds
from scenes.materials import MATERIALS, grey

# First column and row, width and height of the pixels that are traced.
Window = tuple[int, int, int, int]

# Light that has met the skin this often: in a head, all that further points add is below a ten-thousandth.
TRANSPORTS = {"direct": 1, "full": 6}


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
    uv : where in the maps, row 0 at v = 0.
    diffuse, specular : its radiance is albedo · diffuse + specular.
    slopes : by map, but for the albedo, the derivatives of its radiance by each channel (:mod:`render.slopes`).
    """

    window: Window
    count: int
    head: Any
    uv: Any
    diffuse: Any
    specular: Any
    slopes: dict[str, tuple[Any, ...]]


class PairedRenderer:
    """Renders poses of one character, each with any number of skins, in one scene whose mesh moves.

    Parameters
    ----------
    topology : of the character's meshes.
    frame : where the neutral head is.
    rigs : names of the light rigs that will be used.
    material : a key of :data:`scenes.materials.MATERIALS`.
    resolution : width and height of the images.
    transport : a key of :data:`TRANSPORTS`: direct light, or light between parts of the skin as well.
    """

    def __init__(
        self,
        topology: Topology,
        frame: Frame,
        rigs: Sequence[str],
        material: str,
        resolution: int,
        transport: str = "direct",
    ) -> None:
        start()
        import mitsuba as mi

        self._frame, self.resolution, self._most = frame, resolution, TRANSPORTS[transport]
        self._head = HeadMesh(topology, MATERIALS[material](grey(0.5)))
        self._scene = mi.load_dict({"type": "scene", "head": self._head.shape})
        self._parameters = mi.traverse(self._scene)
        self._lights = {rig: Lights(rig, frame) for rig in rigs}
        self._points = Points(self._scene, SHADINGS[material])
        self._cameras: dict[View, Any] = {}
        self._vertices = np.zeros((0, 3), np.float32)

    def pose(self, vertices: NDArray[np.float32]) -> None:
        """Move the head to vertex positions ``(V, 3)``."""
        self._vertices = vertices
        self._head.move(self._parameters, vertices)

    def render(self, skins: Sequence[Skin], view: View, rig: str, spp: int, seed: int) -> Images:
        """Shade the posed head with each of K skins of :func:`render.skins.upload`.

        The same seed gives the same bits, whatever K, the other skins, and the number of threads.
        """
        window, sampler = self._sampler(view, spp, seed)
        count = sampler.sample_count()
        # In memory, or each of the sums, which are in fixed order, traces them again.
        radiance, covered = self._shade(self._lights[rig], self._camera(view), sampler, window, skins, seed)
        means = [[self._mean(channel, count, window) for channel in colour] for colour in radiance]
        return Images(np.moveaxis(np.array(means), 1, 3), self._mean(covered, count, window))

    def trace(self, skin: Skin, view: View, rig: str, spp: int, seed: int) -> Paths:
        """The direct light that :meth:`render` sees with the same arguments, before it meets the skin's albedo.

        What is not asked for of it is not computed.

        Raises
        ------
        ValueError
            For a renderer of full light transport, whose images are no affine function of the albedo.
        """
        import drjit as dr
        import mitsuba as mi

        if self._most != 1:
            raise ValueError("only direct light is affine in the albedo")
        window, sampler = self._sampler(view, spp, seed)
        offset = sampler.next_2d()
        pixel = dr.arange(mi.UInt32, dr.width(offset)) // sampler.sample_count()
        surface = self._points.met(self._rays(self._camera(view), offset, window, pixel), True, True)
        head = surface.is_valid()
        direction, arriving = self._lights[rig].sample(self._scene, surface, sampler.next_2d(head), head)
        outgoing, finish = surface.to_local(direction), skin.finish(*place(surface), head)
        colour = skin.colour(surface.uv, head)

        def radiance(finish: Finish) -> Any:
            diffuse, specular = self._points.shaded(surface, outgoing, finish)
            return (colour * diffuse + specular) * arriving

        diffuse, specular = self._points.shaded(surface, outgoing, finish)
        changes = slopes(finish, [name for name in skin.textures if name != ALBEDO], radiance)
        light = diffuse * arriving, specular * arriving
        return Paths(window, sampler.sample_count(), head, surface.uv, *light, changes)

    def triangles(self, view: View) -> NDArray[np.int32]:
        """The triangle ``(H, W)`` under the centre of each pixel of the posed head, -1 beside it."""
        import drjit as dr
        import mitsuba as mi

        side = self.resolution
        pixel = dr.arange(mi.UInt32, side * side)
        ray = self._rays(self._camera(view), mi.Point2f(0.5), (0, 0, side, side), pixel)
        hit = self._scene.ray_intersect_preliminary(ray, True)
        seen: NDArray[np.int32] = np.where(hit.is_valid(), hit.prim_index, -1).astype(np.int32).reshape(side, side)
        return seen

    def _sampler(self, view: View, spp: int, seed: int) -> tuple[Window, Any]:
        """The pixels that see the head, and random numbers for each of their samples."""
        import mitsuba as mi

        window = pixel_bounds(view, self._frame, self.resolution, self._vertices)
        sampler = mi.load_dict({"type": "multijitter", "sample_count": spp})
        sampler.set_samples_per_wavefront(sampler.sample_count())
        sampler.seed(seed, window[2] * window[3] * sampler.sample_count())
        return window, sampler

    def _mean(self, samples: Any, count: int, window: Window) -> NDArray[np.float32]:
        import drjit as dr

        left, top, width, height = window
        image = np.zeros((self.resolution, self.resolution), np.float32)
        image[top : top + height, left : left + width] = np.array(dr.block_sum(samples, count)).reshape(height, width)
        return image / np.float32(count)

    def _camera(self, view: View) -> Any:
        import mitsuba as mi

        if view not in self._cameras:
            self._cameras[view] = mi.load_dict(camera(view, self._frame, self.resolution))
        return self._cameras[view]

    def _shade(
        self, lights: Lights, sensor: Any, sampler: Any, window: Window, skins: Sequence[Skin], seed: int
    ) -> tuple[list[Any], Any]:
        """Radiance of every sample with every skin, and whether the sample sees the head, in memory."""
        import drjit as dr
        import mitsuba as mi

        count, offset = sampler.sample_count(), sampler.next_2d()
        lanes = dr.arange(mi.UInt32, dr.width(offset))
        surface = self._points.met(self._rays(sensor, offset, window, lanes // count), True, True)
        radiance = self._points.lit(surface, lights, sampler.next_2d(), skins)
        covered = dr.select(surface.is_valid(), 1.0, 0.0)
        if self._most == 1:
            dr.eval(radiance, covered)
            return radiance, covered
        _, density, onward = self._points.leaving(surface, random_numbers(lanes, seed))
        again = self._points.meets(onward, surface.is_valid() & (density > 0))
        dr.eval(radiance, covered, offset, again)
        kept = dr.compress(again)
        if dr.width(kept):
            ray = self._rays(sensor, dr.gather(mi.Point2f, offset, kept), window, kept // count)
            further = further_light(self._points, kept, ray, skins, lights, self._most, seed)
            for total, light in zip(radiance, further, strict=True):
                dr.scatter_reduce(dr.ReduceOp.Add, total, light, kept, mode=dr.ReduceMode.NoConflicts)
            dr.eval(radiance)
        return radiance, covered

    def _rays(self, sensor: Any, offset: Any, window: Window, pixel: Any) -> Any:
        """A camera ray through each of these pixels of a window, at ``offset`` in [0, 1]² within it."""
        import mitsuba as mi

        left, top, width, _ = window
        corner = mi.Point2f(mi.Float(pixel % width + left), mi.Float(pixel // width + top))
        ray, _ = sensor.sample_ray(0.0, 0.5, (corner + offset) / self.resolution, mi.Point2f(0.5))
        return ray


def stratified(spp: int) -> int:
    """The number of samples, at least ``spp``, that the sampler takes: strata that tile a pixel's square."""
    rows = math.isqrt(spp)
    return rows * -(-spp // rows)
