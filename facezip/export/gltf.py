"""glTF: a GLB with named morph targets that shows the neutral; difference textures and shaders beside it.

glTF has no blend of textures by weight maps: a viewer of it moves the geometry and shows the neutral's albedo, normals
and roughness. Everything else is for a program that knows the shaders; ``extras`` of a material say which tile it is.
"""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from facezip.character.gltf import CLAMPED, add_mesh, skin, start
from facezip.character.neutrals import packed_neutral, unpacked_neutral
from facezip.export.folder import Target
from facezip.export.formats import BASIS, PNG, Format
from facezip.export.shaders import GLSL, HLSL, head_words, render, shader
from facezip.export.source import Source, Tile
from facezip.files.accessors import GltfObject
from facezip.files.glb_builder import VERTICES, GlbBuilder
from facezip.files.images import Texels, png
from facezip.machine.rows import by_rows

GLB_FILE = "head.glb"
JOINT = "head_joint"
BASIS_EXTENSION = "KHR_texture_basisu"


def write_glb(
    source: Source, file: Path, basis: Path | None = None, jointed: bool = False, pictured: bool = True
) -> None:
    """Write the geometry with its morph targets, and the neutral as its material, as one GLB.

    Parameters
    ----------
    source : the pack.
    file : to write.
    basis : the folder of an export whose albedo is KTX2, which then is the material's colour; else it is PNG.
    jointed : whether the head hangs on one joint, for programs that keep morph targets of skinned meshes alone.
    pictured : whether the neutral comes along; else materials are names.
    """
    glb = start(source.name)
    primitives = add_mesh(glb, source.name, source.meshes, source.expressions, source.charts)
    if jointed:
        add_joint(glb, primitives)
    glb.document |= {"samplers": CLAMPED, "textures": []} if pictured else {}
    glb.document["materials"] = []
    for tile in source.tiles:
        several = f"_{tile.layout.number}" if len(source.tiles) > 1 else ""
        albedo = source.folder_of(tile, basis) / "neutral.ktx2" if basis else None
        name = f"neutral{several}"
        material = _material(glb, tile, name, several, albedo) if pictured else {"name": name}
        glb.document["materials"].append(material)
    if basis:
        glb.document |= {key: [BASIS_EXTENSION] for key in ("extensionsUsed", "extensionsRequired")}
    glb.finish().write(file)


def add_joint(glb: GlbBuilder, primitives: list[GltfObject]) -> None:
    """One joint at the origin, which moves every vertex by all of its weight."""
    for primitive in primitives:
        attributes = primitive["attributes"]
        count = glb.document["accessors"][attributes["POSITION"]]["count"]
        attributes["JOINTS_0"] = glb.array(np.zeros((count, 4), np.uint8), VERTICES)
        attributes["WEIGHTS_0"] = glb.array(np.tile(np.array([1, 0, 0, 0], np.float32), (count, 1)), VERTICES)
    nodes = glb.document["nodes"]
    nodes.append({"name": JOINT})
    nodes[0]["skin"] = 0
    glb.document["skins"] = [{"name": JOINT, "joints": [1], "skeleton": 1}]
    glb.document["scenes"][0]["nodes"].append(1)


def _material(glb: GlbBuilder, tile: Tile, name: str, several: str, albedo: Path | None) -> GltfObject:
    if albedo:
        index = glb.image(name, albedo.read_bytes(), "image/ktx2")
        color = _texture(glb, name, {"extensions": {BASIS_EXTENSION: {"source": index}}})
    else:
        color = _image(glb, name, stored_neutral(tile, "albedo"))
    normal = roughness = None
    if "normal" in tile.known:
        normal = _image(glb, f"normal{several}", stored_neutral(tile, "normal"))
    if "roughness" in tile.known:
        grey = stored_neutral(tile, "roughness")
        # Green is roughness there, and blue metalness.
        green = by_rows(lambda rows: grey[rows] * np.array([1, 1, 0], grey.dtype), (*grey.shape[:2], 3), grey.dtype)
        roughness = _image(glb, f"roughness{several}", green)
    material = skin(name, color, normal, roughness)
    return {**material, "extras": {"tile": tile.layout.number}} if several else material


def stored_neutral(tile: Tile, name: str) -> Texels:
    """The neutral of a map as an image, what lies outside the chart replaced by what is nearest inside."""
    sheet, at = tile.sheet_of(name)
    kind = next(kind for kind in tile.maps if kind.name == name)
    # Of normals, whose third number is not stored.
    whole: NDArray[Any] = packed_neutral(
        unpacked_neutral(sheet.neutral[..., at], kind), kind, 8 * sheet.neutral.itemsize
    )
    filled: Texels = sheet.fill(whole)
    return filled


def _image(glb: GlbBuilder, name: str, texels: Texels) -> int:
    return _texture(glb, name, {"source": glb.image(name, png(texels), "image/png")})


def _texture(glb: GlbBuilder, name: str, source: GltfObject) -> int:
    textures = glb.document["textures"]
    textures.append({"name": name, "sampler": 0, **source})
    return len(textures) - 1


def _write_tile(tile: Tile, folder: Path) -> None:
    for dialect in (GLSL, HLSL):
        (folder / f"facezip.{dialect.name}").write_text(shader(tile, dialect), encoding="utf-8")


def _write_head(source: Source, folder: Path, form: Format) -> None:
    write_glb(source, folder / GLB_FILE, folder if form is BASIS else None)
    words = head_words(source, GLSL) | {"suffix": form.suffix_of(form.name)}
    (folder / "GUIDE.md").write_text(render("gltf/guide.j2", **words), encoding="utf-8")


export_gltf = Target("gltf", {"png": PNG, "ktx2": BASIS}, _write_tile, _write_head)
