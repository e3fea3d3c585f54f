"""What a material of a glTF says of a face: its textures, how they lie on the mesh, and what they are multiplied by."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from facezip.files.accessors import GlbFault, GltfObject
from facezip.files.glb import Glb

PLACED = "KHR_texture_transform"
GLOSSINESS = "KHR_materials_pbrSpecularGlossiness"
WEBP = "EXT_texture_webp"
REPEAT, MIRRORED = 10497, 33648
_READ = ("baseColorTexture", "diffuseTexture", "metallicRoughnessTexture", "normalTexture")


@dataclass(frozen=True)
class Placement:
    """Where a texture lies on a mesh.

    Attributes
    ----------
    coordinates : the number of the set of UVs, ``TEXCOORD_n``.
    across, down : u' = a u + b v + c and v' = a u + b v + c, each as ``(a, b, c)``; v down, as glTF has it.
    wrap : what lies beyond the unit square in u and in v, as WebGL numbers it.
    """

    coordinates: int = 0
    across: tuple[float, float, float] = (1.0, 0.0, 0.0)
    down: tuple[float, float, float] = (0.0, 1.0, 0.0)
    wrap: tuple[int, int] = (REPEAT, REPEAT)

    @property
    def moves(self) -> bool:
        """Whether UVs are others than the mesh has."""
        return (self.across, self.down) != ((1, 0, 0), (0, 1, 0))

    def is_as(self, other: "Placement") -> bool:
        """Whether a texture with this placement shows the same place everywhere, if none leaves the unit square."""
        mine, theirs = ((one.coordinates, one.across, one.down) for one in (self, other))
        return mine == theirs


@dataclass(frozen=True)
class Use:
    """One texture of a material: the number of its image, and where it lies."""

    image: int
    placement: Placement


@dataclass(frozen=True)
class Material:
    """A material, as far as it concerns a face.

    Attributes
    ----------
    textures : by map; of roughness it is the green channel.
    tint : what colours are multiplied by, red, green and blue of linear light.
    roughness, bump : what roughness, and what x and y of normals, are multiplied by.
    left_out : what it has besides, and a face here does not, in words.
    """

    textures: dict[str, Use]
    tint: tuple[float, float, float]
    roughness: float
    bump: float
    left_out: tuple[str, ...]

    @classmethod
    def of(cls, glb: Glb, index: Any) -> "Material":
        """Read the material of that number; ``GlbFault`` where it says what no viewer could show."""
        entry = glb.item("materials", index)
        shading = entry.get("pbrMetallicRoughness", {})
        older = entry.get("extensions", {}).get(GLOSSINESS, {})
        colours = shading.get("baseColorTexture", older.get("diffuseTexture"))
        stated = {
            "albedo": colours,
            "roughness": shading.get("metallicRoughnessTexture"),
            "normal": entry.get("normalTexture"),
        }
        tint = shading.get("baseColorFactor", older.get("diffuseFactor", (1, 1, 1, 1)))
        return cls(
            textures={name: use_of(glb, info) for name, info in stated.items() if info is not None},
            tint=_three(_numbers("base colour factor", tint, 4, 0, 1)),
            roughness=_number("roughness factor", shading.get("roughnessFactor", 1), 0, 1),
            bump=_number("scale of normals", (stated["normal"] or {}).get("scale", 1), -math.inf, math.inf),
            left_out=tuple(_left_out(entry)),
        )


def use_of(glb: Glb, info: Any) -> Use:
    """The image and the placement of an object of glTF's kind ``textureInfo``."""
    texture = glb.item("textures", info["index"])
    sampler = glb.item("samplers", texture["sampler"]) if "sampler" in texture else {}
    wrap = int(sampler.get("wrapS", REPEAT)), int(sampler.get("wrapT", REPEAT))
    moved = info.get("extensions", {}).get(PLACED, {})
    coordinates = moved.get("texCoord", info.get("texCoord", 0))
    if type(coordinates) is not int or coordinates < 0:
        raise GlbFault(f"a texture uses the UVs {repr(coordinates)[:64]}, which are none; export it again")
    x, y = _numbers(PLACED, moved.get("offset", (0, 0)), 2)
    wide, high = _numbers(PLACED, moved.get("scale", (1, 1)), 2)
    turn = _number(PLACED, moved.get("rotation", 0))
    # u' = T R S u: counter-clockwise as one sees it, with v down.
    cosine, sine = (math.cos(turn), math.sin(turn)) if turn else (1.0, 0.0)
    if wide * high == 0:
        raise GlbFault(f"{PLACED} flattens its UVs; export it again")
    across, down = (cosine * wide, sine * high, x), (-sine * wide, cosine * high, y)
    return Use(image_of(glb, info["index"]), Placement(coordinates, across, down, wrap))


def image_of(glb: Glb, index: Any) -> int:
    """The number of the image of a texture: of WebP where it has one, else of what every viewer reads."""
    texture = glb.item("textures", index)
    others = texture.get("extensions", {})
    if "source" in others.get(WEBP, {}):
        return int(others[WEBP]["source"])
    if "source" not in texture:
        kind = f"is of {', '.join(map(str, others))[:64]} alone" if others else "has no image"
        raise GlbFault(f"its texture {index} {kind}, which is not read; export it with PNG or JPEG textures")
    return int(texture["source"])


def _left_out(entry: GltfObject) -> Iterator[str]:
    yield from sorted({name for name in _texture_names(entry, 0) if name not in _READ})
    if any(_numbers("emissive factor", entry.get("emissiveFactor", (0, 0, 0)), 3)) and "emissiveTexture" not in entry:
        yield "emissiveFactor"
    if entry.get("alphaMode", "OPAQUE") != "OPAQUE":
        yield f"transparency (alphaMode {str(entry['alphaMode'])[:16]})"


def _texture_names(entry: GltfObject, depth: int) -> Iterator[str]:
    for name, value in entry.items():
        if isinstance(value, dict):
            if name.endswith("Texture") and "index" in value:
                yield name[:64]
            elif depth < 4 and name != "extras":
                yield from _texture_names(value, depth + 1)


def _numbers(what: str, stated: Any, count: int, low: float = -math.inf, high: float = math.inf) -> tuple[float, ...]:
    if not isinstance(stated, list | tuple) or len(stated) != count:
        raise GlbFault(f"a {what} of it is not {count} numbers; export it again")
    return tuple(_number(what, value, low, high) for value in stated)


def _number(what: str, stated: Any, low: float = -math.inf, high: float = math.inf) -> float:
    if isinstance(stated, bool) or not isinstance(stated, int | float) or not math.isfinite(stated):
        raise GlbFault(f"a {what} of it is no number; export it again")
    if not low <= stated <= high:
        raise GlbFault(f"a {what} of it is {stated:.6g}, outside of {low:g} to {high:g}; export it again")
    return float(stated)


def _three(numbers: tuple[float, ...]) -> tuple[float, float, float]:
    return numbers[0], numbers[1], numbers[2]
