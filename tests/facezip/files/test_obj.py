import random
import re
import tempfile
from pathlib import Path

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given, settings

from facezip import FaceZipError
from facezip.files import objlines
from facezip.files.obj import only_materials, read_obj, write_obj
from tests.facezip.conftest import grid_topology
from tests.facezip.files.other_readers import disagreements
from tests.facezip.files.spellings import Mesh, random_mesh, spell
from tests.trust.meshes import KINDS
from tests.trust.mutations import mutate

SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
LINE_END = r"\r\n|\r|\n"
LAYOUT = "vt 0 0\nvt 1 0\nvt 1 1\nf 1/1 2/2 3/3\n"


@pytest.fixture(scope="module")
def place():
    with tempfile.TemporaryDirectory() as folder:
        yield Path(folder)


@st.composite
def spelled(draw) -> tuple[Mesh, bytes]:
    """A mesh, and one of its valid spellings."""
    rng = random.Random(draw(st.integers(0, 2**32)))
    mesh = random_mesh(rng)
    return mesh, spell(rng, mesh)


@st.composite
def mutants(draw) -> bytes:
    rng = random.Random(draw(st.integers(0, 2**32)))
    return mutate(rng, spell(rng, random_mesh(rng)), KINDS)


def read(place, text):
    (place / "a.obj").write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_obj(place / "a.obj")


def test_a_mesh_reads_back_bit_for_bit(tmp_path):
    vertices = np.random.default_rng(0).normal(size=(25, 3)).astype(np.float32)
    topology = grid_topology(5)
    write_obj(tmp_path / "a.obj", vertices, topology)
    back, same = read_obj(tmp_path / "a.obj")
    np.testing.assert_array_equal(back, vertices)
    for name in ("faces", "uv", "face_uv"):
        np.testing.assert_array_equal(getattr(same, name), getattr(topology, name))


@settings(deadline=None, max_examples=300)
@given(spelled())
def test_a_mesh_is_the_same_however_it_is_spelled(place, case):
    mesh, text = case
    vertices, topology = read(place, text)
    np.testing.assert_array_equal(vertices, mesh.vertices.astype(np.float32))
    np.testing.assert_array_equal(topology.uv, mesh.uv.astype(np.float32))
    np.testing.assert_array_equal(np.stack([topology.faces, topology.face_uv], axis=2), mesh.triangles)


@settings(deadline=None)
@given(spelled())
def test_two_other_readers_read_the_same_triangles(place, case):
    _, text = case
    assert not disagreements(text, place / "plain.obj", *read(place, text))


@settings(deadline=None)
@given(spelled())
def test_triangles_keep_the_material_of_their_polygon(place, case):
    mesh, text = case
    vertices, topology = read(place, text)
    names = [name for polygon, name in zip(mesh.polygons, mesh.materials, strict=True) for _ in polygon[2:]]
    assert set(topology.materials) == set(names)
    for material in topology.materials:
        some, part = only_materials(vertices, topology, [material])
        mine = mesh.triangles[[name == material for name in names]]
        np.testing.assert_array_equal(some[part.faces], mesh.vertices.astype(np.float32)[mine[:, :, 0]])
        np.testing.assert_array_equal(part.uv[part.face_uv], mesh.uv.astype(np.float32)[mine[:, :, 1]])
        assert len(topology.materials) == 1 or len(some) == len(np.unique(part.faces))


def test_a_material_that_is_not_there_is_named(place):
    vertices, topology = read(place, f"usemtl skin\n{SQUARE}f 1/1 2/2 3/3\n")
    with pytest.raises(FaceZipError, match="no material 'eyes'; this mesh has 'skin'"):
        only_materials(vertices, topology, ["eyes"])


@settings(deadline=None, max_examples=300)
@given(mutants())
def test_compiled_code_reads_what_is_read_line_by_line(place, text):
    with pytest.MonkeyPatch.context() as patch:
        fast = answer(place, text)
        patch.setattr(objlines, "read_plain_lines", lambda text, at, lists: at)
        slow = answer(place, text)
    assert fast == slow


def answer(place, text):
    """All that is read, or the refusal."""
    try:
        vertices, topology = read(place, text)
    except FaceZipError as refusal:
        return str(refusal)
    arrays = vertices, topology.faces, topology.uv, topology.face_uv
    return [array.tolist() for array in arrays], topology.materials


@settings(deadline=None)
@given(spelled(), st.data())
def test_a_line_that_is_not_understood_is_refused_with_its_number(place, case, data):
    text = case[1]
    text = (text.decode("utf-16") if text[:2] in (b"\xff\xfe", b"\xfe\xff") else text.decode("utf-8-sig")) + "\n"
    begins = [end.end() for end in re.finditer(LINE_END, text) if text[: end.start()][-1:] != "\\"]
    at = data.draw(st.sampled_from([0, *begins]))
    number = len(re.findall(LINE_END, text[:at])) + 1
    with pytest.raises(FaceZipError, match=f"a.obj: line {number}: 'frob' is no keyword"):
        read(place, f"{text[:at]}frob 1 2 3\n{text[at:]}")


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        ("", "no 'v' lines"),
        ("v 0 0 0\nf 1/1 1/1 1/1\n", "no 'vt' lines"),
        (SQUARE, "no 'f' lines"),
        (SQUARE + "f 1 2 3\n", "line 9: the corner '1' names no UV, although there are 4 'vt' lines before it"),
        (SQUARE + "f 1//1 2//1 3//1\n", "line 9: the corner '1//1' names no UV"),
        (SQUARE + "f 1/1 2/2 3\n", "line 9: the corner '3' names no UV"),
        (SQUARE + "f 1/1 2/2/1 3/3\n", "line 9: some of the corners have normals"),
        (SQUARE + "f 1/1/0 2/2/1 3/3/1\n", "line 9: a corner has the normal 0"),
        (SQUARE + "f 1/1/1/1 2/2/1/1 3/3/1/1\n", "line 9: the corner '1/1/1/1' is not vertex/uv"),
        (SQUARE + "f 1/1/1/ 2/2/1/ 3/3/1/\n", "line 9: the corner '1/1/1/' is not vertex/uv"),
        (SQUARE + "f 1/1 2/2\n", "line 9: a face has at least 3 corners, this one 2"),
        (SQUARE + "f 1/1 2/2 9/3\n", "line 9: there is no vertex 9"),
        (SQUARE + "f 1/1 2/2 3/9\n", "line 9: there is no UV 9"),
        (SQUARE + "f 0/1 2/2 3/3\n", "line 9: there is no vertex 0"),
        (SQUARE + "f -5/1 2/2 3/3\n", "line 9: there is no vertex -5"),
        ("f -1/-1 -1/-1 -1/-1\n" + SQUARE, "line 1: there is no vertex -1"),
        (SQUARE + f"f 1/1 2/2 {'9' * 20}/3\n", "line 9: there is no vertex 9999"),
        (SQUARE + f"f 1/1 2/2 3/{'9' * 9999}\n", "line 9: there is no UV 9999"),
        (SQUARE + "v 0 nan 0\nf 1/1 2/2 3/3\n", "line 9: 'nan' is no finite number"),
        (SQUARE + "v 0 1.#IND 0\nf 1/1 2/2 3/3\n", "line 9: '1.#IND' is no finite number"),
        (SQUARE + "v 0 inf 0\nf 1/1 2/2 3/3\n", "line 9: 'inf' is no finite number"),
        (SQUARE + "v 0 1e31 0\nf 1/1 2/2 3/3\n", "line 9: the number 1e31 is huge"),
        (SQUARE + "v 0 1,5 0\nf 1/1 2/2 3/3\n", "line 9: '1,5' is no finite number"),
        (SQUARE + "v 0 0\nf 1/1 2/2 3/3\n", "line 9: a 'v' line holds 3 or 4 or 6 or 7 numbers, this one 2"),
        (SQUARE + "v 0 0 0 0 0\nf 1/1 2/2 3/3\n", "line 9: a 'v' line holds 3 or 4 or 6 or 7 numbers, this one 5"),
        (SQUARE + "v 0 0 0 2\nf 1/1 2/2 3/3\n", "line 9: the vertex has the weight 2"),
        (SQUARE + "vt 0\nf 1/1 2/2 3/3\n", "line 9: a 'vt' line holds 2 or 3 numbers, this one 1"),
        (SQUARE + "vn 0 0 1v 0 0 0\nf 1/1 2/2 3/3\n", "line 9: a 'vn' line holds 3 numbers, this one 6"),
        (SQUARE + "F 1/1 2/2 3/3\n", "line 9: 'F' is no keyword"),
        (SQUARE + "fo 1/1 2/2 3/3\n", "line 9: 'fo' is the form of a face that was given up"),
        (SQUARE + "cstype bezier\n", "line 9: 'cstype' is of free-form curves"),
        (SQUARE + "call more.obj\n", "line 9: 'call' takes in another file"),
        (SQUARE + "f 1/1 2/2 3/3 \\ \n4/4\n", "line 9: a blank follows the backslash"),
        (SQUARE + "f 1/1 2/2 3\\\n/3\n", "line 9: goes on within a word"),
        (SQUARE + "f 1/1 2/2 3/3 \\", "line 9: ends in a backslash, and nothing follows"),
        ("# C:\\\n" + SQUARE, "line 1: ends in a backslash"),
        ("mtllib C:\\\n" + SQUARE, "line 1: ends in a backslash"),
        ("v\u00a00\u00a00\u00a00\n" + SQUARE, "line 1: 'v\\xa00\\xa00\\xa00' is no keyword"),
        ("\x00\xff\xfe garbage", "line 1: '\\x00ÿþ' is no keyword"),
    ],
)
def test_a_bad_mesh_is_refused_in_one_line(tmp_path, content, reason):
    (tmp_path / "bad.obj").write_text(content, encoding="utf-8")
    with pytest.raises(FaceZipError, match=r"bad\.obj") as caught:
        read_obj(tmp_path / "bad.obj")
    assert reason in str(caught.value)
    assert "\n" not in str(caught.value)


@settings(deadline=None)
@given(st.data())
def test_a_mesh_that_was_cut_anywhere_is_to_be_exported_again(place, data):
    write_obj(place / "whole.obj", np.random.default_rng(0).normal(size=(25, 3)).astype(np.float32), grid_topology(5))
    text = (place / "whole.obj").read_bytes()
    text = text[: data.draw(st.integers(1, len(text) - 1))]
    said = answer(place, text)
    if isinstance(said, str) and "lines" not in said:
        assert said == f"{place / 'a.obj'}: the file ends within line {len(text.splitlines())}; export it again"
    elif not text.endswith(b"\n"):
        assert not isinstance(said, str) or "its last line does not end: it may be cut off" in said


@pytest.mark.parametrize(
    "line", ["f", "f 1", "f 1/", "f 1/1", "f 1/1 2/", "f 1/1 2/2 3", "v", "v 1. 0", "v 1 1 1e", "vt 1", "use"]
)
def test_a_cut_line_is_not_to_be_removed(place, line):
    with pytest.raises(FaceZipError, match=r"a\.obj: the file ends within line 10; export it again"):
        read(place, f"{SQUARE}f 1/1 2/2 3/3\n{line}")
    with pytest.raises(FaceZipError, match=r"a\.obj: line 10: "):
        read(place, f"{SQUARE}f 1/1 2/2 3/3\n{line}\n")


def test_a_file_without_a_last_line_end_is_read_as_with_one(place):
    assert answer(place, SQUARE + "f 1/1 2/2 3/3") == answer(place, SQUARE + "f 1/1 2/2 3/3\n")
    assert "no 'f' lines, and its last line does not end" in answer(place, SQUARE.strip())


def test_half_a_file_of_two_bytes_a_letter_is_refused(place):
    with pytest.raises(FaceZipError, match="UTF-16"):
        read(place, SQUARE.encode("utf-16") + b"\x00\xd8\n")


def test_numbers_of_any_length_are_read_as_python_reads_them(place):
    rng = np.random.default_rng(0)
    written = [
        f"{rng.choice(['', '-', '+'])}{number:.{rng.integers(0, 40)}{rng.choice(list('feg'))}}"
        for number in np.abs(rng.normal(size=3000)) * 10.0 ** rng.integers(-40, 20, 3000)
    ]
    # Half-way between two float32, and the next float64 beside.
    low = np.abs(rng.normal(size=500)).astype(np.float32)
    half = (low.astype(float) + np.nextafter(low, np.float32(9)).astype(float)) / 2
    beside = np.concatenate([half, np.nextafter(half, 0), np.nextafter(half, 9)])
    written += [f"{number:.{digits}g}" for number in beside for digits in (17, 18, 30)]
    rows = "".join(f"v {' '.join(written[k : k + 3])}\n" for k in range(0, len(written), 3))
    vertices, _ = read(place, rows + LAYOUT)
    np.testing.assert_array_equal(vertices.ravel(), np.array([*map(float, written)]).astype(np.float32))


def test_a_polygon_becomes_a_fan_from_its_first_corner(place):
    _, topology = read(place, SQUARE + "v 2 2 0\nvt .5 .5\nf 2/2 3/3 4/4 1/1 5/5\nf 1/1 2/2 3/3\n")
    np.testing.assert_array_equal(topology.faces, [[1, 2, 3], [1, 3, 0], [1, 0, 4], [0, 1, 2]])
