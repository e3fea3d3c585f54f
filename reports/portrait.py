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

from facezip import load_surface
from facezip.commands.candidates import candidate, staged_character, staged_original
from render.metrics import display
from render.paired import PairedRenderer
from render.skins import upload
from scenes.cameras import View, frame_of

EXPRESSIONS = ("brows_up", "smile", "anger", "jaw_open", "squeeze")
VIEW = View("portrait", azimuth=6, elevation=3, extent=0.80, aim=(0.0, 0.075))
SIDE, MARGIN, SPP = 420, 30, 144
BACKDROP = 0.012
FULL_SCALE = 8


def portrait(character_folder: Path, pack: Path, light: str = "studio") -> NDArray[np.uint8]:
    """``(3·SIDE, …, 3)``: one column an expression; differences in inferno, lightest at 8 of 255."""
    surface = load_surface(character_folder)
    character, sides = staged_character(surface), (staged_original(surface), candidate(surface, pack).texture)
    renderer = PairedRenderer(character.topology, frame_of(character.neutral_vertices), [light], "skin", SIDE)
    columns = []
    for name in EXPRESSIONS:
        renderer.pose(character.mesh_vertices(name))
        images = renderer.render([upload(side(name)) for side in sides], VIEW, light, SPP, 0)
        original, compressed = display(images.linear + (1 - images.coverage[..., None]) * np.float32(BACKDROP))
        error = np.abs(original - compressed).max(axis=2) * 255 / FULL_SCALE
        heat = mpl.colormaps["inferno"](np.clip(error, 0, 1))[..., :3]
        columns.append(np.concatenate([original, compressed, heat])[:, MARGIN:-MARGIN])
    picture: NDArray[np.uint8] = np.rint(np.concatenate(columns, axis=1) * 255).astype(np.uint8)
    return picture


if __name__ == "__main__":
    scans, compressed_pack, target = map(Path, sys.argv[1:4])
    Image.fromarray(portrait(scans, compressed_pack, *sys.argv[4:])).save(target, quality=88, method=6)
