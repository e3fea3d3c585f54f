"""Blender: a script that builds the head with node groups, drivers and gains; textures and the head beside it."""

from pathlib import Path

from facezip.character.maps import MAX_SLOPE
from facezip.export.engine import write_text
from facezip.export.folder import Target
from facezip.export.formats import PNG, Format
from facezip.export.gltf import GLB_FILE, write_glb
from facezip.export.network import DIFFUSE_CAVITY, ROUGHNESS, SPECULAR
from facezip.export.shaders import GLSL, head_words, number
from facezip.export.source import Source, Tile

OF_HEAD = {"build_head.py": "blender/build.j2", "GUIDE.md": "blender/guide.j2"}


def _write_tile(tile: Tile, folder: Path) -> None:
    """Nothing: the script knows a tile by its ``facezip.json`` and textures."""


def _write_head(source: Source, folder: Path, form: Format) -> None:
    write_glb(source, folder / GLB_FILE)
    constants = {"max_slope": MAX_SLOPE, "roughness": ROUGHNESS, "specular": SPECULAR, "diffuse_cavity": DIFFUSE_CAVITY}
    said = {name: number(value) for name, value in constants.items()}
    write_text(folder, OF_HEAD, head_words(source, GLSL) | said)


export_blender = Target("blender", {"png": PNG}, _write_tile, _write_head, expands=True)
