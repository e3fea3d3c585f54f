"""Skin, as Mitsuba BSDF dicts over any reflectance.

All are affine in their albedo, f = albedo · f_diffuse + f_specular. What maps of normals, roughness, specular and
cavity make of them is in :mod:`render.shading`, which agrees with these where a skin has none.
"""

from collections.abc import Callable
from typing import Any

from scenes.plugins import Plugin

# Of skin without maps of them. `specular` is Disney's and Unreal's: a reflectance of 0.08 · specular at normal
# incidence; Unreal's tables give skin 0.35, lips and the T-zone have more.
ROUGHNESS = 0.48
SPECULAR = 0.42
# Of soft skin: the share of the narrower of its two highlights, and by how much they are narrower and broader. Two
# lobes fit measured skin better than one: Weyrich et al., "Analysis of Human Faces using a Measurement-Based Skin
# Reflectance Model" (2006).
NARROW_SHARE, NARROW, BROAD = 0.2, 0.62, 1.1


def diffuse(albedo: Any) -> Plugin:
    """Matte skin: nothing but the texture shows."""
    return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": albedo}}


def skin(albedo: Any) -> Plugin:
    """Principled skin: a rough dielectric sheen over the texture."""
    principled = {"type": "principled", "base_color": albedo, "roughness": ROUGHNESS, "specular": SPECULAR}
    return {"type": "twosided", "bsdf": {**principled, "sheen": 0.0}}


def soft(albedo: Any) -> Plugin:
    """Principled skin with two highlights; where it has a normal map, light scatters (:mod:`render.shading`)."""
    lobes = {
        f"lobe_{n}": {"type": "principled", "base_color": albedo, "roughness": factor * ROUGHNESS, "specular": SPECULAR}
        for n, factor in enumerate((BROAD, NARROW))
    }
    return {"type": "twosided", "bsdf": {"type": "blendbsdf", "weight": NARROW_SHARE, **lobes}}


MATERIALS: dict[str, Callable[[Any], Plugin]] = {"skin": skin, "diffuse": diffuse, "soft": soft}


def grey(value: float) -> Plugin:
    """A constant albedo."""
    return {"type": "rgb", "value": value}
