"""Pictures of documents: expressions of a character, original above, compressed in the middle, their difference below.

python -m reports.portrait out/demo/character out/demo/character.facezip docs/portrait.webp
python -m reports.portrait CHARACTER PACK docs/maps.webp side
"""

import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from facezip.character.loading import load_character
from render.candidates import candidate
from render.metrics import display
from render.paired import PairedRenderer
from render.presence import check_present, face_triangles
from render.skins import upload
from render.staging import staged_original, staged_topology
from scenes.cameras import View, frame_of

EXPRESSIONS = ("brows_up", "smile", "anger", "jaw_open", "squeeze")
VIEW = View("portrait", azimuth=6, elevation=3, extent=0.80, aim=(0.0, 0.075))
SIDE, MARGIN, SPP = 420, 30, 144
BACKDROP = 0.012
FULL_SCALE = 8


def portrait(character_folder: Path, pack: Path, light: str = "studio") -> NDArray[np.uint8]:
    """``(3·SIDE, …, 3)``: one column an expression; differences in inferno, lightest at 8 of 255."""
    character = load_character(character_folder)
    sides = staged_original(character), candidate(character, pack).texture
    renderer = PairedRenderer(staged_topology(character), frame_of(character.meshes.neutral), [light], "skin", SIDE)
    columns, face = [], face_triangles(character)
    for name in EXPRESSIONS:
        renderer.pose(character.mesh_vertices(name))
        images = renderer.render([upload(side(name)) for side in sides], VIEW, light, SPP, 0)
        for linear in images.linear:
            check_present(linear, renderer.triangles(VIEW), face, f"{name}, {VIEW.name} view")
        original, compressed = display(images.linear + (1 - images.coverage[..., None]) * np.float32(BACKDROP))
        error = np.abs(original - compressed).max(axis=2) * 255 / FULL_SCALE
        heat = mpl.colormaps["inferno"](np.clip(error, 0, 1))[..., :3]
        columns.append(np.concatenate([original, compressed, heat])[:, MARGIN:-MARGIN])
    picture: NDArray[np.uint8] = np.rint(np.concatenate(columns, axis=1) * 255).astype(np.uint8)
    return picture


if __name__ == "__main__":
    scans, compressed_pack, target = map(Path, sys.argv[1:4])
    Image.fromarray(portrait(scans, compressed_pack, *sys.argv[4:])).save(target, quality=88, method=6)
