"""The head of a pack: what has to be exact is, displacements are within the tolerance, viewers see the same."""

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given, settings

from facezip.character.scans import MAX_EXPRESSIONS
from facezip.files.accessors import GlbFault
from facezip.files.glb import Glb
from facezip.files.obj import Topology
from facezip.names import MAX_BYTES
from facezip.pack.geometry import SEAM, TOLERANCE, V_UP, head_bytes, read_head
from tests.facezip.conftest import grid_topology

# Without a texture the UVs serve nobody yet.
NO_TEXTURE = {("UNUSED_OBJECT", "/meshes/0/primitives/0/attributes/TEXCOORD_0")}


def sheet(side=6, expressions=3, motion=0.03, seed=0, seam=True):
    """A curved sheet, one corner of which is a seam, and a vertex that no face uses; an expression moves half of it."""
    rng = np.random.default_rng(seed)
    grid = grid_topology(side)
    face_uv = grid.face_uv.copy()
    if seam:
        face_uv[0, 0] = side * side - 1
    heights = rng.normal(0, 0.1, (side * side, 1))
    neutral = np.concatenate([np.c_[grid.uv, heights], [[0.3, 0.2, 0.1]]]).astype(np.float32)
    deltas = rng.normal(0, motion, (expressions, *neutral.shape)) * (np.arange(len(neutral)) % 2)[:, None]
    uv = rng.random(grid.uv.shape).astype(np.float32)
    return Topology(grid.faces, uv, face_uv), neutral, (neutral + deltas).astype(np.float32), names(expressions)


def names(count):
    return tuple(f"expr_{n}" for n in range(count))


def written(topology, neutral, vertices, expressions):
    return head_bytes("sheet", topology, neutral, vertices, expressions)


def size_of(neutral):
    return np.ptp(neutral.astype(float), axis=0).max()


@st.composite
def heads(draw):
    """Any faces over few vertices and UVs, so that seams, doubled UVs and vertices without a face are the rule."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    v, t, f, n = (draw(st.integers(1, most)) for most in (12, 8, 12, 4))
    unit = 10.0 ** draw(st.integers(-6, 6))
    centre = unit * draw(st.sampled_from([0, 1, 100]))
    neutral = (rng.normal(0, unit, (v, 3)) + centre).astype(np.float32)
    neutral[rng.random(v) < draw(st.sampled_from([0, 0.5, 1]))] = neutral[0]
    motion = unit * draw(st.sampled_from([0, 1e-5, 0.1, 5]))
    deltas = rng.normal(0, motion, (n, v, 3)) * (rng.random((n, v, 1)) < draw(st.sampled_from([0.2, 1])))
    uv = rng.normal(0.5, draw(st.sampled_from([1e-4, 0.3, 2])), (t, 2)).astype(np.float32)
    faces, face_uv = (rng.integers(0, most, (f, 3)).astype(np.int32) for most in (v, t))
    return Topology(faces, uv, face_uv), neutral, (neutral + deltas).astype(np.float32), names(n)


@settings(deadline=None)
@given(heads())
def test_a_head_comes_back(head):
    topology, neutral, vertices, expressions = head
    seen, plain, moved = read_head(written(*head), expressions)
    np.testing.assert_array_equal(plain.view(np.uint32), neutral.view(np.uint32))
    np.testing.assert_array_equal(seen.faces, topology.faces)
    np.testing.assert_array_equal(seen.uv[seen.face_uv], topology.uv[topology.face_uv])
    off = np.linalg.norm(moved.astype(float) - vertices, axis=2).max()
    rounding = 2**-23 * max(np.abs(vertices).max(), np.abs(neutral).max())
    assert off <= TOLERANCE * (size_of(neutral) or np.abs(vertices - neutral).max()) + rounding
    assert (seen.faces.dtype, seen.face_uv.dtype, seen.uv.dtype) == (np.int32, np.int32, np.float32)


@settings(deadline=None)
@given(heads())
def test_what_was_read_writes_the_same_bytes(head):
    content = written(*head)
    topology, neutral, vertices = read_head(content, head[3])
    # A unit away from the origin, floats are coarser than steps.
    if np.abs(neutral).max() < 10 * size_of(neutral):
        assert written(topology, neutral, vertices, head[3]) == content


@settings(deadline=None, max_examples=300)
@given(st.integers(0, 2**32), st.integers(0, 7))
def test_a_flipped_bit_is_refused_or_still_a_head(place, bit):
    head = sheet()
    content = bytearray(written(*head))
    content[place % len(content)] ^= 1 << bit
    try:
        topology, neutral, vertices = read_head(bytes(content), head[3])
    except GlbFault:
        return
    assert vertices.shape[1:] == neutral.shape
    assert all(np.isfinite(values).all() for values in (vertices, neutral, topology.uv))
    for indices, values in ((topology.faces, neutral), (topology.face_uv, topology.uv)):
        assert 0 <= indices.min() <= indices.max() < len(values)


def test_a_head_that_ends_early_is_refused():
    head = sheet(side=3)
    content = written(*head)
    for end in range(len(content)):
        with pytest.raises(GlbFault):
            read_head(content[:end], head[3])


def pushed(by):
    topology, neutral, _, _ = sheet()
    return topology, neutral, np.stack([neutral, neutral + np.float32(by)]), names(2)


HEADS = {
    "seam": sheet(),
    "no seam": sheet(seam=False),
    "moves further than 16 bits": sheet(motion=3),
    "does not move": pushed(0),
    "moves everywhere": pushed(0.1),
    "more vertices than 16 bits": sheet(side=260, expressions=2),
}


@pytest.mark.parametrize("kind", HEADS)
def test_the_validator_finds_nothing_but_the_lack_of_a_texture(kind, node, tmp_path):
    (tmp_path / "head.glb").write_bytes(written(*HEADS[kind]))
    messages = node("validate.mjs", tmp_path / "head.glb")["messages"]
    assert {(message["code"], message["pointer"]) for message in messages} <= NO_TEXTURE


@pytest.mark.parametrize("kind", [kind for kind in HEADS if not kind.startswith("more")])
def test_three_js_moves_every_corner_to_the_same_place(kind, node, tmp_path):
    topology, neutral, vertices, expressions = HEADS[kind]
    (tmp_path / "head.glb").write_bytes(written(*HEADS[kind]))
    seen = node("three.mjs", tmp_path / "head.glb")
    corners = np.array(seen["index"])
    base = np.array(seen["position"]).reshape(-1, 3)
    assert seen["names"] == list(expressions)
    assert seen["relative"]
    np.testing.assert_array_equal((base * seen["scale"])[corners], neutral[topology.faces].reshape(-1, 3))
    for delta, shape in zip(seen["deltas"], vertices, strict=True):
        moved = (base + np.array(delta).reshape(-1, 3)) * seen["scale"]
        expected = shape[topology.faces].reshape(-1, 3)
        assert np.linalg.norm(moved[corners] - expected, axis=1).max() <= TOLERANCE * size_of(neutral)
    uv = np.array(seen["uv"]).reshape(-1, 2)[corners]
    np.testing.assert_allclose(uv, topology.uv[topology.face_uv].reshape(-1, 2) * [1, -1] + [0, 1], atol=1e-6)


def test_an_expression_takes_eight_bytes_for_each_vertex_that_moves():
    topology, neutral, vertices, expressions = sheet(side=60, expressions=1, seam=False)
    resting = written(topology, neutral, np.stack([neutral]), expressions)
    assert 8 * 1800 < len(written(topology, neutral, vertices, expressions)) - len(resting) < 8 * 1800 + 400


def test_names_of_any_number_and_length_are_read_back():
    topology, neutral, _, _ = sheet(side=3)
    expressions = tuple(f"{n:05}{'é' * ((MAX_BYTES - 5) // 2)}" for n in range(MAX_EXPRESSIONS))
    vertices = np.broadcast_to(neutral + np.float32(1 / 3), (MAX_EXPRESSIONS, *neutral.shape))
    assert read_head(written(topology, neutral, vertices, expressions), expressions)[2].shape == vertices.shape


def test_a_head_of_no_size_is_refused():
    topology, neutral, vertices, expressions = sheet()
    with pytest.raises(GlbFault, match="smaller"):
        written(topology, neutral * np.float32(1e-31), vertices * np.float32(1e-31), expressions)


def other_names(document):
    document["meshes"][0]["extras"]["targetNames"].reverse()


def second_mesh(document):
    document["meshes"] *= 2


def second_primitive(document):
    document["meshes"][0]["primitives"] *= 2


def odd_scale(document):
    document["nodes"][0]["scale"] = [0.3, 0.3, 0.3]


def uneven_scale(document):
    document["nodes"][0]["scale"][1] /= 2


def turned(document):
    document["nodes"][0]["rotation"] = [0, 0, 0, 1]


def moved_normals(document):
    for target in document["meshes"][0]["primitives"][0]["targets"]:
        target["NORMAL"] = target["POSITION"]


def seams_elsewhere(document):
    attributes = document["meshes"][0]["primitives"][0]["attributes"]
    document["accessors"][attributes[SEAM]]["sparse"]["indices"]["byteOffset"] += 2


def no_faces(document):
    del document["meshes"][0]["primitives"][0]["indices"]


def fewer_faces(document):
    document["accessors"][document["meshes"][0]["primitives"][0]["indices"]]["count"] -= 1


def normals_for_uvs(document):
    attributes = document["meshes"][0]["primitives"][0]["attributes"]
    attributes["TEXCOORD_0"] = attributes["NORMAL"]


def exact_v_of_another_kind(document):
    attributes = document["meshes"][0]["primitives"][0]["attributes"]
    attributes[V_UP] = attributes["TEXCOORD_0"]


def compressed(document):
    document["extensionsRequired"].append("KHR_draco_mesh_compression")


def nothing(document):
    document.clear()


CHANGES = [
    other_names,
    second_mesh,
    second_primitive,
    odd_scale,
    uneven_scale,
    turned,
    moved_normals,
    seams_elsewhere,
    no_faces,
    fewer_faces,
    normals_for_uvs,
    exact_v_of_another_kind,
    compressed,
    nothing,
]


@pytest.mark.parametrize("change", CHANGES)
def test_another_layout_is_refused(change):
    head = sheet()
    glb = Glb.parse(written(*head))
    change(glb.document)
    with pytest.raises(GlbFault):
        read_head(glb.to_bytes(), head[3])


def test_a_small_file_that_claims_many_expressions_is_refused_before_they_take_memory():
    topology, neutral, vertices, expressions = sheet(side=80, expressions=1)
    glb = Glb.parse(written(topology, neutral, vertices, expressions))
    mesh = glb.document["meshes"][0]
    mesh["primitives"][0]["targets"] *= MAX_EXPRESSIONS
    mesh["extras"]["targetNames"] = list(names(MAX_EXPRESSIONS))
    with pytest.raises(GlbFault, match="attack"):
        read_head(glb.to_bytes(), names(MAX_EXPRESSIONS))
