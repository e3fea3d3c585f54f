"""Unreal: HLSL for Custom nodes, and a Python script that imports everything into the editor and builds materials."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from facezip.export.engine import write_head, write_text
from facezip.export.folder import Target
from facezip.export.formats import PNG, Format
from facezip.export.masks import Masks
from facezip.export.shaders import HLSL, SLOTS_PER_TARGET, number, shader_words, target_numbers
from facezip.export.source import Source, Tile
from facezip.files.images import write_values

# The engine's own macro, which also works where a stage has no derivatives.
DIALECT = replace(HLSL, sample="Texture2DSample({texture}, clamped, {uv})")
# Render targets hold weights from minus to plus half of this, in 32-bit floats.
SPAN = 64.0
# Render targets hold activations of either sign, of expressions that an animator doubles.
EXAGGERATION = 2 * 2
ACTIVATIONS_FILE = "activations.exr"
OF_TILE = {"FaceZip.ush": "blend.j2", "head_node.hlsl": "unreal/head.j2"}
OF_HEAD = {"setup_facezip.py": "unreal/setup.j2", "GUIDE.md": "unreal/guide.j2"}


def _write_tile(tile: Tile, folder: Path) -> None:
    words = shader_words(tile, DIALECT) | {"span": number(SPAN)}
    write_text(folder, OF_TILE, words)
    if tile.masks:
        words |= {"activation_span": number(_write_activations(tile.masks, len(target_numbers(tile)), folder))}
        write_text(folder, {"activations_node.hlsl": "unreal/activations.j2"}, words)
    for target in target_numbers(tile):
        write_text(folder, {f"weights_{target}_node.hlsl": "unreal/weights.j2"}, words | {"target": target})


def _write_activations(masks: Masks, targets: int, folder: Path) -> float:
    """Write the activations as a texture: of every expression a row of masks for every three slots. The span of blends.

    Materials run on the GPU alone, so that blends of activations are drawn too.
    """
    count, _, places, _ = masks.vectors.shape
    slots = masks.vectors.astype(np.float32).transpose(0, 2, 1, 3).reshape(count, places, -1)
    padded = np.pad(slots, ((0, 0), (0, 0), (0, SLOTS_PER_TARGET * targets)))[..., : SLOTS_PER_TARGET * targets]
    rows = padded.reshape(count, places, targets, SLOTS_PER_TARGET).transpose(0, 2, 1, 3)
    write_values(folder / ACTIVATIONS_FILE, rows.reshape(-1, places, SLOTS_PER_TARGET))
    return max(SPAN, float(EXAGGERATION * np.abs(slots).sum(axis=0).max()))


def _write_head(source: Source, folder: Path, form: Format) -> None:
    # Without a joint an importer may take the head for a static mesh, and its morph targets are lost.
    write_head(source, folder, OF_HEAD, DIALECT, form, jointed=True)


export_unreal = Target("unreal", {"png": PNG}, _write_tile, _write_head)
