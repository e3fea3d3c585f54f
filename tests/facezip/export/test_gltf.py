"""The GLB of a pack: valid, its targets those of the pack, whole after other tools have had it."""

import base64
import json

import numpy as np
import pytest

from facezip.character.gltf import split, vertex_normals
from facezip.export import TARGETS
from facezip.files.glb import Glb
from facezip.files.glb_builder import GlbBuilder
from facezip.pack.read import read_pack
from facezip.pack.write import write_pack
from tests.facezip.conftest import grid_topology, random_model
from tests.facezip.export.conftest import smooth_model, with_part


@pytest.fixture(scope="module")
def exported(pack):
    folder = pack.parent / "gltf"
    TARGETS["gltf"](pack, folder)
    return folder


@pytest.fixture(scope="module")
def jointed(pack):
    """Unreal's, which hangs on a joint."""
    folder = pack.parent / "unreal"
    TARGETS["unreal"](pack, folder)
    return folder


def test_the_validator_finds_nothing(exported, jointed, node):
    for folder in (exported, jointed):
        assert node("validate.mjs", folder / "head.glb")["messages"] == []


def test_only_unreal_s_head_hangs_on_a_joint_which_moves_all_of_it(exported, jointed):
    plain, glb = (Glb.read(folder / "head.glb") for folder in (exported, jointed))
    assert not {"skins", "JOINTS_0"} & {*plain.document, *plain.document["meshes"][0]["primitives"][0]["attributes"]}
    (skin,), nodes = glb.document["skins"], glb.document["nodes"]
    assert nodes[0]["skin"] == 0
    assert {key: nodes[skin["joints"][0]].get(key) for key in ("translation", "matrix", "mesh")} == dict.fromkeys(
        ("translation", "matrix", "mesh")
    )
    for part in glb.document["meshes"][0]["primitives"]:
        assert (glb.array(part["attributes"]["JOINTS_0"]) == 0).all()
        assert (glb.array(part["attributes"]["WEIGHTS_0"]) == [1, 0, 0, 0]).all()


def test_uastc_is_valid_and_three_s_transcoder_sees_what_was_measured(tmp_path, node, encoder):
    write_pack(smooth_model(side=16, weights=2), tmp_path / "me.facezip")
    document = TARGETS["gltf"](tmp_path / "me.facezip", tmp_path / "out", textures="ktx2")
    issues = node("validate.mjs", tmp_path / "out" / "head.glb")
    assert issues["numErrors"] == 0
    # The validator does not know KHR_texture_basisu, and says so.
    assert {message["pointer"].split("/")[1] for message in issues["messages"]} <= {"extensionsUsed", "images"}

    files = [tmp_path / "out" / f"{name}.ktx2" for name in ("neutral", *(f"difference_{i}" for i in range(4)))]
    read = node("ktx2.mjs", "--decode", *files)
    assert [(facts["format"], facts["model"], len(facts["levels"])) for facts in read] == [(0, 166, 5)] * 5
    assert [facts["transfer"] for facts in read] == [2, 1, 1, 1, 1]
    neutral, *maps = [np.frombuffer(base64.b64decode(facts["texels"][0]), np.uint8) for facts in read]
    entries = [document.textures[f"difference_{i}"] for i in range(4)]
    maps = [
        (texels.reshape(16, 16, 4)[..., :3] / 255 - entry.zero) * entry.scale
        for texels, entry in zip(maps, entries, strict=True)
    ]
    neutral = neutral.reshape(16, 16, 4)[..., :3].astype(np.float32) / 255
    pack = read_pack(tmp_path / "me.facezip")
    shown = with_part(pack, neutral, np.stack(maps).astype(np.float32))
    gaps = [shown.reconstruct(name) - pack.reconstruct(name) for name in pack.expressions]
    rmse = np.mean([255 * np.sqrt(np.square(gap).mean()) for gap in gaps])
    assert document.codec.name == "uastc"
    assert document.codec.rmse == pytest.approx(rmse, rel=1e-3)


@pytest.mark.parametrize("through", ["as written", "on a joint", "glTF-Transform"])
def test_three_js_sees_the_pack_s_targets(exported, jointed, pack, node, tmp_path, through):
    file = (jointed if through == "on a joint" else exported) / "head.glb"
    if through == "glTF-Transform":
        names = node("transform.mjs", file, tmp_path / "out.glb")["targets"]
        file = tmp_path / "out.glb"
        assert names == list(read_pack(pack).expressions)
        assert node("validate.mjs", file)["numErrors"] == 0
    seen, model = node("three.mjs", file), read_pack(pack)
    assert seen["names"] == list(model.expressions)
    assert seen["relative"]
    assert seen["textured"]
    topology, corners = model.meshes.topology, np.array(seen["index"])
    neutral = np.array(seen["position"]).reshape(-1, 3)[corners]
    np.testing.assert_array_equal(neutral, model.meshes.neutral[topology.faces].reshape(-1, 3))
    for delta, expected in zip(seen["deltas"], model.meshes.deltas, strict=True):
        moved = np.array(delta).reshape(-1, 3)[corners]
        np.testing.assert_array_equal(moved, expected[topology.faces].reshape(-1, 3))
    uv = np.array(seen["uv"]).reshape(-1, 2)[corners]
    np.testing.assert_allclose(uv, topology.uv[topology.face_uv].reshape(-1, 2) * [1, -1] + [0, 1], atol=1e-6)


def test_the_document_names_everything(exported, pack):
    document, model = json.loads((exported / "facezip.json").read_text()), read_pack(pack)
    assert document["order"] == list(model.expressions)
    assert [entry["morph_target"] for entry in document["expressions"].values()] == [0, 1, 2, 3, 4]
    for entry in document["textures"].values():
        assert (exported / entry["file"]).is_file()


def test_vertices_are_split_only_where_uvs_differ():
    topology = grid_topology(4)
    assert len(split(topology).vertex) == 16
    seam = topology.face_uv.copy()
    seam[0, 0] = 15  # one corner of one triangle looks elsewhere
    parts = split(type(topology)(topology.faces, topology.uv, seam))
    assert len(parts.vertex) == 17
    np.testing.assert_array_equal(parts.vertex[parts.faces], topology.faces)
    assert (np.diff(parts.vertex) >= 0).all()


def test_normals_do_not_see_seams_and_have_length_one():
    topology = grid_topology(5)
    vertices = np.c_[topology.uv, np.zeros(25)].astype(np.float32)
    np.testing.assert_allclose(vertex_normals(vertices, topology.faces), np.tile([0, 0, 1], (25, 1)), atol=1e-7)
    bent = vertices + np.random.default_rng(0).normal(0, 0.05, vertices.shape).astype(np.float32)
    np.testing.assert_allclose(np.linalg.norm(vertex_normals(bent, topology.faces), axis=1), 1, atol=1e-6)


@pytest.mark.parametrize("share", [0, 0.02, 0.5, 1])
def test_sparse_arrays_read_back_and_never_take_more(share):
    rng = np.random.default_rng(0)
    values = rng.normal(size=(500, 3)).astype(np.float32)
    values[rng.random(500) >= share] = 0
    builder = GlbBuilder({})
    # As a morph target beside its neutral: readers doubt a count that nothing in the file bears out.
    builder.array(np.ones_like(values))
    builder.sparse(values)
    glb = Glb.parse(builder.finish().to_bytes())
    np.testing.assert_array_equal(glb.array(1), values)
    assert len(glb.binary) <= 2 * values.nbytes


def test_a_pack_without_meshes_is_refused_for_gltf_and_has_no_glb_elsewhere(tmp_path):
    from facezip import FaceZipError

    write_pack(random_model(), tmp_path / "me.facezip")
    with pytest.raises(FaceZipError, match="no meshes"):
        TARGETS["gltf"](tmp_path / "me.facezip", tmp_path / "gltf")
    assert not (tmp_path / "gltf").exists()
    TARGETS["godot"](tmp_path / "me.facezip", tmp_path / "godot")
    assert not (tmp_path / "godot" / "head.glb").exists()
