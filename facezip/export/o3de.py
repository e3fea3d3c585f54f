"""Open 3D Engine: the wrinkle layers of its skin material, and a wrinkle mask for each morph target.

The engine's own source says how (https://github.com/o3de/o3de): ``Skin_SurfaceEval.azsli`` sums the masks of the morph
targets that are at work, each times its weight, clamps the sums to 0..1 and lays the layers over the neutral in turn;
``MorphTargetExporter.cpp`` finds the masks by name: ``head_wrinklemasks/TARGET_wrinklemask.tif`` beside ``head.glb``.
"""

import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from facezip.character.gltf import add_mesh, start
from facezip.character.maps import ALBEDO, Map
from facezip.character.tiles import charts
from facezip.character.units import in_metres, size_words
from facezip.export.documents.layers import LayeredMap, LayersExport
from facezip.export.engine import write_text
from facezip.export.gltf import GLB_FILE, add_joint
from facezip.export.layered import (
    NORMAL,
    Layered,
    export_layered,
    read_layered,
    still_words,
    unfit,
    write_image,
    write_layers,
)
from facezip.export.layering import Weights
from facezip.export.mixing import Rule

ENGINE, MOST = "O3DE", 4
RULE = Rule(in_turn=True, keeps_z=False)
MATERIAL, MASKS = "head.material", "head_wrinklemasks"
MATERIAL_TYPE = "@gemroot:Atom_Feature_Common@/Assets/Materials/Types/Skin.materialtype"
MATERIAL_VERSION = 4
# Of a layer's weights, the share up to which they are told apart: what few texels have beyond costs all others range.
FULL = 0.999
# Where the material takes other maps.
INPUTS = {"roughness": "roughness.textureMap", "specular": "specularF0.textureMap"}


def export_o3de(pack: Path, output: Path, *, overwrite: bool = False) -> LayersExport:
    """Export a pack of weights that are not negative as layers and masks of morph targets.

    Returns
    -------
    The content of ``facezip.json``, with ``output`` and the ``bytes`` of all files.

    Raises
    ------
    FaceZipError
        What :func:`facezip.export.layered.read_layered` and :mod:`facezip.files.writing` raise; ``BAD_VALUE`` where
        masks cannot hold the weights.
    """
    whole = read_layered(pack, ENGINE, MOST)
    maps = _checked(whole)
    masks = _masks(maps)

    def write(folder: Path) -> LayersExport:
        weights = Weights(maps, masks[..., : whole.slots].astype(np.float32) / np.float32(255))
        textures, found = write_layers(whole, folder, weights, RULE, image_name)
        for name, mask in zip(whole.model.expressions, masks, strict=True):
            file = f"{MASKS}/{name}_wrinklemask.tif"
            textures[f"{MASKS}/{name}"] = write_image(folder, file, mask, mipmaps=False)
            write_text(folder, {f"{file}.assetinfo": "o3de/assetinfo.j2"}, {})
        material = json.dumps(_material(whole, found), indent=4) + "\n"
        (folder / MATERIAL).write_text(material, encoding="utf-8")
        if whole.model.meshes:
            _write_head(whole, folder / GLB_FILE)
        words = {"slots": whole.slots, "maps": found, "count": len(masks), "head": whole.model.meshes is not None}
        write_text(folder, {"GUIDE.md": "o3de/guide.j2"}, words)
        return LayersExport(
            target="o3de",
            name=whole.name,
            tile=whole.tile,
            textures=textures,
            maps=found,
            notes=[*still_words(whole, ENGINE), *size_words(whole.model.meshes, "m")],
        )

    return export_layered(output, overwrite, write)


def image_name(kind: Map, layer: int) -> str:
    """A name whose end tells the engine how to import it: ``head_wrinkle1_basecolor``, ``head_normal``."""
    what = "basecolor" if kind.name == ALBEDO else kind.name
    return f"head_wrinkle{layer}_{what}" if layer else f"head_{what}"


def _checked(whole: Layered) -> NDArray[np.float32]:
    """The weight maps ``(N, h, w, R)``; raises where some are negative, or a target's name would be another."""
    for name in whole.model.expressions:
        if "." in name:
            reason = f"expression '{name}': {ENGINE} cuts names of morph targets at a dot, and would miss its mask"
            raise unfit(whole.path, f"{reason}; rename it, and compress again")
    maps = whole.model.weights[whole.tile]
    if maps.min() < 0:
        reason = f"has weights down to {maps.min():.2f}, and {ENGINE} lays layers over the skin, at least by 0"
        raise unfit(whole.path, f"{reason}; compress with --nonnegative")
    return maps


def _masks(maps: NDArray[np.float32]) -> NDArray[np.uint8]:
    """RGBA masks ``(N, h, w, 4)``: how strongly each layer is laid on, so that all show in the weights' proportions.

    Sizes are free, since layers are fitted to them: weights are parts of nearly the largest of a layer, together at
    most 1.
    """
    full = [np.quantile(values[values > 0], FULL) if values.any() else 1 for values in np.moveaxis(maps, 3, 0)]
    parts = (maps / np.array(full)).astype(np.float32)
    parts /= np.maximum(parts.sum(axis=-1, keepdims=True), 1)
    masks = np.zeros((*maps.shape[:3], MOST), np.uint8)
    masks[..., : maps.shape[3]] = np.rint(255 * RULE.strengths(parts))
    return masks


def _material(whole: Layered, found: Mapping[str, LayeredMap]) -> dict[str, object]:
    """A material of the engine's skin type, in its format; UVs are the mesh's first, which that calls Tiled."""
    values: dict[str, object] = {"baseColor.textureMapUv": "Tiled", "normal.textureMapUv": "Tiled"}
    values |= {"wrinkleLayers.enable": True, "wrinkleLayers.count": whole.slots}
    for name, text, switch in ((ALBEDO, "baseColor", "enableBaseColor"), (NORMAL, "normal", "enableNormal")):
        if name not in found:
            continue
        values |= {f"{text}.textureMap": f"{found[name].neutral}.png", f"wrinkleLayers.{switch}": True}
        for number, image in enumerate(found[name].layers, 1):
            values[f"wrinkleLayers.{text}Map{number}"] = f"{image}.png"
    for name, text in INPUTS.items():
        if name in found:
            values |= {text: f"{found[name].neutral}.png", f"{text}Uv": "Tiled"}
    return {"materialType": MATERIAL_TYPE, "materialTypeVersion": MATERIAL_VERSION, "propertyValues": values}


def _write_head(whole: Layered, file: Path) -> None:
    """The geometry with its morph targets, on a joint, since an actor has a skeleton."""
    if whole.model.meshes is None:
        raise ValueError("a pack without meshes has no head")
    meshes, name = in_metres(whole.model.meshes), whole.name
    glb = start(name)
    primitives = add_mesh(glb, name, meshes, whole.model.expressions, charts(meshes.topology, [whole.tile]))
    add_joint(glb, primitives)
    glb.document["materials"] = [{"name": "head"}]
    glb.finish().write(file)
