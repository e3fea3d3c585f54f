"""Godot: shaders for the blend and for the head, a script for its node, import settings beside the textures."""

from dataclasses import replace
from pathlib import Path

from facezip.export.engine import write_head, write_text
from facezip.export.folder import Target
from facezip.export.formats import DDS, KTX2, PNG, Format
from facezip.export.shaders import GLSL, render, shader_words
from facezip.export.source import Source, Tile

DIALECT = replace(GLSL, beta="beta", region_gains="region_gains", activations="activations")
OF_TILE = {"weights.gdshader": "godot/weights.j2", "head.gdshader": "godot/head.j2"}
OF_HEAD = {"facezip_head.gd": "godot/script.j2", "GUIDE.md": "godot/guide.j2"}


def _write_tile(tile: Tile, folder: Path) -> None:
    write_text(folder, OF_TILE, shader_words(tile, DIALECT))
    for image in folder.glob("*.png"):
        settings = render("godot/import.j2", mips=not image.name.startswith(("weights", "masks.", "regions.")))
        (folder / f"{image.name}.import").write_text(settings, encoding="utf-8")


def _write_head(source: Source, folder: Path, form: Format) -> None:
    write_head(source, folder, OF_HEAD, DIALECT, form)


export_godot = Target("godot", {"png": PNG, "dds": DDS, "ktx2": KTX2}, _write_tile, _write_head)
