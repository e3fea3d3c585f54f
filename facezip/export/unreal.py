"""Unreal: HLSL for Custom nodes, and a Python script that imports everything into the editor and builds materials."""

from dataclasses import replace
from pathlib import Path

from facezip.export.engine import write_head, write_text
from facezip.export.folder import Target
from facezip.export.formats import PNG, Format
from facezip.export.shaders import HLSL, number, shader_words, target_numbers
from facezip.export.source import Source, Tile

# The engine's own macro, which also works where a stage has no derivatives.
DIALECT = replace(HLSL, sample="Texture2DSample({texture}, clamped, {uv})")
# Render targets hold weights from minus to plus half of this, in 32-bit floats.
SPAN = 64.0
OF_TILE = {"FaceZip.ush": "blend.j2", "head_node.hlsl": "unreal/head.j2"}
OF_HEAD = {"setup_facezip.py": "unreal/setup.j2", "GUIDE.md": "unreal/guide.j2"}


def _write_tile(tile: Tile, folder: Path) -> None:
    words = shader_words(tile, DIALECT) | {"span": number(SPAN)}
    write_text(folder, OF_TILE, words)
    for target in target_numbers(tile):
        write_text(folder, {f"weights_{target}_node.hlsl": "unreal/weights.j2"}, words | {"target": target})


def _write_head(source: Source, folder: Path, form: Format) -> None:
    # Without a joint an importer may take the head for a static mesh, and its morph targets are lost.
    write_head(source, folder, OF_HEAD, DIALECT, form, jointed=True)


export_unreal = Target("unreal", {"png": PNG}, _write_tile, _write_head)
