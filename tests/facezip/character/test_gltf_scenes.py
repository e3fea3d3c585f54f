"""Where a glTF's scene shows the face is where the mesh is read: nodes above it, or joints that hold it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from facezip import ErrorCode, FaceZipError, load_character, save_character
from tests.facezip.character.gltfs import Scene, assert_same, corners, scans, words

number = st.floats(-2, 2).map(lambda value: round(value, 3))
triple = st.tuples(number, number, number)
factor = st.sampled_from([0.01, 0.5, 1.0, 2.0, 100.0])


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    return tmp_path_factory.mktemp("gltf")


@st.composite
def nodes(draw):
    """Nodes above a mesh, the outermost last, and the matrix ``(4, 4)`` of all of them."""
    chain, total = [], np.eye(4)
    for _ in range(draw(st.integers(1, 3))):
        turn = Rotation.from_rotvec(draw(triple))
        scale = draw(st.tuples(factor, factor, factor)) if draw(st.booleans()) else (draw(factor),) * 3
        if draw(st.booleans()):
            scale = (-scale[0], *scale[1:])
        matrix = np.eye(4)
        matrix[:3, :3] = turn.as_matrix() @ np.diag(scale)
        matrix[:3, 3] = draw(triple)
        if draw(st.booleans()):
            chain.append({"matrix": matrix.T.ravel().tolist()})
        else:
            moved = matrix[:3, 3].tolist()
            chain.append({"rotation": turn.as_quat().tolist(), "scale": [*scale], "translation": moved})
        total = matrix @ total
    return chain, total


def moved(points, matrix):
    return points @ matrix[:3, :3].T + matrix[:3, 3]


@settings(deadline=None, max_examples=25)
@given(nodes())
def test_any_nodes_are_the_moved_mesh(place, case):
    chain, matrix = case
    character, scene = scans(), Scene(scans())
    scene.document["nodes"] = [{**chain[0], "mesh": 0}]
    for node in chain[1:]:
        scene.document["nodes"].append({**node, "children": [len(scene.document["nodes"]) - 1]})
    scene.document["scenes"][0]["nodes"] = [len(chain) - 1]
    read = scene.read(place)
    expected = moved(corners(character)[0].astype(float), matrix)
    expected = expected[:, :, ::-1] if np.linalg.det(matrix[:3, :3]) < 0 else expected
    np.testing.assert_allclose(corners(read)[0], expected, rtol=0, atol=1e-5 * np.abs(expected).max())
    is_none = np.allclose(matrix, np.eye(4), rtol=0, atol=1e-7)
    assert is_none or any("as its nodes say" in each for each in words(read))


@pytest.mark.parametrize(
    ("node", "said"),
    [
        ({"translation": [0, 1.6, 0]}, "moved as its nodes say"),
        ({"scale": [0.01] * 3}, "scaled as its nodes say"),
        ({"rotation": [0, 1, 0, 0]}, "turned as its nodes say"),
        ({"scale": [-1, 1, 1]}, "mirrored as its nodes say"),
        ({"rotation": [0, 1, 0, 0], "scale": [2] * 3, "translation": [1, 0, 0]}, "turned, scaled and moved as"),
    ],
)
def test_what_nodes_do_is_said(tmp_path, node, said):
    scene = Scene(scans())
    scene.document["nodes"][0].update(node)
    assert any(each.startswith(said) for each in words(scene.read(tmp_path)))


@settings(deadline=None, max_examples=20)
@given(st.lists(nodes(), min_size=2, max_size=3), st.integers(0, 1000), st.booleans())
def test_joints_hold_the_mesh_wherever_its_node_is(place, cases, seed, one_joint):
    rng = np.random.default_rng(seed)
    character, scene = scans(), Scene(scans())
    count = scene.document["accessors"][scene.face["attributes"]["POSITION"]]["count"]
    joints = []
    for chain, _ in cases:
        joints.append(len(scene.document["nodes"]))
        scene.document["nodes"].append(chain[0])
        for node in chain[1:]:
            scene.document["nodes"].append({**node, "children": [len(scene.document["nodes"]) - 1]})
    binds = [Rotation.from_rotvec(rng.normal(size=3)).as_matrix() for _ in cases]
    binds = np.array([np.block([[bind, rng.normal(size=(3, 1))], [np.zeros((1, 3)), 1]]) for bind in binds])
    vertex = character.meshes.topology.faces.ravel()
    which = rng.integers(0, len(cases), (25, 4))[vertex] if not one_joint else np.zeros((count, 4), int)
    weights = rng.dirichlet([1] * 4, 25)[vertex]
    scene.face["attributes"]["JOINTS_0"] = scene.builder.array(which.astype(np.uint8))
    scene.face["attributes"]["WEIGHTS_0"] = scene.array(weights)
    matrices = [binds.swapaxes(1, 2).reshape(-1, 16).astype(np.float32)]
    inverse = scene.builder.view(matrices[0].tobytes())
    described = {"bufferView": inverse, "componentType": 5126, "count": len(binds), "type": "MAT4"}
    skin = {"joints": joints, "inverseBindMatrices": scene.add("accessors", described)}
    scene.document["nodes"][0].update(skin=scene.add("skins", skin), translation=[7, 8, 9])
    held = np.array([matrix for _, matrix in cases]) @ binds
    each = np.einsum("vk,vkij->vij", weights, held[which])
    if (np.abs(np.linalg.det(each[:, :3, :3])) < 1e-6).any():
        return
    points = corners(character)[0].reshape(3, -1, 3).astype(float)
    expected = np.einsum("vij,svj->svi", each[:, :3, :3], points) + each[:, :3, 3]
    read = scene.read(place)
    found = corners(read)[0]
    turned = (np.linalg.det(each[:, :3, :3]) < 0).any()
    found = found[:, :, ::-1] if turned else found
    np.testing.assert_allclose(found.reshape(3, -1, 3), expected, rtol=0, atol=1e-4 * np.abs(expected).max())


def test_of_several_nodes_the_first_of_the_scene_counts(tmp_path):
    scene = Scene(scans())
    scene.document["nodes"].insert(0, {"mesh": 0, "translation": [5, 5, 5]})
    scene.document["nodes"] += [{"mesh": 0, "scale": [2, 2, 2]}]
    scene.document["scenes"][0]["nodes"] = [1, 2]
    read = scene.read(tmp_path)
    assert_same(read, scans())
    assert words(read) == ["3 nodes show it; it is read where the first of them does"]


def test_a_mesh_that_no_node_shows_is_where_it_is(tmp_path):
    scene = Scene(scans())
    scene.document["nodes"] = [{"name": "nothing", "translation": [1, 2, 3]}]
    read = scene.read(tmp_path)
    assert_same(read, scans())
    assert not read.notes


@pytest.mark.parametrize("node", [{"scale": [1, 0, 1]}, {"translation": [1e30, 0, 0]}, {"matrix": [0.0] * 16}])
def test_nodes_that_leave_nothing_of_a_face_are_refused(tmp_path, node):
    scene = Scene(scans())
    scene.document["nodes"][0].update(node)
    with pytest.raises(FaceZipError, match="node"):
        scene.read(tmp_path)


def test_a_head_where_coordinates_are_too_coarse_is_refused_as_of_a_folder(tmp_path):
    scene = Scene(scans())
    scene.document["nodes"][0]["translation"] = [1e6, 0, 0]
    (tmp_path / "glb").mkdir()
    path = scene.write(tmp_path / "glb")
    save_character(scene.read(tmp_path / "glb"), tmp_path / "scans")
    for way in (path, tmp_path / "scans"):
        with pytest.raises(FaceZipError, match="move the meshes to the origin") as refused:
            load_character(way)
        assert refused.value.code is ErrorCode.UNREADABLE_MESH
