"""Unity: HLSL for Shader Graph and a shader of its own, a component that blends once a frame, import settings."""

from dataclasses import replace
from pathlib import Path

from facezip.export.engine import write_head, write_text
from facezip.export.folder import Target
from facezip.export.formats import DDS, PNG, Format
from facezip.export.shaders import HLSL, shader_words
from facezip.export.source import Source, Tile

# Unity's own importer of DDS turns some formats over and others not: these files have an importer of theirs.
BLOCKS = replace(DDS, suffix=".{codec}")
DIALECT = replace(
    HLSL,
    beta="_FaceZipBeta",
    region_gains="_FaceZipRegionGains",
    activations="_FaceZipActivations",
    rows_from_below=True,
    encoded_if="UNITY_COLORSPACE_GAMMA",
)
OF_TILE = {
    "FaceZip.hlsl": "unity/include.j2",
    "FaceZipWeights.shader": "unity/weights.j2",
    "FaceZipHead.shader": "unity/head.j2",
}
OF_HEAD = {
    "FaceZipHead.cs": "unity/component.j2",
    "Editor/FaceZipImport.cs": "unity/import.j2",
    "Editor/FaceZipBlocks.cs": "unity/blocks.j2",
    "GUIDE.md": "unity/guide.j2",
}


def _write_tile(tile: Tile, folder: Path) -> None:
    write_text(folder, OF_TILE, shader_words(tile, DIALECT))


def _write_head(source: Source, folder: Path, form: Format) -> None:
    write_head(source, folder, OF_HEAD, DIALECT, form)


export_unity = Target("unity", {"png": PNG, "dds": BLOCKS}, _write_tile, _write_head, upside_down=True)
