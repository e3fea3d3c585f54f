"""The viewer's pixels and vertices are those of the model: at most two steps of 255 anywhere."""

import numpy as np
import pytest

from facezip.character.scans import Character
from facezip.pack.read import read_pack
from facezip.pack.write import write_pack
from facezip.viewer.scene import DELTA_STEPS
from tests.browser.conftest import viewing
from tests.facezip.conftest import random_model

BLENDS = ({}, {"expr_1": 1.0}, {"expr_0": 0.35, "expr_2": 0.8})
CASES = {
    "weights wider than high": {"size": (96, 128), "weights": (12, 16), "expressions": 5},
    "six differences": {"size": (64, 64), "weights": (8, 8), "slots": 6},
    "uniform weights": {"size": (64, 48), "weights": (1, 1)},
    "no mesh": {"size": (32, 32), "weights": (4, 4), "meshes": False},
}


def written(model, folder):
    write_pack(model, folder / "random.facezip")
    return folder / "random.facezip", read_pack(folder / "random.facezip")


@pytest.mark.parametrize("case", CASES)
def test_the_layout_shows_the_blend(context, tmp_path, case):
    pack, model = written(random_model(**{"meshes": True, **CASES[case]}), tmp_path)
    with viewing(context, pack) as viewer:
        if model.meshes:
            viewer.choose("Surface", "Layout")
        viewer.switch("Texel = pixel", True)
        for blend in BLENDS:
            viewer.slide(blend)
            expected = np.rint(255 * model.blend(blend))
            assert np.abs(viewer.layout(*expected.shape[:2]) - expected).max() <= 2


def test_every_slider_moves_the_vertices(context, tmp_path):
    pack, model = written(random_model(meshes=True), tmp_path)
    weights = dict(zip(model.expressions, (0.25, 1.0, 0.6), strict=True))
    with viewing(context, pack) as viewer:
        for blend in ({}, *({name: 0.7} for name in weights), weights):
            viewer.slide(blend)
            viewer.pixels()
            shown = np.reshape(viewer.page.evaluate("Array.from(facezip.stage.face.vertices)"), (-1, 3))
            betas = np.array([blend.get(name, 0) for name in model.expressions])
            expected = model.meshes.neutral + np.tensordot(betas, model.meshes.deltas, 1)
            step = np.abs(model.meshes.deltas).max() / DELTA_STEPS
            np.testing.assert_allclose(shown, expected, atol=betas.sum() * step + 1e-6)


def test_the_wipe_has_the_originals_on_its_left(context, tmp_path):
    model = random_model(size=(64, 64), weights=(8, 8), meshes=True)
    pack, model = written(model, tmp_path)
    rng = np.random.default_rng(1)
    neutral, textures = (rng.integers(0, 256, (*count, 64, 64, 3), np.uint8) for count in ((), (3,)))
    vertices = model.meshes.neutral + model.meshes.deltas
    scans = Character(
        "random", model.meshes.topology, model.expressions, model.meshes.neutral, vertices, neutral, textures
    )
    blend = {"expr_1": 0.5, "expr_2": 0.25}
    betas = np.array([blend.get(name, 0) for name in model.expressions])
    steps = np.tensordot(betas, textures.astype(float) - neutral, 1)
    original, compressed = np.clip(neutral + steps, 0, 255), 255 * model.blend(blend)
    with viewing(context, pack, scans) as viewer:
        viewer.choose("Surface", "Layout")
        viewer.switch("Texel = pixel", True)
        viewer.slide(blend)
        viewer.choose("Side", "Wipe")
        half = viewer.layout(64, 64)
        viewer.choose("Side", "Original")
        whole = viewer.layout(64, 64)
    assert np.abs(whole - original).max() <= 2
    assert np.abs(half[:, :30] - original[:, :30]).max() <= 2
    assert np.abs(half[:, 34:] - compressed[:, 34:]).max() <= 2
