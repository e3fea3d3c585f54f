"""A point of the skin: what it makes of light from one direction, and where light goes on from there."""

from collections.abc import Sequence
from typing import Any

from render.lighting import Lights
from render.shading import Finish, Shading
from render.skins import Skin

# Counted up whenever the same inputs give other images: finished shots on disk are of one revision.
REVISION = 2


class Points:
    """Points of one head, for any number of skins.

    Parameters
    ----------
    scene : the head alone.
    shading : one of :data:`render.shading.SHADINGS`.
    """

    def __init__(self, scene: Any, shading: Shading) -> None:
        self._scene, self._shading = scene, shading
        (self._mesh,) = scene.shapes()

    def met(self, ray: Any, active: Any = True, coherent: bool = False) -> Any:
        """The surface where an active ray meets the head, as round as its normals, which face whoever sees it."""
        import drjit as dr
        import mitsuba as mi

        hit = self._scene.ray_intersect_preliminary(ray, coherent, active)
        surface = hit.compute_surface_interaction(ray, int(mi.RayFlags.All), active)
        # At an outline a normal may turn away from the eye before its triangle does.
        surface.wi.z = dr.mulsign(dr.abs(surface.wi.z), -dr.dot(surface.n, ray.d))
        surface.p += self._lift(surface, hit, surface.is_valid())
        return surface

    def _lift(self, surface: Any, hit: Any, met: Any) -> Any:
        """From a triangle towards the smooth surface that its normals speak of, on the side that is seen.

        A light that grazes the smooth surface is behind some of its triangles, and shadows of these would show their
        edges as teeth: Hanika, "Hacking the Shadow Terminator" (2021).
        """
        import drjit as dr
        import mitsuba as mi

        corners = self._mesh.face_indices(surface.prim_index, met)
        u, v = hit.prim_uv
        lift = dr.zeros(mi.Vector3f)
        for corner, weight in zip(corners, (1 - u - v, u, v), strict=True):
            normal = dr.mulsign(mi.Vector3f(self._mesh.vertex_normal(corner, met)), surface.wi.z)
            below = dr.minimum(dr.dot(surface.p - self._mesh.vertex_position(corner, met), normal), 0.0)
            lift -= weight * below * normal
        return lift

    def lit(self, surface: Any, lights: Lights, number: Any, skins: Sequence[Skin]) -> list[Any]:
        """What each skin reflects of one sample of the lights, chosen by two uniform numbers; 0 off the head."""
        import drjit as dr

        met = surface.is_valid()
        direction, arriving = lights.sample(self._scene, surface, number, met)
        reflected = self.response(surface, skins, surface.to_local(direction), arriving)
        return [dr.select(met, light, 0.0) for light in reflected]

    def leaving(self, surface: Any, numbers: Any) -> tuple[Any, Any, Any]:
        """A local direction that all skins share, drawn by two numbers of a PCG; its density; and the ray along it.

        By the cosine, on the side that is seen: skin is matte but for a weak highlight, and to draw from that too costs
        more time than its noise is worth.
        """
        import drjit as dr
        import mitsuba as mi

        place = mi.Point2f(numbers.next_float32(), numbers.next_float32())
        direction = mi.warp.square_to_cosine_hemisphere(place)
        density = mi.warp.square_to_cosine_hemisphere_pdf(direction)
        direction.z = dr.mulsign(direction.z, surface.wi.z)
        return direction, density, surface.spawn_ray(surface.to_world(direction))

    def meets(self, ray: Any, active: Any) -> Any:
        """Whether a ray meets the head."""
        return self._scene.ray_test(ray, False, active)

    def response(self, surface: Any, skins: Sequence[Skin], outgoing: Any, light: Any) -> list[Any]:
        """What each skin makes of light along a local direction."""
        uv, handed = place(surface)
        met, found = surface.is_valid(), []
        for skin in skins:
            diffuse, specular = self.shaded(surface, outgoing, skin.finish(uv, handed, met))
            found.append((skin.colour(uv, met) * diffuse + specular) * light)
        return found

    def shaded(self, surface: Any, outgoing: Any, finish: Finish) -> tuple[Any, Any]:
        """The two parts of the BSDF, alike on both sides of the mesh."""
        import drjit as dr
        import mitsuba as mi

        eye, light = (mi.Vector3f(to.x, to.y, dr.mulsign(to.z, surface.wi.z)) for to in (surface.wi, outgoing))
        return self._shading(eye, light, finish)


def place(surface: Any) -> tuple[Any, Any]:
    """Where in the maps a point is, and whether the chart is mirrored there: -1, else 1."""
    import drjit as dr

    # v of the mesh in the scene runs down, so that u × v points inwards where the chart is not mirrored.
    inwards = dr.dot(dr.cross(surface.dp_du, surface.dp_dv), surface.n)
    return surface.uv, dr.select(inwards > 0, -1.0, 1.0)
