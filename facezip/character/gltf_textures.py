"""Whose texture is which in a glTF: by material variants, or the names of materials, textures, images and files."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from facezip.character.custom import texture_among
from facezip.character.filenames import MASK, visible_files
from facezip.character.gltf_images import Images
from facezip.character.gltf_material import Material, Use, image_of
from facezip.character.gltf_parts import Part
from facezip.character.maps import ALBEDO
from facezip.character.scans import NEUTRAL
from facezip.files.accessors import GlbFault, GltfObject
from facezip.files.glb import Glb
from facezip.names import folded, is_safe_name

VARIANTS = "KHR_materials_variants"


@dataclass(frozen=True)
class Look:
    """What a face looks like under one name.

    Attributes
    ----------
    source : its base colour: the number of an image, or a file beside the glTF.
    material : what else is stated of it; None where the name is a texture's, an image's or a file's.
    """

    source: int | Path
    material: Material | None = None

    @property
    def colours(self) -> Use | None:
        """How its base colour is used, where a material says so."""
        return None if self.material is None else self.material.textures.get(ALBEDO)


class Looks:
    """The looks of one part of a file.

    Parameters
    ----------
    path, glb, images : the file.
    part : the part of it.
    """

    def __init__(self, path: Path, glb: Glb, images: Images, part: Part) -> None:
        self._folder, self._glb, self._images, self._part = path.parent, glb, images, part
        self._variants = _variant_materials(glb, part.primitives[0])
        # Maya's exporters put the name of the deformer before each target's, and a point.
        self._before = _shared_start(part.names)
        self._numbers = {kind: self._by_name(kind) for kind in ("materials", "textures", "images")}

    def are_variants(self, names: Iterable[str]) -> bool:
        """Whether each of some names is one of the part's material variants."""
        return all(name in self._variants for name in names)

    def of(self, name: str) -> Look | None:
        """The look of a morph target, of the neutral, or of the mask; None where nothing has its name."""
        found = self._by(name)
        return self._by(name.removeprefix(self._before)) if found is None and name.startswith(self._before) else found

    def _by(self, name: str) -> Look | None:
        if name in self._variants:
            return self._of_material(self._variants[name])
        if name == NEUTRAL and self._part.material is not None:
            return self._of_material(self._part.material) or self._beside(name)
        return self._of_materials(name) or self._of_images(name) or self._beside(name)

    def _beside(self, name: str) -> Look | None:
        if name not in (NEUTRAL, MASK) and not is_safe_name(name):
            return None
        file = texture_among(self._files, name)
        return None if file is None else Look(file)

    @cached_property
    def _files(self) -> list[Path]:
        return visible_files(self._folder)

    def _of_materials(self, name: str) -> Look | None:
        looks = [self._of_material(index) for index in self._called("materials", name)]
        return self._only(name, "materials", [look for look in looks if look is not None])

    def _of_images(self, name: str) -> Look | None:
        by_texture = [Look(image_of(self._glb, index)) for index in self._called("textures", name)]
        by_image = [Look(index) for index in self._called("images", name)]
        return self._only(name, "textures", by_texture) or self._only(name, "images", by_image)

    def _by_name(self, kind: str) -> dict[str, list[int]]:
        """Numbers of entries by their names, and by what these compare as."""
        found: dict[str, list[int]] = {}
        for index in range(len(self._glb.document.get(kind, []))):
            name = self._name(kind, index)
            for key in {name, folded(name)}:
                found.setdefault(key, []).append(index)
        return found

    def _called(self, kind: str, name: str) -> list[int]:
        return self._numbers[kind].get(name) or self._numbers[kind].get(folded(name), [])

    def _name(self, kind: str, index: int) -> str:
        if kind == "images":
            return self._images.name(index)
        stated = str(self._glb.item(kind, index).get("name", ""))
        return Path(stated).stem if Path(stated).suffix.lower() in (".png", ".jpg", ".jpeg", ".webp") else stated

    def _only(self, name: str, kind: str, looks: list[Look]) -> Look | None:
        if len({look.source for look in looks}) > 1:
            raise GlbFault(f"{len(looks)} of its {kind} are called '{name[:64]}'; rename those that are not the face's")
        return looks[0] if looks else None

    def _of_material(self, index: Any) -> Look | None:
        material = Material.of(self._glb, index)
        return Look(material.textures[ALBEDO].image, material) if ALBEDO in material.textures else None


def _shared_start(names: Iterable[str]) -> str:
    """What stands before the first point of every name, with the point; nothing where they differ."""
    starts = {"".join(name.partition(".")[:2]) for name in names}
    (start,) = starts if len(starts) == 1 else ("",)
    return start if start.endswith(".") else ""


def _variant_materials(glb: Glb, primitive: Mapping[str, Any]) -> GltfObject:
    """The material of every variant, by its name."""
    variants = glb.document.get("extensions", {}).get(VARIANTS, {}).get("variants", [])
    mappings = primitive.get("extensions", {}).get(VARIANTS, {}).get("mappings", [])
    return {
        str(variants[index]["name"]): mapping["material"]
        for mapping in mappings
        for index in mapping["variants"]
        if type(index) is int and 0 <= index < len(variants)
    }
