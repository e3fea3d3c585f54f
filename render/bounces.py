"""Light that goes from skin to skin.

Of a head, which is round, one path in twenty meets the skin again. Whether it does is asked of all; the skins are asked
what they pass of those alone, in a kernel as wide as there are such paths.
"""

from collections.abc import Sequence
from typing import Any

from render.lighting import Lights
from render.points import Points
from render.skins import Skin

# Samples of the lights at each further point: those are few, and their highlights make most of the noise.
LIGHTS = 2


def random_numbers(sample: Any, seed: int) -> Any:
    """A sequence of random numbers for each sample of an image: the same whatever samples there are beside it."""
    import drjit as dr
    import mitsuba as mi

    # Sequences of neighbours are alike at their beginnings, so they are scattered first, as by Mitsuba's samplers. The
    # seed is opaque, or each would have a kernel of its own.
    begin, sequence = mi.sample_tea_32(dr.opaque(mi.UInt32, seed % 2**32), sample)
    # Of one, or it would number the sequences itself, by lanes.
    return mi.PCG32(1, begin, sequence)


def further_light(
    points: Points, sample: Any, ray: Any, skins: Sequence[Skin], lights: Lights, most: int, seed: int
) -> list[Any]:
    """What each skin sends along rays of the light that it got from other places of the skin.

    Parameters
    ----------
    sample : which sample of the image each ray is of, for its random numbers.
    most : points that a path has at most, with the one that is seen.
    """
    import drjit as dr
    import mitsuba as mi

    def step(
        point: Any, active: Any, ray: Any, numbers: Any, shares: list[Any], found: list[Any]
    ) -> tuple[Any, Any, Any, Any, list[Any], list[Any]]:
        surface = points.met(ray, active)
        active = surface.is_valid()
        direction, density, ray = points.leaving(surface, numbers)
        passed = points.response(surface, skins, direction, dr.rcp(density))
        further = active & (point > 0)
        for _ in range(LIGHTS):
            number = mi.Point2f(numbers.next_float32(), numbers.next_float32())
            lit = points.lit(surface, lights, number, skins)
            found = [
                total + dr.select(further, share * light / LIGHTS, 0.0)
                for total, share, light in zip(found, shares, lit, strict=True)
            ]
        shares = [share * part for share, part in zip(shares, passed, strict=True)]
        return point + 1, active & (density > 0) & (point + 1 < most), ray, numbers, shares, found

    count = dr.width(sample)
    whole, dark = [mi.Color3f(1.0) for _ in skins], [mi.Color3f(0.0) for _ in skins]
    begin = mi.UInt32(0), dr.full(mi.Bool, True, count), ray, random_numbers(sample, seed), whole, dark
    labels = "point", "active", "ray", "numbers", "shares", "found"
    end = dr.while_loop(begin, lambda point, active, *_: active, step, labels=labels)
    found: list[Any] = end[-1]
    return found
