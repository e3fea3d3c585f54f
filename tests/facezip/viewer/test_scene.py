import io
import zlib
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from facezip import FaceZipError
from facezip.pack.read import read_pack
from facezip.pack.write import write_pack
from facezip.viewer.scene import read_scene
from tests.facezip.conftest import random_character, random_model


def array(scene, name, dtype):
    return np.frombuffer(zlib.decompress(scene.assets[f"{name}.zlib"]()), dtype)


def image(scene, name):
    return np.asarray(Image.open(io.BytesIO(scene.assets[f"{name}.png"]())))


def test_corners_draw_the_triangles_of_the_mesh(pack):
    topology, scene = read_pack(pack).meshes.topology, read_scene(pack)
    triangles = array(scene, "triangles", "<u4")
    np.testing.assert_array_equal(array(scene, "corner_vertices", "<u4")[triangles].reshape(-1, 3), topology.faces)
    uv = array(scene, "corner_uv", "<f4").reshape(-1, 2)[triangles].reshape(-1, 3, 2)
    np.testing.assert_array_equal(uv, topology.uv[topology.face_uv])


def test_deltas_are_rounded_to_half_a_step_at_most(pack):
    meshes, scene = read_pack(pack).meshes, read_scene(pack)
    scale = np.array(scene.document["mesh"]["delta_scale"])[:, None, None]
    deltas = array(scene, "deltas", "<i2").reshape(meshes.deltas.shape) * scale
    assert (np.abs(deltas - meshes.deltas) <= 0.501 * scale).all()


@pytest.mark.parametrize("slots", [3, 4, 6])
@pytest.mark.parametrize("weights", [(3, 5), (1, 1)])
def test_weight_layers_and_ranges_give_the_weights_back(tmp_path, slots, weights):
    write_pack(random_model(slots=slots, weights=weights), tmp_path / "a.facezip")
    model, scene = read_pack(tmp_path / "a.facezip"), read_scene(tmp_path / "a.facezip")
    document, (h, w) = scene.document, weights
    layers = []
    for layer in range(-(-slots // 4)):
        stored = array(scene, f"weights_{layer}", "<f4" if document["uniform"] else "u1").astype(np.float32)
        columns = document["weight_columns"]
        tiles = stored.reshape(-1, h, columns, w, 4).swapaxes(1, 2).reshape(-1, h, w, 4)
        layers.append(tiles[: len(model.expressions)] / (1 if document["uniform"] else 255))
    texels = np.concatenate(layers, axis=3)[..., :slots]
    found = texels * np.float32(document["weight_scale"]) + np.float32(document["weight_offset"])
    np.testing.assert_allclose(found, model.weights, atol=1e-5)


def test_a_neutral_of_16_bits_is_shown_in_8(tmp_path):
    model = random_model()
    write_pack(model, tmp_path / "a.facezip", neutral_bits=16)
    np.testing.assert_array_equal(image(read_scene(tmp_path / "a.facezip"), "neutral"), np.rint(model.neutral * 255))


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_originals_come_in_the_order_of_the_pack(tmp_path, dtype):
    character = random_character(dtype=dtype)
    reversed_names = character.expressions[::-1]
    model = random_model(size=(32, 32), weights=(4, 4), expressions=5)
    write_pack(replace(model, expressions=reversed_names), tmp_path / "a.facezip")
    scene = read_scene(tmp_path / "a.facezip", character)
    for n, name in enumerate(reversed_names):
        np.testing.assert_array_equal(image(scene, f"original_{n}"), np.rint(character.texture(name) * 255))


def test_a_pack_without_meshes_has_a_scene(tmp_path):
    write_pack(random_model(), tmp_path / "flat.facezip")
    assert read_scene(tmp_path / "flat.facezip").document["mesh"] is None


def test_another_character_and_odd_channels_are_refused(pack, tmp_path):
    with pytest.raises(FaceZipError, match=r"random\.facezip: not of sheet, only one of them has 'expr_3'"):
        read_scene(pack, random_character())
    with pytest.raises(FaceZipError, match="another size"):
        read_scene(pack, random_character(expressions=3))
    two = random_model()
    write_pack(replace(two, neutral=two.neutral[..., :2], differences=two.differences[..., :2]), tmp_path / "b.facezip")
    with pytest.raises(FaceZipError, match="2 channels"):
        read_scene(tmp_path / "b.facezip")
