import numpy as np
import pytest

from facezip import FaceZipError
from facezip.files.obj import read_obj, write_obj
from tests.facezip.conftest import grid_topology

SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"


def test_a_mesh_reads_back_bit_for_bit(tmp_path):
    vertices = np.random.default_rng(0).normal(size=(25, 3)).astype(np.float32)
    topology = grid_topology(5)
    write_obj(tmp_path / "a.obj", vertices, topology)
    back, same = read_obj(tmp_path / "a.obj")
    np.testing.assert_array_equal(back, vertices)
    assert same.same_as(topology)


@pytest.mark.parametrize("faces", ["f 1/1 2/2 3/3 4/4", "f 1/1/1 2/2/1 3/3/1 4/4/1", "f -4/-4 -3/-3 -2/-2 -1/-1"])
def test_polygons_normals_and_relative_indices_give_the_same_triangles(tmp_path, faces):
    (tmp_path / "a.obj").write_text(f"# comment\nmtllib x.mtl\r\n{SQUARE}vn 0 0 1\n{faces}\n")
    _, topology = read_obj(tmp_path / "a.obj")
    np.testing.assert_array_equal(topology.faces, [[0, 1, 2], [0, 2, 3]])
    np.testing.assert_array_equal(topology.face_uv, topology.faces)


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        ("", "no 'v' lines"),
        ("v 0 0 0\nf 1/1 1/1 1/1\n", "no 'vt' lines"),
        (SQUARE, "no faces"),
        (SQUARE + "f 1 2 3\n", "UVs"),
        (SQUARE + "f 1//1 2//1 3//1\n", "UVs"),
        (SQUARE + "f 1/1 2/2 9/3\n", "does not exist"),
        (SQUARE + "f 1/1 2/2 3/9\n", "does not exist"),
        (SQUARE + "f 0/1 2/2 3/3\n", "does not exist"),
        (SQUARE + "f 1/1 2/2 99999999999999999999/3\n", "UVs"),
        (SQUARE + "v 0 nan 0\nf 1/1 2/2 3/3\n", "NaN"),
        (SQUARE + "v 0 inf 0\nf 1/1 2/2 3/3\n", "infinity"),
        (SQUARE + "v 0 0\nf 1/1 2/2 3/3\n", "3 numbers"),
        (SQUARE + "v a b c\nf 1/1 2/2 3/3\n", "3 numbers"),
        ("\x00\xff\xfe garbage", "no 'v' lines"),
    ],
)
def test_a_bad_mesh_is_refused_in_one_line(tmp_path, content, reason):
    (tmp_path / "bad.obj").write_text(content, encoding="latin-1")
    with pytest.raises(FaceZipError, match="bad.obj") as caught:
        read_obj(tmp_path / "bad.obj")
    assert reason in str(caught.value)
    assert "\n" not in str(caught.value)


LAYOUT = "vt 0 0\nvt 1 0\nvt 1 1\nf 1/1 2/2 3/3\n"


@pytest.mark.parametrize(
    "lines",
    [
        ["v 0 1 2", "v 3 4 5", "v 6 7 8"],
        ["v 0 1 2 1", "v 3 4 5 1", "v 6 7 8 1"],
        ["v 0 1 2 .1 .2 .3", "v 3 4 5 .1 .2 .3", "v 6 7 8 0 0 0"],
        ["v 0 1 2 1", "v 3 4 5", "v 6 7 8"],
        ["v  0\t1  2 ", "v +3 4. 5.0e0", "v 6 .7e1 80E-1"],
        ["v 0 1 2\r", "v 3 4 5\r", "v 6 7 8\r"],
        ["v 0 1 2", "# a remark", "v 3 4 5", "v 6 7 8"],
        ["v 0 1 2", "", "v 3 4 5", "vn 0 0 1", "v 6 7 8"],
        ["o head", "v 0 1 2", "v 3 4 5", "v 6 7 8"],
    ],
)
def test_vertices_are_the_same_however_they_are_written(tmp_path, lines):
    (tmp_path / "a.obj").write_text("\n".join([*lines, LAYOUT]), newline="")
    vertices, _ = read_obj(tmp_path / "a.obj")
    np.testing.assert_array_equal(vertices, np.arange(9).reshape(3, 3))


def test_numbers_of_any_length_are_read_as_python_reads_them(tmp_path):
    random = np.random.default_rng(0)
    written = [
        f"{random.choice(['', '-', '+'])}{number:.{random.integers(0, 24)}{random.choice(list('feg'))}}"
        for number in np.abs(random.normal(size=300)) * 10.0 ** random.integers(-40, 20, 300)
    ]
    rows = [written[k : k + 3] for k in range(0, 300, 3)]
    for k, row in enumerate(rows):
        (tmp_path / "a.obj").write_text(f"v 0 0 0\nv {' '.join(row)}\nv 1 1 1\n{LAYOUT}")
        vertices, _ = read_obj(tmp_path / "a.obj")
        np.testing.assert_array_equal(vertices[1], np.array([*map(float, row)]).astype(np.float32), err_msg=str(k))


def test_vertices_may_stand_after_texture_coordinates(tmp_path):
    before, after = LAYOUT.split("f")
    (tmp_path / "a.obj").write_text(f"{before}v 0 1 2\nv 3 4 5\nv 6 7 8\nf{after}")
    vertices, topology = read_obj(tmp_path / "a.obj")
    np.testing.assert_array_equal(vertices, np.arange(9).reshape(3, 3))
    np.testing.assert_array_equal(topology.uv, [[0, 0], [1, 0], [1, 1]])


@pytest.mark.parametrize(
    "lines",
    [
        ["v 0 1", "v 2 3 4 5", "v 6 7 8"],
        ["v 0 1 2", "v 3 4-5", "v 6 7 8"],
        ["v 0 1 2", "v 3 4 5e", "v 6 7 8"],
        ["v 0 1 2", "v 3 --4 5", "v 6 7 8"],
        ["v 0 1\r2", "v 3 4 5", "v 6 7 8"],
        ["v 0 1 2", "v 3 v 5", "v 6 7 8"],
        ["v 0 1 2", "v 3 4v5", "v 6 7 8"],
    ],
)
def test_vertices_that_are_not_three_numbers_a_line_are_refused(tmp_path, lines):
    (tmp_path / "a.obj").write_text("\n".join([*lines, LAYOUT]), newline="")
    with pytest.raises(FaceZipError, match="'v' line does not hold 3 numbers"):
        read_obj(tmp_path / "a.obj")
