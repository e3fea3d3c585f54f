"""Masks in exports: documents and images give every weight map, and nothing but numbers is there for an expression."""

import base64
import json

import numpy as np
import pytest

from facezip.export import TARGETS
from facezip.export.masks import MOST_VECTORS
from facezip.export.source import read_source
from facezip.files.images import read_texture_exactly
from facezip.pack.read import read_pack
from facezip.pack.write import write_pack
from tests.facezip.conftest import masked, random_model
from tests.facezip.export.conftest import layered_model

COMBINING = ("gltf", "godot", "three", "unity", "unreal", "usd")


def exported(model, folder, target):
    write_pack(model, folder / "me.facezip")
    TARGETS[target](folder / "me.facezip", folder / target)
    return folder / target


def weight_maps(folder):
    """Weight maps ``(N, h, w, 4 L)`` by a tile's ``facezip.json`` and ``masks.png`` alone."""
    document = json.loads((folder / "facezip.json").read_text(encoding="utf-8"))
    masks, count = document["masks"], len(document["order"])
    rows = np.frombuffer(base64.b64decode(masks["activations"]), "<f2").astype(float)
    activations = rows.reshape(count, document["layers"], -1, 4)
    image, (height, width) = read_texture_exactly(folder / masks["file"]) / 255, masks["size"]
    places = [divmod(k // 4, masks["columns"]) for k in range(len(masks["names"]))]
    each = [
        image[height * row : height * (row + 1), width * column : width * (column + 1), k % 4]
        for k, (row, column) in enumerate(places)
    ]
    used = activations[:, :, : len(each)]
    assert not activations[:, :, len(each) :].any()
    assert masks["vectors"] == activations.shape[1] * activations.shape[2]
    return np.einsum("nlks,khw->nhwls", used, np.stack(each)).reshape(count, height, width, -1)


@pytest.mark.parametrize("target", COMBINING)
def test_image_and_document_give_every_weight_map(tmp_path, target):
    folder = exported(masked(layered_model(tiles=(1001, 1002), slots=5), 9), tmp_path, target)
    model = read_pack(tmp_path / "me.facezip")
    for tile in model.tiles:
        seen = weight_maps(folder / str(tile))
        np.testing.assert_allclose(seen[..., :5], model.weights[tile], atol=1e-5)
        assert not seen[..., 5:].any()


@pytest.mark.parametrize("target", COMBINING)
def test_an_expression_adds_its_activations_and_no_texel(tmp_path, target):
    """Weight maps of 52 expressions would take 16 times the texels of those of 3."""
    images = {}
    for count in (3, 52):
        (tmp_path / str(count)).mkdir()
        folder = exported(masked(random_model(expressions=count, meshes=True)), tmp_path / str(count), target)
        images[count] = {file.name: read_texture_exactly(file).shape for file in folder.glob("*.png")}
        activations = json.loads((folder / "facezip.json").read_text(encoding="utf-8"))["masks"]["activations"]
        assert len(base64.b64decode(activations)) == 2 * count * 8 * 4
        assert "masks.png" in images[count]
        assert not [name for name in images[count] if name.startswith("weights")]
    assert images[3] == images[52]


def test_what_has_no_pre_pass_takes_weight_maps(tmp_path):
    folder = exported(masked(random_model(meshes=True)), tmp_path, "blender")
    document = json.loads((folder / "facezip.json").read_text(encoding="utf-8"))
    assert "masks" not in document
    assert (folder / "weights_0.png").is_file()


@pytest.mark.parametrize(("count", "is_combined"), [(MOST_VECTORS // 4 * 4, True), (MOST_VECTORS, False)])
def test_more_masks_than_a_shader_takes_become_weight_maps(tmp_path, count, is_combined):
    write_pack(masked(random_model(), count), tmp_path / "me.facezip")
    (tile,) = read_source(tmp_path / "me.facezip").tiles
    assert (tile.masks is not None) == is_combined
    assert len(tile.weight_images) == (0 if is_combined else 1)
