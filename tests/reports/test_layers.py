"""The page of layers: its numbers are those of the textures, its names tell layers apart, and it stands alone."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from facezip.character.meshes import Meshes
from facezip.character.tiles import Atlas
from facezip.documents.document import plain
from facezip.files.obj import Topology
from facezip.fit.methods import compress
from facezip.pack.read import read_pack
from facezip.pack.write import write_pack
from reports.layers.head import Sight
from reports.layers.measure import Uses, measure_uses
from reports.layers.report import describe
from tests.facezip.conftest import random_character
from tests.facezip.surfaces import random_surface
from tests.test_layered_commands import run


def test_a_level_is_how_far_a_layer_moves_the_texture():
    """With one layer that is the difference of the reconstruction and the neutral, which nothing clips here."""
    model = compress(random_character(side=64), differences=1)
    model = replace(model, weights={1001: model.weights[1001] * np.float32(0.1)})
    uses = measure_uses(model)
    neutral = model.reconstruct("neutral")
    for n, name in enumerate(model.expressions):
        moved = 255 * np.sqrt(np.mean(np.square(model.reconstruct(name) - neutral, dtype=np.float64)))
        assert uses.levels[n, 0] == pytest.approx(moved, rel=1e-3)


def test_masks_do_together_what_their_layers_do():
    """Masks that do not overlap share out the squares of a layer."""
    model = compress(random_character(side=64, expressions=6), "masks", masks=4, differences=2)
    masked, halves = model.masked, np.zeros((4, 8, 8), np.uint8)
    for k in range(4):
        halves[k, 4 * (k // 2) : 4 * (k // 2) + 4, 4 * (k % 2) : 4 * (k % 2) + 4] = 255
    fours = np.repeat(np.repeat(halves, 8, axis=1), 8, axis=2)
    model = replace(model, weights=replace(masked, masks={1001: fours}))
    uses = measure_uses(model)
    expected = np.einsum("nki,kig->nig", np.square(model.masked.activations.astype(np.float64)), uses.masks)
    np.testing.assert_allclose(expected, uses.squares, rtol=1e-5)


def test_names_tell_layers_apart():
    regions = ("mouth", "left eye", "right eye", "nose")
    squares = np.array([[[8.0, 1, 1, 1], [4, 3, 3, 1], [4, 6, 1, 1]]])
    uses = Uses(regions, squares, 100, np.zeros((0, 3, 4)))
    assert [uses.name_of(i).split(" and ")[0] for i in range(3)] == ["mouth", "eyes", "left eye"]
    alike = Uses(regions, np.repeat(squares[:, :1], 2, axis=1), 100, np.zeros((0, 2, 4)))
    assert alike.name_of(0) == alike.name_of(1) == "mouth"


def test_the_front_of_a_head_hides_its_back():
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32)
    faces = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    points = np.concatenate([np.c_[square, np.full(4, z)] for z in (0.5, -0.5)]).astype(np.float32)
    uv = np.concatenate([square * [0.5, 1], square * [0.5, 1] + [0.5, 0]]).astype(np.float32)
    both = np.concatenate([faces, faces + 4])
    meshes = Meshes(Topology(both, uv, both), points, points[None])
    texture = np.zeros((8, 8, 3), np.float32)
    texture[:, :4, 0], texture[:, 4:, 2] = 1, 1
    for order in (slice(None), slice(None, None, -1)):
        turned = replace(meshes, topology=Topology(both[order], uv, both[order]))
        picture = Sight.of_head(turned, points, Atlas.of((1001,)), 32).picture(texture)
        assert (picture[8:24, 8:24, 0] > 100).all()
        assert (picture[8:24, 8:24, 2] == 0).all()


@pytest.fixture(scope="module", params=["refined", "pca", "masks"])
def page(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("layers")
    scans = random_surface(expressions=5, tiles=(2, 1))
    scans = replace(scans, expressions=("a<b>&", *scans.expressions[1:]))
    options = {"masks": 9} if request.param == "masks" else {}
    write_pack(compress(scans, request.param, differences=3, **options), folder / "a.facezip")
    done = run("layers", folder / "a.facezip", "-o", folder / "page", "--json")
    assert done.returncode == 0, done.stderr
    return folder, json.loads(done.stdout)


def test_the_page_has_everything_and_needs_nothing(page):
    folder, document = page
    html = (folder / "page" / "index.html").read_text()
    model = read_pack(folder / "a.facezip")
    assert json.loads((folder / "page" / "layers.json").read_text()) == document == plain(describe(model, "a"))
    assert not re.search(r'(?:src|href)="(?!data:|#)', html)
    assert "a&lt;b&gt;&amp;" in html
    assert "<b>&" not in html
    assert [row["name"] for row in document["expressions"]] != []
    assert {row["name"] for row in document["expressions"]} == {*model.expressions}
    assert sorted(layer["layer"] for layer in document["layers"]) == [0, 1, 2]
    # A picture of each weight map, and for each layer one above, two of what it does, its weights and its maps.
    masks = len(model.masked.names) if model.masked else 0
    assert html.count("<img ") == 5 * 3 + 3 * (1 + 3 + 3) + masks
    assert html.count("<image ") == (3 if masks else 0)


def test_what_is_strongest_comes_first(page):
    _, document = page
    levels = [layer["level"] for layer in document["layers"]]
    assert levels == sorted(levels, reverse=True)
    for layer in document["layers"]:
        each = [use["level"] for use in layer["expressions"]]
        assert each == sorted(each, reverse=True)
        assert sum(region["share"] for region in layer["regions"]) == pytest.approx(1)
    main = [int(np.argmax(row["levels"])) for row in document["expressions"]]
    assert main == sorted(main)


def test_another_folder_is_not_replaced(page, tmp_path):
    folder, _ = page
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "a.txt").write_text("mine")
    done = run("layers", folder / "a.facezip", "-o", tmp_path / "mine", "--overwrite")
    assert done.returncode == 4
    assert (tmp_path / "mine" / "a.txt").read_text() == "mine"
