"""USD: a head with UsdSkel blend shapes, an animation, and its blend as MaterialX; a UsdPreviewSurface as fallback.

USD cannot connect a blend shape's weight to a material. So what is exported is an animation: its weight maps are
blended beforehand, a small image a frame, and are time samples of the material.
"""

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from facezip.export.animation import Frame, blended, check, every_expression, read_animation
from facezip.export.engine import write_text
from facezip.export.folder import Target
from facezip.export.formats import PNG, Format
from facezip.export.gltf import stored_neutral
from facezip.export.network import ROUGHNESS, Node, Value, blend_network, weights_file
from facezip.export.shaders import GLSL, head_words, number
from facezip.export.source import TOGETHER, Source, Tile
from facezip.export.usd_geometry import geometry_words
from facezip.files.images import write_texture, write_values
from facezip.pack.footprint import SLOTS_PER_LAYER

OF_TILE = {"facezip.mtlx": "usd/mtlx.j2"}
OF_HEAD = {"head.usda": "usd/head.j2", "GUIDE.md": "usd/guide.j2"}
PREVIEW_NORMAL = "preview_normal.png"
FRAMES_A_SECOND = 24
# What numbers are taken for whose unit is not known, as most scans are in it.
READS = "cm"
USD_TYPES = {"vector2": "float2", "vector3": "float3", "vector4": "float4", "color3": "color3f", "filename": "asset"}
USD_TYPES |= {"integer": "int", "surfaceshader": "token"}


def export_usd(
    pack: Path,
    output: Path,
    *,
    maps: str = TOGETHER,
    animation: Path | None = None,
    region: Mapping[str, Path] | None = None,
    overwrite: bool = False,
) -> dict[str, Any]:
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
    write_text(folder, OF_TILE, {"nodes": _nodes(tile, 1)})


def _write_head(frames: Sequence[Frame] | None, source: Source, folder: Path, form: Format) -> None:
    shown = _frames(frames, source.tiles[0])
    words = head_words(source, GLSL) | {
        "materials": [_material(tile, source.folder_of(tile, folder) != folder, len(shown)) for tile in source.tiles],
        "frames": [[number(frame.get(name, 0.0)) for name in source.expressions] for frame in shown],
        "frames_a_second": FRAMES_A_SECOND,
        "preview_normal": PREVIEW_NORMAL,
        "metres_per_unit": "1" if source.geometry and source.geometry.centimetres else "0.01",
        "roughness": ROUGHNESS,
    }
    write_text(folder, OF_HEAD, words | geometry_words(source))


def _material(tile: Tile, apart: bool, frames: int) -> dict[str, Any]:
    """What the template says of a tile's material."""
    grey, at = tile.sheet_of("roughness") if "roughness" in tile.known else (None, slice(0))
    return {
        "number": tile.layout.number,
        "place": f"{tile.layout.number}/" if apart else "",
        "nodes": _nodes(tile, frames),
        "roughness": None if grey is None else (grey.textures[0], "rgb"[at.start]),
    }


def _nodes(tile: Tile, frames: int) -> list[dict[str, Any]]:
    """The nodes of the blend, as templates say them."""
    found, layers = [], range(-(-len(tile.layout.weight_span) // SLOTS_PER_LAYER))
    files = {weights_file(layer, 0): [weights_file(layer, n) for n in range(frames)] for layer in layers}
    for node in blend_network(tile).nodes.values():
        inputs = [_said(name, value, files) for name, value in node.inputs.items()]
        usd_type = USD_TYPES.get(node.type, node.type)
        found.append({**vars(node), "inputs": inputs, "usd_type": usd_type})
    return found


def _said(name: str, value: Value, frames: Mapping[str, Sequence[str]]) -> dict[str, Any]:
    """An input: its type in both languages, the node or value that it takes; of one frame, the files of all."""
    if isinstance(value, Node):
        kind, text = value.type, ""
    elif isinstance(value, tuple):
        kind, text = f"vector{len(value)}", ", ".join(map(number, value))
    elif isinstance(value, float):
        kind, text = "float", number(value)
    elif isinstance(value, int):
        kind, text = "integer", str(value)
    else:
        kind, text = "string" if isinstance(value, str) else "filename", str(value)
    return {
        "name": name,
        "type": kind,
        "usd_type": USD_TYPES.get(kind, kind),
        "node": value.name if isinstance(value, Node) else "",
        "text": text,
        "frames": frames.get(text, ()),
    }
