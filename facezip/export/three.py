"""three.js: a module that shows the head in a scene, an example of a page, and three.js itself to open it with."""

import shutil
from pathlib import Path

from facezip.export.engine import write_text
from facezip.export.folder import Target
from facezip.export.formats import HALVES, Format
from facezip.export.gltf import GLB_FILE, write_glb
from facezip.export.shaders import GLSL, head_words
from facezip.export.source import APART, Source, Tile
from facezip.viewer.page import bundle_folder

OF_HEAD = {"index.html": "three/page.j2", "GUIDE.md": "three/guide.j2"}
# Of the viewer's bundle.
MODULE = "three"


def _write_tile(tile: Tile, folder: Path) -> None:
    """Nothing: the module writes the shaders of a tile from its document."""


def _write_head(source: Source, folder: Path, form: Format) -> None:
    shutil.copytree(bundle_folder(MODULE), folder, dirs_exist_ok=True)
    write_text(folder, OF_HEAD, head_words(source, GLSL))
    write_glb(source, folder / GLB_FILE, pictured=False)


export_three = Target("three", {"png": HALVES}, _write_tile, _write_head, maps=(APART,))
