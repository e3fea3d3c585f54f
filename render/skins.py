"""Skins for the paired renderer: an albedo, and any of the maps of what else light meets."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.files.srgb import decode_srgb
from facezip.machine import memory
from render.llvm import start
from render.scattering import blurred_slopes
from render.shading import Finish


@dataclass(frozen=True, eq=False)
class SkinMaps:
    """The maps of one skin, all over the same UV square, of any sizes.

    Attributes
    ----------
    albedo : ``(H, W, C)`` encoded values in [0, 1].
    normal : ``(H, W, 3)`` unit vectors of tangent space, y up, or None where the mesh's own will do.
    roughness : ``(H, W, 1)`` in [0, 1], as of a principled BSDF; None for that of the material, as below.
    specular : ``(H, W, 1)`` in [0, 1], Disney's and Unreal's: a reflectance of 0.08 · specular at normal incidence.
    cavity : ``(H, W, 1)`` in [0, 1], the share of the highlight that comes out of the relief; diffuse light loses
        :data:`render.shading.DIFFUSE_CAVITY` of what the highlight does.
    """

    albedo: NDArray[np.float32]
    normal: NDArray[np.float32] | None = None
    roughness: NDArray[np.float32] | None = None
    specular: NDArray[np.float32] | None = None
    cavity: NDArray[np.float32] | None = None

    @property
    def present(self) -> dict[str, NDArray[np.float32]]:
        """Those that there are, by name."""
        every = {name: getattr(self, name) for name in RENDERED}
        return {name: values for name, values in every.items() if values is not None}


# Names of maps that are rendered; others of a character are compressed and measured.
RENDERED = tuple(field.name for field in fields(SkinMaps))


@dataclass(frozen=True, eq=False)
class Skin:
    """Maps as the kernel looks them up, by name: bilinear, clamped at their borders.

    ``slopes`` are x/z and y/z of the normals that red, green and blue diffuse light follows, where it scatters.
    """

    textures: Mapping[str, Any]
    slopes: tuple[Any, ...] = ()

    @property
    def sizes(self) -> dict[str, tuple[int, int]]:
        """Rows and columns of each map."""
        return {name: (texture.shape[0], texture.shape[1]) for name, texture in self.textures.items()}

    def blackened(self) -> "Skin":
        """The same maps over an albedo of zero."""
        return Skin({**self.textures, "albedo": _texture(np.zeros((1, 1, 3), np.float32))}, self.slopes)

    def colour(self, uv: Any, active: Any) -> Any:
        """Linear albedo."""
        import mitsuba as mi

        return mi.Color3f(self.textures["albedo"].eval(uv, active))

    def finish(self, uv: Any, handed: Any, active: Any) -> Finish:
        """What the other maps say; ``handed`` is -1 where the chart is mirrored, else 1."""
        import drjit as dr
        import mitsuba as mi

        found = {name: texture.eval(uv, active) for name, texture in self.textures.items() if name != "albedo"}
        if "normal" not in found:
            return Finish(**{name: number for name, (number,) in found.items()})
        x, y, z = found.pop("normal")
        normal = dr.normalize(mi.Vector3f(x, handed * y, z))
        blurred = zip(*(texture.eval(uv, active) for texture in self.slopes), strict=True)
        scattering = tuple(dr.normalize(mi.Vector3f(a, handed * b, 1.0)) for a, b in blurred)
        return Finish(normal, scattering=scattering, **{name: number for name, (number,) in found.items()})


def upload(maps: SkinMaps, height: float | None = None) -> Skin:
    """A skin for :meth:`render.paired.PairedRenderer.render`.

    ``height`` is that of the head in sides of the UV square (:func:`render.scattering.spread`), where light scatters in
    the skin, as in the material ``soft``.
    """
    start()
    memory.let_go()
    textures = {name: _texture(_stored(name, values)) for name, values in maps.present.items()}
    slopes: tuple[Any, ...] = ()
    if height is not None and maps.normal is not None:
        slopes = tuple(_texture(values) for values in blurred_slopes(maps.normal, height))
    skin = Skin(textures, slopes)
    memory.let_go()
    return skin


def _stored(name: str, values: NDArray[np.float32]) -> NDArray[np.float32]:
    if name == "normal":
        return values
    if name == "albedo":
        colour = values if values.shape[2] == 3 else np.repeat(values[:, :, :1], 3, axis=2)
        return decode_srgb(np.clip(colour, 0, 1))
    return np.clip(values[:, :, :1], 0, 1)


def _texture(values: NDArray[np.float32]) -> Any:
    import drjit as dr
    import mitsuba as mi

    modes = {"filter_mode": dr.FilterMode.Linear, "wrap_mode": dr.WrapMode.Clamp}
    texture = mi.Texture2f(mi.TensorXf(np.ascontiguousarray(values)), **modes)
    # A texture uploads itself on first use; inside a recorded kernel that would be too late.
    dr.eval(texture.eval(mi.Point2f(0.5)))
    return texture
