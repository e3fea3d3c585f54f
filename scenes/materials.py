"""Skin, as Mitsuba BSDF dicts over any reflectance.

Both materials are affine in their albedo, f = albedo · f_diffuse + f_specular, which is what lets one light path shade
any number of textures.
"""

from collections.abc import Callable
from typing import Any


def diffuse(albedo: Any) -> dict[str, Any]:
    """Matte skin: nothing but the texture shows."""
    return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": albedo}}


def skin(albedo: Any) -> dict[str, Any]:
    """Principled skin: a rough dielectric sheen over the texture."""
    return {
        "type": "twosided",
        "bsdf": {"type": "principled", "base_color": albedo, "roughness": 0.48, "specular": 0.42, "sheen": 0.0},
    }


MATERIALS: dict[str, Callable[[Any], dict[str, Any]]] = {"skin": skin, "diffuse": diffuse}


def grey(value: float) -> dict[str, Any]:
    """A constant albedo."""
    return {"type": "rgb", "value": value}
