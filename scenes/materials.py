"""Skin, as Mitsuba BSDF dicts over any reflectance.

Without a map of normals or of roughness, both materials are affine in their albedo, f = albedo · f_diffuse +
f_specular, which is what lets one light path shade any number of textures.
"""

from collections.abc import Callable
from typing import Any


def diffuse(albedo: Any, _roughness: Any = None) -> dict[str, Any]:
    """Matte skin: nothing but the texture shows."""
    return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": albedo}}


def skin(albedo: Any, roughness: Any = 0.48) -> dict[str, Any]:
    """Principled skin: a rough dielectric sheen over the texture."""
    return {
        "type": "twosided",
        "bsdf": {"type": "principled", "base_color": albedo, "roughness": roughness, "specular": 0.42, "sheen": 0.0},
    }


def bumpy(material: dict[str, Any], normals: Any) -> dict[str, Any]:
    """A material whose surface stands as a tangent-space normal map says, a texture of (n + 1) / 2."""
    inner = {"type": "normalmap", "normalmap": normals, "bsdf": material["bsdf"]}
    return {"type": "twosided", "bsdf": inner}


MATERIALS: dict[str, Callable[..., dict[str, Any]]] = {"skin": skin, "diffuse": diffuse}


def grey(value: float) -> dict[str, Any]:
    """A constant albedo."""
    return {"type": "rgb", "value": value}
