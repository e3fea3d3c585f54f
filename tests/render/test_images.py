"""The image-diff suite: every light rig on every material, a skin of all maps, and the pipeline's golden renders.

After a change that is meant to be seen: `pytest tests/render/test_images.py --facezip-generate tests/data/references`.
"""

import pytest

from facezip.character.tiles import FIRST_TILE
from facezip.fit.methods import compress
from render.paired import PairedRenderer
from render.skins import SkinMaps, upload
from scenes.cameras import VIEWS, frame_of
from scenes.character import make_character
from scenes.face.capture import MAPS
from scenes.lights import RIGS
from scenes.materials import MATERIALS

EXPRESSION = "smile"
SPP = 64


@pytest.fixture(scope="module")
def scans():
    return make_character(128, 4)


@pytest.fixture(scope="module")
def renderers(scans):
    frame = frame_of(scans.meshes.neutral)
    made = {material: PairedRenderer(scans.meshes.topology, frame, list(RIGS), material, 64) for material in MATERIALS}
    for renderer in made.values():
        renderer.pose(scans.mesh_vertices(EXPRESSION))
    return made


@pytest.mark.parametrize("rig", list(RIGS))
@pytest.mark.parametrize("material", list(MATERIALS))
def test_rigs_and_materials_look_as_they_did(facezip_image, scans, renderers, material, rig):
    skin = upload(SkinMaps(scans.texture(EXPRESSION)))
    facezip_image(lambda seed: renderers[material].render([skin], VIEWS[0], rig, SPP, seed).linear[0])


@pytest.mark.parametrize("material", list(MATERIALS))
def test_a_skin_of_all_maps_looks_as_it_did(facezip_image, renderers, material):
    surface = make_character(128, 2, maps=MAPS)
    maps = {kind.name: kind.decode(surface.texels(EXPRESSION, (kind.name, FIRST_TILE))) for kind in surface.maps}
    skin = upload(SkinMaps(**maps))
    facezip_image(lambda seed: renderers[material].render([skin], VIEWS[1], "side", SPP, seed).linear[0])


@pytest.mark.parametrize("method", ["paper", "refined"])
def test_the_pipeline_gives_what_it_gave(facezip_image, scans, renderers, method):
    skin = upload(SkinMaps(compress(scans, method=method).reconstruct(EXPRESSION)))
    facezip_image(lambda seed: renderers["skin"].render([skin], VIEWS[1], "studio", SPP, seed).linear[0])
