"""One kernel, K skins: the original and every compressed version, shaded on the same light paths.

Geometry, visibility and light do not depend on the skin. A path is traced once; at each of its points each skin costs
the lookup of its maps and the evaluation of its BSDF, and both images have the same noise, which cancels. What skins
have in common is computed once: Dr.Jit merges equal expressions, so that of skins with an albedo alone the two ends
of the affine function albedo · diffuse + specular serve all.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import ALBEDO
from facezip.files.obj import Topology
from render.lighting import Lights
from render.llvm import start
from render.mesh import HeadMesh
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

        between = MATERIALS[material](grey(0.5))
        self._frame, self.resolution, self._points = frame, resolution, TRANSPORTS[transport]
        self._head = HeadMesh(topology, between)
        self._scene = mi.load_dict({"type": "scene", "head": self._head.shape})
        self._parameters = mi.traverse(self._scene)
        self._lights = {rig: Lights(rig, frame) for rig in rigs}
        self._shading = SHADINGS[material]
        # Paths that all skins share bounce off grey.
        self._grey = mi.load_dict(between)
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
        import drjit as dr

        window, sampler = self._sampler(view, spp, seed)
        count = sampler.sample_count()
        radiance, covered = self._shade(rig, self._camera(view), sampler, window, skins)
        # Summed in fixed order; the samples have to be in memory before, or each sum traces them again.
        dr.eval(radiance, covered)
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
        import mitsuba as mi

        if self._points != 1:
            raise ValueError("only direct light is affine in the albedo")
        window, sampler = self._sampler(view, spp, seed)
        ray = self._rays(self._camera(view), sampler.next_2d(), window, sampler.sample_count())
        surface = self._scene.ray_intersect(ray, int(mi.RayFlags.All), True)
        head = surface.is_valid()
        direction, arriving = self._lights[rig].sample(self._scene, surface, sampler.next_2d(head), head)
        outgoing, finish = surface.to_local(direction), skin.finish(*_place(surface), head)
        colour = skin.colour(surface.uv, head)

        def radiance(finish: Finish) -> Any:
            diffuse, specular = self._shaded(surface, outgoing, finish)
            return (colour * diffuse + specular) * arriving

        diffuse, specular = self._shaded(surface, outgoing, finish)
        changes = slopes(finish, [name for name in skin.textures if name != ALBEDO], radiance)
        light = diffuse * arriving, specular * arriving
        return Paths(window, sampler.sample_count(), head, surface.uv, *light, changes)

    def triangles(self, view: View) -> NDArray[np.int32]:
        """The triangle ``(H, W)`` under the centre of each pixel of the posed head, -1 beside it."""
        import mitsuba as mi

        side = self.resolution
        ray = self._rays(self._camera(view), mi.Point2f(0.5), (0, 0, side, side), 1)
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
        self, rig: str, sensor: Any, sampler: Any, window: Window, skins: Sequence[Skin]
    ) -> tuple[list[Any], Any]:
        """Radiance of every sample with every skin, and whether the sample sees the head."""
        import drjit as dr
        import mitsuba as mi

        ray = self._rays(sensor, sampler.next_2d(), window, sampler.sample_count())
        radiance, throughput = [mi.Color3f(0.0) for _ in skins], [mi.Color3f(1.0) for _ in skins]
        active, covered = mi.Bool(True), mi.Float(0.0)
        for point in range(self._points):
            surface = self._scene.ray_intersect(ray, int(mi.RayFlags.All), point == 0, active)
            active = active & surface.is_valid()
            if point == 0:
                covered = dr.select(active, 1.0, 0.0)
            respond = self._response(surface, skins, active)
            direction, arriving = self._lights[rig].sample(self._scene, surface, sampler.next_2d(active), active)
            for k, reflected in enumerate(respond(surface.to_local(direction), arriving)):
                radiance[k] += dr.select(active, throughput[k] * reflected, 0.0)
            if point + 1 == self._points:
                break
            numbers = sampler.next_1d(active), sampler.next_2d(active)
            bounce, _ = self._grey.sample(mi.BSDFContext(), surface, *numbers, active)
            active = active & (bounce.pdf > 0)
            passed = respond(bounce.wo, dr.rcp(bounce.pdf))
            throughput = [t * part for t, part in zip(throughput, passed, strict=True)]
            ray = surface.spawn_ray(surface.to_world(bounce.wo))
        return radiance, covered

    def _response(self, surface: Any, skins: Sequence[Skin], active: Any) -> Callable[[Any, Any], list[Any]]:
        """What each skin makes of light along a local direction."""
        uv, handed = _place(surface)
        points = [(skin.colour(uv, active), skin.finish(uv, handed, active)) for skin in skins]

        def respond(outgoing: Any, light: Any) -> list[Any]:
            found = []
            for colour, finish in points:
                diffuse, specular = self._shaded(surface, outgoing, finish)
                found.append((colour * diffuse + specular) * light)
            return found

        return respond

    def _shaded(self, surface: Any, outgoing: Any, finish: Finish) -> tuple[Any, Any]:
        """The two parts of the BSDF, alike on both sides of the mesh."""
        import drjit as dr
        import mitsuba as mi

        eye, light = (mi.Vector3f(to.x, to.y, dr.mulsign(to.z, surface.wi.z)) for to in (surface.wi, outgoing))
        return self._shading(eye, light, finish)

    def _rays(self, sensor: Any, offset: Any, window: Window, count: int) -> Any:
        """``count`` camera rays for each pixel of a window, at ``offset`` in [0, 1]² within it."""
        import drjit as dr
        import mitsuba as mi

        left, top, width, height = window
        pixel = dr.arange(mi.UInt32, width * height * count) // count
        corner = mi.Point2f(mi.Float(pixel % width + left), mi.Float(pixel // width + top))
        ray, _ = sensor.sample_ray(0.0, 0.5, (corner + offset) / self.resolution, mi.Point2f(0.5))
        return ray


def stratified(spp: int) -> int:
    """The number of samples, at least ``spp``, that the sampler takes: strata that tile a pixel's square."""
    rows = math.isqrt(spp)
    return rows * -(-spp // rows)


def _place(surface: Any) -> tuple[Any, Any]:
    """Where in the maps a point is, and whether the chart is mirrored there: -1, else 1."""
    import drjit as dr

    # v of the mesh in the scene runs down, so that u × v points inwards where the chart is not mirrored.
    inwards = dr.dot(dr.cross(surface.dp_du, surface.dp_dv), surface.n)
    return surface.uv, dr.select(inwards > 0, -1.0, 1.0)
