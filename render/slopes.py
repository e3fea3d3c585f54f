"""What the radiance of a sample makes of small changes of the maps that it is not linear in, by central differences."""

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any

from render.shading import Finish

# Of a value in [0, 1], or of a surface's slope, where it is 0.2°, about what a pack is off: at the silhouette, where
# relief turns to the light or away from it, there is no derivative, and differences of that size are what is wanted.
STEP = 3e-3

Radiance = Callable[[Finish], Any]


def slopes(finish: Finish, names: Iterable[str], radiance: Radiance) -> dict[str, tuple[Any, ...]]:
    """Derivatives of the radiance by each channel of each map, at samples.

    Parameters
    ----------
    finish : what the maps say there.
    names : of the maps, ``normal``, ``roughness``, ``specular``, ``cavity``.
    radiance : of a finish.

    Returns
    -------
    By map a colour for each channel: by the slopes x/z and y/z for normals, by the value for others.
    """
    return {
        name: _by_direction(finish, radiance) if name == "normal" else (_by_number(finish, name, radiance),)
        for name in names
    }


def _by_number(finish: Finish, name: str, radiance: Radiance) -> Any:
    import drjit as dr

    value = getattr(finish, name)
    low, high = dr.clip(value - STEP, 0, 1), dr.clip(value + STEP, 0, 1)
    below, above = (radiance(replace(finish, **{name: number})) for number in (low, high))
    return _finite((above - below) / (high - low))


def _by_direction(finish: Finish, radiance: Radiance) -> tuple[Any, Any]:
    import drjit as dr
    import mitsuba as mi

    across, down = finish.normal.x / finish.normal.z, finish.normal.y / finish.normal.z

    def tilted(x: float, y: float) -> Any:
        return radiance(replace(finish, normal=dr.normalize(mi.Vector3f(across + x, down + y, 1.0))))

    return (
        _finite((tilted(STEP, 0.0) - tilted(-STEP, 0.0)) / (2 * STEP)),
        _finite((tilted(0.0, STEP) - tilted(0.0, -STEP)) / (2 * STEP)),
    )


def _finite(colour: Any) -> Any:
    """Zero where a sample has no light to speak of."""
    import drjit as dr

    return dr.select(dr.isfinite(colour), colour, 0.0)
