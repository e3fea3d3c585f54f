"""USD: a head with UsdSkel blend shapes, an animation, and its blend as MaterialX; a UsdPreviewSurface as fallback.

USD cannot connect a blend shape's weight to a material. So what is exported is an animation: its weight maps are
blended beforehand, a small image a frame, and are time samples of the material.
"""

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path

import numpy as np

from facezip.export.animation import Frame, blended, check, every_expression, read_animation
from facezip.export.documents.tiles import ExportDocument, TilesDocument
from facezip.export.engine import write_text
from facezip.export.folder import Target
from facezip.export.formats import PNG, Format
from facezip.export.gltf import stored_neutral
from facezip.export.network import ROUGHNESS, weights_file
from facezip.export.shaders import GLSL, head_words, number
from facezip.export.source import TOGETHER, Source, Tile
from facezip.export.usd_geometry import geometry_words
from facezip.export.usd_nodes import material_words, node_words
from facezip.files.images import write_texture, write_values
from facezip.pack.footprint import SLOTS_PER_LAYER

OF_TILE = {"facezip.mtlx": "usd/mtlx.j2"}
OF_HEAD = {"head.usda": "usd/head.j2", "GUIDE.md": "usd/guide.j2"}
PREVIEW_NORMAL = "preview_normal.png"
FRAMES_A_SECOND = 24
# What numbers are taken for whose unit is not known, as most scans are in it.
READS = "cm"


def export_usd(
    pack: Path,
    output: Path,
    *,
    maps: str = TOGETHER,
    animation: Path | None = None,
    region: Mapping[str, Path] | None = None,
    overwrite: bool = False,
) -> ExportDocument | TilesDocument:
    """Export a pack as :class:`facezip.export.folder.Target` does, with an animation.

    Parameters
    ----------
    animation : a CSV file (:func:`facezip.export.animation.read_animation`); None for the neutral and every expression,
        a frame each.
    region : as of :func:`facezip.export.source.read_source`; their gains are columns of the animation.
    """
    frames = read_animation(animation) if animation else None
    target = Target("usd", {"png": PNG}, partial(_write_tile, frames), partial(_write_head, frames), reads=READS)
    return target(pack, output, maps=maps, region=region, overwrite=overwrite)


def _frames(frames: Sequence[Frame] | None, tile: Tile) -> Sequence[Frame]:
    shown = every_expression(tile.expressions) if frames is None else frames
    check(shown, tile.expressions, tile.regions.names, tile.name)
    return shown


def _write_tile(frames: Sequence[Frame] | None, tile: Tile, folder: Path) -> None:
    for n, frame in enumerate(_frames(frames, tile)):
        weights = blended(tile, frame)
        weights = np.pad(weights, ((0, 0), (0, 0), (0, -weights.shape[2] % SLOTS_PER_LAYER)))
        for layer in range(weights.shape[2] // SLOTS_PER_LAYER):
            write_values(
                folder / weights_file(layer, n), weights[..., SLOTS_PER_LAYER * layer :][..., :SLOTS_PER_LAYER]
            )
    if "normal" in tile.known:
        write_texture(folder / PREVIEW_NORMAL, stored_neutral(tile, "normal"))
    write_text(folder, OF_TILE, {"nodes": node_words(tile, 1)})


def _write_head(frames: Sequence[Frame] | None, source: Source, folder: Path, form: Format) -> None:
    shown = _frames(frames, source.tiles[0])
    words = head_words(source, GLSL) | {
        "materials": [
            material_words(tile, source.folder_of(tile, folder) != folder, len(shown)) for tile in source.tiles
        ],
        "frames": [[number(frame.get(name, 0.0)) for name in source.expressions] for frame in shown],
        "frames_a_second": FRAMES_A_SECOND,
        "preview_normal": PREVIEW_NORMAL,
        "metres_per_unit": "1" if source.geometry and source.geometry.centimetres else "0.01",
        "roughness": ROUGHNESS,
    }
    write_text(folder, OF_HEAD, words | geometry_words(source))
