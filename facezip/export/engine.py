"""What exports to all engines share: files from templates, and the head as a GLB."""

import tempfile
from pathlib import Path

from facezip.export.gltf import GLB_FILE, write_glb
from facezip.export.shaders import render
from facezip.export.source import Source
from facezip.textures import write_texture


def write_text(folder: Path, files: dict[str, str], words: dict[str, object]) -> None:
    """Write each file from its template."""
    for file, template in files.items():
        (folder / file).parent.mkdir(exist_ok=True)
        (folder / file).write_text(render(template, **words), encoding="utf-8")


def write_head(source: Source, folder: Path) -> None:
    """Write the head with its morph targets, where the pack has meshes; its own colour is the neutral as PNG."""
    if source.model.meshes is None:
        return
    with tempfile.TemporaryDirectory() as place:
        neutral = Path(place) / "neutral.png"
        write_texture(neutral, source.neutral_texels)
        write_glb(source, folder / GLB_FILE, neutral)
