"""What a point of the skin makes of light: the materials of :mod:`scenes.materials`, over maps of everything.

Mitsuba's principled BSDF has one ``specular`` for a whole object and knows no cavities, so it is written out here, as
functions of Dr.Jit arrays. Directions are unit vectors in the frame of the mesh (z along its interpolated normal, x
along u) that point away from the surface.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from scenes.materials import BROAD, NARROW, NARROW_SHARE, ROUGHNESS, SPECULAR

# How much of what a cavity takes from the highlight it takes from the diffuse light as well. Unreal's guide multiplies
# both alike, Unity's digital human the highlight alone; light that scatters in the skin fills a pore with most of it.
DIFFUSE_CAVITY = 0.3


@dataclass(frozen=True, eq=False)
class Finish:
    """What a point of the skin is besides its colour.

    Attributes
    ----------
    normal : unit vector in the frame of the mesh, or None where it is the mesh's own.
    roughness : in [0, 1], the square root of the GGX distribution's α.
    specular : in [0, 1], a reflectance of 0.08 · specular at normal incidence.
    cavity : in [0, 1], the share of the highlight that comes out.
    scattering : as ``normal``, for red, green and blue, blurred as far as each scatters; none where nothing scatters.
    """

    normal: Any = None
    roughness: Any = ROUGHNESS
    specular: Any = SPECULAR
    cavity: Any = 1.0
    scattering: tuple[Any, ...] = ()


# Of the directions to the eye and to the light and a point's finish: the cosine-weighted BSDF is albedo · the first
# + the second.
Shading = Callable[[Any, Any, Finish], tuple[Any, Any]]


def matte(eye: Any, light: Any, finish: Finish) -> tuple[Any, Any]:
    """Lambert's law; a matte skin has no highlight, so roughness and specular do not count."""
    import drjit as dr

    lit = _Lit.of(eye, light, finish.normal)
    return lit.share * lit.to_light * _darkened(finish.cavity) / dr.pi, 0.0


def principled(eye: Any, light: Any, finish: Finish) -> tuple[Any, Any]:
    """Disney's diffuse lobe with retro-reflection under a GGX lobe with the Fresnel term of a dielectric.

    Burley, "Physically Based Shading at Disney" (2012), as Mitsuba's ``principled`` has it without metal, tint,
    transmission, sheen and clear coat.
    """
    lit = _Lit.of(eye, light, finish.normal)
    return _diffuse(lit, eye, light, finish), _highlight(lit, eye, light, finish)


def soft(eye: Any, light: Any, finish: Finish) -> tuple[Any, Any]:
    """Two principled lobes, one narrower and one broader, over skin in which light scatters.

    Light that scatters leaves the skin some way from where it entered, so that irradiance is blurred over the skin, red
    most. Irradiance is to first order linear in the slopes of the surface; so the diffuse light of each channel is that
    of normals that are blurred as far as the channel scatters (:attr:`Finish.scattering`). Without them, or where
    the relief is flat, nothing scatters.
    """
    import drjit as dr
    import mitsuba as mi

    lobes = [
        (share, replace(finish, roughness=dr.minimum(factor * finish.roughness, 1.0)))
        for share, factor in ((1 - NARROW_SHARE, BROAD), (NARROW_SHARE, NARROW))
    ]
    lit = _Lit.of(eye, light, finish.normal)
    specular = sum(share * _highlight(lit, eye, light, lobe) for share, lobe in lobes)
    blurred = [_Lit.of(eye, light, normal) for normal in finish.scattering] or [lit]
    diffuse = [sum(share * _diffuse(one, eye, light, lobe) for share, lobe in lobes) for one in blurred]
    return mi.Color3f(*diffuse) if finish.scattering else diffuse[0], specular


def _diffuse(lit: "_Lit", eye: Any, light: Any, finish: Finish) -> Any:
    import drjit as dr

    from_eye, from_light = _schlick(lit.to_eye), _schlick(lit.to_light)
    retro = 2 * finish.roughness * dr.square(dr.dot(dr.normalize(eye + light), light))
    lobe = (1 - 0.5 * from_eye) * (1 - 0.5 * from_light)
    lobe += retro * (from_eye + from_light + from_eye * from_light * (retro - 1))
    return lit.share * lit.to_light * _darkened(finish.cavity) * lobe / dr.pi


def _highlight(lit: "_Lit", eye: Any, light: Any, finish: Finish) -> Any:
    import drjit as dr
    import mitsuba as mi

    half = dr.normalize(eye + light)
    # F₀ = ((η - 1) / (η + 1))² = 0.08 · specular.
    eta = 2 / (1 - dr.sqrt(0.08 * finish.specular)) - 1
    fresnel = mi.fresnel(dr.dot(half, light), eta)[0]
    alpha_2 = dr.square(dr.maximum(dr.square(finish.roughness), 1e-3))
    unmasked = _smith(lit.to_eye, alpha_2) * _smith(lit.to_light, alpha_2)
    highlight = fresnel * _ggx(half, lit.normal, alpha_2) * unmasked / (4 * lit.to_eye)
    return dr.select(lit.share > 0, lit.share * finish.cavity * highlight, 0.0)


@dataclass(frozen=True, eq=False)
class _Lit:
    """A surface that stands as its normal map says.

    Attributes
    ----------
    normal : unit vector in the frame of the mesh.
    to_eye, to_light : cosines to it.
    share : how much of the light is not shadowed by the relief itself; 0 where light or eye are behind it.
    """

    normal: Any
    to_eye: Any
    to_light: Any
    share: Any

    @classmethod
    def of(cls, eye: Any, light: Any, normal: Any) -> "_Lit":
        import drjit as dr
        import mitsuba as mi

        if normal is None:
            front = (eye.z > 0) & (light.z > 0)
            return cls(mi.Vector3f(0, 0, 1), eye.z, light.z, dr.select(front, 1.0, 0.0))
        # What faces away from the eye was seen as if it faced it: Schüßler et al., "Microfacet-Based Normal Mapping
        # for Robust Monte Carlo Path Tracing" (2017).
        turned = dr.dot(eye, normal) <= 0
        normal = mi.Vector3f(dr.select(turned, -normal.x, normal.x), dr.select(turned, -normal.y, normal.y), normal.z)
        to_eye, to_light = dr.dot(eye, normal), dr.dot(light, normal)
        front = (eye.z > 0) & (light.z > 0) & (to_eye > 0) & (to_light > 0)
        # Conty Estevez et al., "A Microfacet-Based Shadowing Function to Solve the Bump Terminator Problem" (2019).
        steepness = dr.minimum(0.125 * _tan_2(normal.z), 1)
        return cls(normal, to_eye, to_light, dr.select(front, _smith(light.z, steepness), 0.0))


def _darkened(cavity: Any) -> Any:
    return 1 - DIFFUSE_CAVITY * (1 - cavity)


def _schlick(cosine: Any) -> Any:
    import drjit as dr

    rest = dr.clip(1 - cosine, 0, 1)
    return dr.square(dr.square(rest)) * rest


def _ggx(half: Any, normal: Any, alpha_2: Any) -> Any:
    """Density of microfacets that face halfway: Walter et al., "Microfacet Models for Refraction" (2007), eq. 33."""
    import drjit as dr

    sine_2 = dr.squared_norm(dr.cross(half, normal))
    return alpha_2 / (dr.pi * dr.square(sine_2 + alpha_2 * dr.square(dr.dot(half, normal))))


def _smith(cosine: Any, alpha_2: Any) -> Any:
    """What microfacets leave unmasked in a direction: Walter et al. (2007), eq. 34."""
    import drjit as dr

    return 2 / (1 + dr.sqrt(1 + alpha_2 * _tan_2(cosine)))


def _tan_2(cosine: Any) -> Any:
    import drjit as dr

    return (1 - dr.square(cosine)) / dr.square(cosine)


# By the names of :data:`scenes.materials.MATERIALS`.
SHADINGS: dict[str, Shading] = {"skin": principled, "diffuse": matte, "soft": soft}
