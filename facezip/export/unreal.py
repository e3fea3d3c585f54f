"""Unreal: HLSL for Custom nodes, and a Python script that imports everything into the editor and builds materials."""

from dataclasses import replace
from pathlib import Path

from facezip.export.engine import write_head, write_text
from facezip.export.folder import Target
from facezip.export.maps import PNG, Format
from facezip.export.shaders import HLSL, number, shader_words, target_numbers
from facezip.export.source import Source

# The engine's own macro, which also works where a stage has no derivatives.
DIALECT = replace(HLSL, sample="Texture2DSample({texture}, clamped, {uv})")
# Render targets hold weights from minus to plus half of this, in 32-bit floats.
SPAN = 64.0
FILES = {
    "FaceZip.ush": "blend.j2",
    "head_node.hlsl": "unreal/head.j2",
    "setup_facezip.py": "unreal/setup.j2",
    "GUIDE.md": "unreal/guide.j2",
}


def _write(source: Source, folder: Path, form: Format) -> None:
    words = shader_words(source.manifest, DIALECT) | {"span": number(SPAN)}
    write_head(source, folder)
    write_text(folder, FILES, words)
    for target in target_numbers(source.manifest):
        write_text(folder, {f"weights_{target}_node.hlsl": "unreal/weights.j2"}, words | {"target": target})


export_unreal = Target("unreal", {"png": PNG}, _write)
