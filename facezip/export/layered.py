"""Exports of layers under masks: what those targets share, from the pack to the folder and its document."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from facezip.character.maps import ALBEDO, KNOWN, Map
from facezip.character.neutrals import packed_neutral
from facezip.character.tiles import shifted
from facezip.errors import ErrorCode, FaceZipError
from facezip.export.documents.layers import LayeredMap, LayeredTexture, LayersExport
from facezip.export.fill import Fill, shown
from facezip.export.folder import is_export, put_document
from facezip.export.layering import LayerErrors, Layers, Weights, fitted_layers, layer_errors
from facezip.export.mixing import Rule
from facezip.files.images import write_texture
from facezip.files.reading import undisturbed
from facezip.files.writing import whole_folder
from facezip.pack.model import CompressedTextures
from facezip.pack.read import read_pack
from facezip.pack.verification import verify_pack

NORMAL = "normal"
# What these engines mix; of other maps they hold the neutral.
MIXED = (ALBEDO, NORMAL)


@dataclass(frozen=True, eq=False)
class Layered:
    """A pack of one tile, whose weights an engine of layers can hold.

    Attributes
    ----------
    path, name : its folder, and what the character is called.
    model : what it holds.
    """

    path: Path
    name: str
    model: CompressedTextures

    @property
    def tile(self) -> int:
        """The UDIM number."""
        return self.model.tiles[0]

    @property
    def slots(self) -> int:
        """How many layers there are."""
        return len(self.model.parts[ALBEDO, self.tile].differences)

    @property
    def mixed(self) -> list[Map]:
        """The maps whose layers the engine mixes."""
        return [kind for kind in self.model.maps if kind.name in MIXED and KNOWN[kind.name] == kind]

    @property
    def still(self) -> list[Map]:
        """The other maps, of which there is the neutral."""
        return [kind for kind in self.model.maps if kind not in self.mixed]

    def fills(self) -> dict[str, Fill]:
        """The texels of each map that the surface shows; maps of one size share them."""
        topology = shifted(self.model.meshes.topology, self.tile) if self.model.meshes else None
        sizes = {kind.name: self.model.parts[kind.name, self.tile].neutral.shape[:2] for kind in self.model.maps}
        found = {size: Fill(shown(topology, size)) for size in {*sizes.values()}}
        return {name: found[size] for name, size in sizes.items()}


def read_layered(pack: Path, engine: str, most: int) -> Layered:
    """Verify a pack and read it, for an engine that has ``most`` layers.

    Raises
    ------
    FaceZipError
        What :func:`facezip.read_pack` raises; ``BAD_VALUE`` where the engine has no place for what the pack holds.
    """
    manifest, model = undisturbed(pack, lambda: (verify_pack(pack), read_pack(pack)))
    found = Layered(pack, manifest.name, model)
    if len(model.tiles) > 1:
        tiles = ", ".join(map(str, model.tiles))
        raise unfit(pack, f"has tiles {tiles}, and {engine} wrinkles one; compress the tile of the face alone")
    if model.maps[0] != KNOWN[ALBEDO] or model.parts[ALBEDO, found.tile].neutral.shape[2] not in (1, 3):
        raise unfit(pack, f"has no albedo of 0 to 1, which is what {engine} mixes; compress it with its albedo")
    if found.slots > most:
        raise unfit(pack, f"has {found.slots} layers, and {engine} {most}; compress with --differences {most}")
    return found


def unfit(pack: Path, words: str) -> FaceZipError:
    """The refusal of a pack that an engine cannot show."""
    return FaceZipError(ErrorCode.BAD_VALUE, f"{pack}: {words}")


def export_layered(output: Path, overwrite: bool, write: Callable[[Path], LayersExport]) -> LayersExport:
    """Write an export as :class:`facezip.export.folder.Target` does: ``write`` fills a folder, and says with what."""
    with whole_folder(output, overwrite, is_export) as folder:
        return put_document(write(folder), folder, output)


def write_layers(
    pack: Layered, folder: Path, weights: Weights, rule: Rule, names: Callable[[Map, int], str]
) -> tuple[dict[str, LayeredTexture], dict[str, LayeredMap]]:
    """Write every map's neutral and layers, and measure them.

    Parameters
    ----------
    names : of the image of a map and a layer, from 1 on; 0 is the neutral.

    Returns
    -------
    ``textures`` and ``maps`` of a document.

    Raises
    ------
    FaceZipError
        ``UNSAFE_NAME`` where an image of one map would be called as that of another.
    """
    _check_names(pack, names)
    textures, maps, fills = dict[str, LayeredTexture](), dict[str, LayeredMap](), pack.fills()
    for kind in pack.mixed:
        part, fill = pack.model.parts[kind.name, pack.tile], fills[kind.name]
        layers = fitted_layers(kind, part, weights, rule, fill)
        images = [names(kind, number) for number in range(pack.slots + 1)]
        for image, texels in zip(images, (layers.neutral, *layers.pictures), strict=True):
            textures[image] = write_image(folder, f"{image}.png", texels, kind)
        errors = layer_errors(layers, part, weights, rule, fill, pack.model.expressions)
        maps[kind.name] = _mixed(layers, _still(kind, layers.neutral, images[0]), images[1:], errors)
    for kind in pack.still:
        part, image = pack.model.parts[kind.name, pack.tile], names(kind, 0)
        texels = fills[kind.name](np.asarray(packed_neutral(part.neutral, kind, 8), np.uint8))
        textures[image] = write_image(folder, f"{image}.png", texels, kind)
        maps[kind.name] = _still(kind, texels, image)
    return textures, maps


def write_image(
    folder: Path, file: str, texels: NDArray[np.uint8], kind: Map | None = None, mipmaps: bool | None = None
) -> LayeredTexture:
    """Write an image, of a map or of a mask, and say how it is to be imported: with mip-maps where nothing is said."""
    (folder / file).parent.mkdir(exist_ok=True)
    write_texture(folder / file, texels)
    return LayeredTexture(file=file, srgb=kind is not None and kind.encoding == "srgb", mipmaps=mipmaps)


def still_words(pack: Layered, engine: str) -> list[str]:
    """What is said of maps that do not move, a line where there are any."""
    if not pack.still:
        return []
    names = ", ".join(kind.name for kind in pack.still)
    return [f"{names}: {engine} mixes colours and normals alone; what else changes is left out, and the neutral stays"]


def _check_names(pack: Layered, names: Callable[[Map, int], str]) -> None:
    taken = {names(kind, number) for kind in pack.mixed for number in range(pack.slots + 1)}
    for kind in pack.still:
        if names(kind, 0) in taken:
            reason = f"map '{kind.name}' would be called as a picture of another; compress it under another name"
            raise FaceZipError(ErrorCode.UNSAFE_NAME, f"{pack.path}: {reason}")


def _still(kind: Map, texels: NDArray[np.uint8], image: str) -> LayeredMap:
    """A map without layers."""
    height, width = texels.shape[:2]
    return LayeredMap(
        encoding=kind.encoding, range=(kind.low, kind.high), size=(height, width), neutral=image, layers=[]
    )


def _mixed(layers: Layers, still: LayeredMap, images: list[str], errors: LayerErrors) -> LayeredMap:
    """The same map with its layers, and what was measured of them."""
    whole = replace(still, layers=images, beyond=layers.beyond)
    if layers.kind.is_normal:
        return replace(
            whole,
            angular_error=errors.mean,
            angular_error_per_expression=errors.per_expression,
            angular_error_blends=errors.blends,
            angular_error_largest=errors.largest,
        )
    return replace(
        whole,
        rmse=errors.mean,
        rmse_per_expression=errors.per_expression,
        rmse_blends=errors.blends,
        rmse_largest=errors.largest,
    )
