"""Skins with more than an albedo: normals and roughness from maps too, for the paired renderer."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.files.images import decode_srgb
from facezip.machine import memory
from render.llvm import start
from render.paired import upload
from scenes.materials import MATERIALS, bumpy

# What light meets besides the albedo; other maps of a character are compressed, but not rendered.
RENDERED = ("albedo", "normal", "roughness")


@dataclass(frozen=True, eq=False)
class SkinMaps:
    """The maps of one skin, all over the same UV square.

    Attributes
    ----------
    albedo : ``(H, W, C)`` encoded values in [0, 1].
    normal : ``(H, W, 3)`` unit vectors of tangent space, y up, or None where the mesh's own will do.
    roughness : ``(H, W, 1)`` in [0, 1], or None for that of the material.
    """

    albedo: NDArray[np.float32]
    normal: NDArray[np.float32] | None = None
    roughness: NDArray[np.float32] | None = None

    @property
    def arrays(self) -> tuple[NDArray[np.float32], ...]:
        """Those that there are."""
        return tuple(one for one in (self.albedo, self.normal, self.roughness) if one is not None)


Texture = NDArray[np.float32] | SkinMaps


def uploaded(texture: Texture, material: str) -> Any:
    """An albedo ``(H, W, C)``, or a skin of a material, for the renderer."""
    memory.let_go()
    skin = upload_skin(texture, material) if isinstance(texture, SkinMaps) else upload(texture)
    memory.let_go()
    return skin


def upload_skin(maps: SkinMaps, material: str) -> Any:
    """A skin for :meth:`render.paired.PairedRenderer.render`, bilinear and clamped as a single texture is.

    Parameters
    ----------
    maps : what differs from skin to skin.
    material : a key of :data:`scenes.materials.MATERIALS`.
    """
    start()
    import mitsuba as mi

    colour = maps.albedo if maps.albedo.shape[2] == 3 else np.repeat(maps.albedo[:, :, :1], 3, axis=2)
    rough = () if maps.roughness is None else (_bitmap(maps.roughness),)
    skin = MATERIALS[material](_bitmap(decode_srgb(np.clip(colour, 0, 1))), *rough)
    return mi.load_dict(skin if maps.normal is None else bumpy(skin, _bitmap(0.5 * maps.normal + np.float32(0.5))))


def _bitmap(values: NDArray[np.float32]) -> dict[str, Any]:
    import mitsuba as mi

    data = mi.TensorXf(np.ascontiguousarray(values))
    return {"type": "bitmap", "data": data, "raw": True, "format": "variant", "wrap_mode": "clamp"}
