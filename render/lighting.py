"""The lights of a rig, sampled the same way in every process, and the shadows that a head casts in them."""

from typing import Any

import numpy as np

from scenes.cameras import Frame
from scenes.lights import RIGS


class Lights:
    """The emitters of one rig, in the order of their names.

    They stand outside the scene that rays are traced in: a light casts no shadow and blocks no view. A scene's own
    sampling would number them as they lie in memory, differently in every process.

    Parameters
    ----------
    rig : a key of :data:`scenes.lights.RIGS`.
    frame : where the head is.
    """

    def __init__(self, rig: str, frame: Frame) -> None:
        import mitsuba as mi

        # An environment begins outside its scene's bounds.
        bounds = {"type": "sphere", "center": list(frame.centre), "radius": frame.height}
        self._scene = mi.load_dict({"type": "scene", "bounds": bounds, **RIGS[rig](frame)})
        self._emitters = sorted(self._scene.emitters(), key=lambda emitter: str(emitter.id()))
        weights = np.array([float(np.array(light.sampling_weight()).item()) for light in self._emitters])
        self._shares = weights / weights.sum()

    def sample(self, scene: Any, surface: Any, sample: Any, active: Any) -> tuple[Any, Any]:
        """A direction to a light, in world space, and what arrives from there over its density, with its shadow.

        Parameters
        ----------
        scene : what casts shadows.
        surface : the points that are lit.
        sample : two uniform numbers; the first chooses the light.
        """
        import drjit as dr
        import mitsuba as mi

        point, direction, arriving = dr.zeros(mi.Point3f), dr.zeros(mi.Vector3f), dr.zeros(mi.Color3f)
        begin = 0.0
        # A call per light costs less than one call that branches between them.
        for light, share in zip(self._emitters, self._shares.tolist(), strict=True):
            chosen = (sample.x >= begin) & (sample.x < begin + share) if len(self._emitters) > 1 else mi.Bool(True)
            reused = mi.Point2f((sample.x - begin) / share, sample.y)
            found, radiance = light.sample_direction(surface, reused, active & chosen)
            point, direction = dr.select(chosen, found.p, point), dr.select(chosen, found.d, direction)
            arriving = dr.select(chosen, radiance / share, arriving)
            begin += share
        # On the side that is seen: of a mask of a face the inside, of faces wound clockwise the outside.
        lit = active & (dr.dot(direction, surface.sh_frame.n) * surface.wi.z > 0)
        shadowed = scene.ray_test(surface.spawn_ray_to(point), False, lit)
        return direction, dr.select(lit & ~shadowed, arriving, 0.0)
