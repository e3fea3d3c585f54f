"""glTF: a GLB with named morph targets that shows the neutral, the other maps and the shaders beside it."""

from pathlib import Path
from typing import Any

from facezip.export.folder import Target
from facezip.export.maps import BASIS, PNG, Format
from facezip.export.shaders import GLSL, HLSL, render, shader, shader_words
from facezip.export.source import Source
from facezip.gltf import CLAMPED, add_mesh, skin, start

GLB_FILE = "head.glb"


def write_glb(source: Source, file: Path, texture: Path) -> None:
    """Write the geometry with its morph targets, and ``texture`` (PNG or KTX2) as its colour, as one GLB."""
    glb = start(source.manifest.name)
    add_mesh(glb, source.manifest.name, source.meshes, source.model.expressions)
    basis = texture.suffix == ".ktx2"
    image = glb.image("neutral", texture.read_bytes(), "image/ktx2" if basis else "image/png")
    glb.document |= {
        "samplers": CLAMPED,
        "textures": [{"name": "neutral", "sampler": 0, **_source(image, basis)}],
        "materials": [skin("neutral", 0)],
    }
    if basis:
        glb.document |= {key: ["KHR_texture_basisu"] for key in ("extensionsUsed", "extensionsRequired")}
    file.write_bytes(glb.finish().to_bytes())


def _source(image: int, basis: bool) -> dict[str, Any]:
    return {"extensions": {"KHR_texture_basisu": {"source": image}}} if basis else {"source": image}


def _write(source: Source, folder: Path, form: Format) -> None:
    neutral = folder / f"neutral{form.suffix}"
    write_glb(source, folder / GLB_FILE, neutral)
    for dialect in (GLSL, HLSL):
        (folder / f"facezip.{dialect.name}").write_text(shader(source.manifest, dialect), encoding="utf-8")
    words = shader_words(source.manifest, GLSL) | {"suffix": form.suffix}
    (folder / "GUIDE.md").write_text(render("gltf/guide.j2", **words), encoding="utf-8")


export_gltf = Target("gltf", {"png": PNG, "ktx2": BASIS}, _write)
