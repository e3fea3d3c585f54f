"""Five people who never were, with all their maps: from the front, from the side of the front, and near.

python -m reports.people docs/people.webp studio
python -m reports.people docs/people_side.webp side
"""

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from facezip.character.maps import normals_of
from render.metrics import display
from render.paired import PairedRenderer
from render.scattering import spread
from render.skins import SkinMaps, upload
from scenes.cameras import VIEWS, View, frame_of
from scenes.character import Person

SEEDS = (0, 3, 10, 13, 18)
SHOWN = (VIEWS[0], VIEWS[1], View("near", azimuth=-12, elevation=2, extent=0.42, aim=(-0.03, 0.075)))
TEXELS, SIDE, SPP = 2048, 1024, 64
# Columns of a picture that heads fill.
WIDTH = 640
BACKDROP = 0.012


def people(light: str) -> NDArray[np.uint8]:
    """``(3·SIDE, 5·WIDTH, 3)``: one column a person, one row a view."""
    return np.concatenate([_column(Person.make(TEXELS, seed), light) for seed in SEEDS], axis=1)


def _column(person: Person, light: str) -> NDArray[np.uint8]:
    relief, vertices = person.relief({}), person.head.vertices
    maps = SkinMaps(person.albedo, normals_of(relief.slopes), relief.roughness, relief.specular, relief.cavity)
    skin = upload(maps, spread(person.head.topology, vertices))
    renderer = PairedRenderer(person.head.topology, frame_of(vertices), [light], "soft", SIDE)
    renderer.pose(vertices)
    pictures = []
    for view in SHOWN:
        images = renderer.render([skin], view, light, SPP, 0)
        shown = display(images.linear[0] + (1 - images.coverage[..., None]) * np.float32(BACKDROP))
        pictures.append(shown[:, (SIDE - WIDTH) // 2 : (SIDE + WIDTH) // 2])
    return np.rint(np.concatenate(pictures) * 255).astype(np.uint8)


if __name__ == "__main__":
    Image.fromarray(people(sys.argv[2])).save(Path(sys.argv[1]), quality=80, method=6)
