from dataclasses import dataclass, replace
from pathlib import Path

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given, settings

from facezip import FaceZipError
from facezip.character.correspondence import UV_TOLERANCE, in_order_of
from facezip.errors import ErrorCode
from facezip.files.obj import Topology

NAME = Path("smile.obj")


@dataclass(frozen=True, eq=False)
class Written:
    """A mesh as a file would hold it."""

    vertices: np.ndarray
    topology: Topology

    def with_topology(self, **changes):
        return replace(self, topology=replace(self.topology, **changes))


def sheet(rng, side):
    """A sheet of quads, cut in two along a seam of its UVs, with two vertices that no triangle uses."""
    y, x = np.mgrid[:side, :side]
    corner = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    quads = np.stack([corner, corner + 1, corner + side + 1, corner + side], axis=1)
    faces = quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
    right = (corner % side >= side // 2).repeat(2)
    left_uv = np.stack([x, y], axis=2).reshape(-1, 2) / (2.1 * side)
    uv = np.concatenate([left_uv, left_uv + 0.5])
    vertices = rng.normal(size=(side**2 + 2, 3)).astype(np.float32)
    face_uv = faces + right[:, None] * side**2
    return Written(vertices, Topology(faces.astype(np.int32), uv.astype(np.float32), face_uv.astype(np.int32)))


def cut_otherwise(rng, mesh):
    """Some quads along the other diagonal."""
    faces, face_uv = mesh.topology.faces.reshape(-1, 6).copy(), mesh.topology.face_uv.reshape(-1, 6).copy()
    some = rng.random(len(faces)) < 0.5
    for corners in (faces, face_uv):
        a, b, c, d = corners[some][:, [0, 1, 2, 5]].T
        corners[some] = np.stack([a, b, d, b, c, d], axis=1)
    return mesh.with_topology(faces=faces.reshape(-1, 3), face_uv=face_uv.reshape(-1, 3))


def turned(rng, mesh):
    """Triangles begin at another corner."""
    order = (rng.integers(0, 3, (len(mesh.topology.faces), 1)) + np.arange(3)) % 3
    faces, face_uv = (np.take_along_axis(each, order, 1) for each in (mesh.topology.faces, mesh.topology.face_uv))
    return mesh.with_topology(faces=faces, face_uv=face_uv)


def reordered(rng, mesh):
    order = rng.permutation(len(mesh.topology.faces))
    return mesh.with_topology(faces=mesh.topology.faces[order], face_uv=mesh.topology.face_uv[order])


def unshared_uvs(rng, mesh):
    uv = mesh.topology.uv[mesh.topology.face_uv].reshape(-1, 2)
    return mesh.with_topology(uv=uv, face_uv=np.arange(len(uv), dtype=np.int32).reshape(-1, 3))


def reordered_uvs(rng, mesh):
    order = rng.permutation(len(mesh.topology.uv))
    return mesh.with_topology(
        uv=mesh.topology.uv[order], face_uv=np.argsort(order)[mesh.topology.face_uv].astype(np.int32)
    )


def rounded_uvs(rng, mesh):
    return mesh.with_topology(uv=mesh.topology.uv.round(5))


def renumbered(rng, mesh):
    """Vertices in another order."""
    order = rng.permutation(len(mesh.vertices))
    return Written(
        mesh.vertices[order], replace(mesh.topology, faces=np.argsort(order)[mesh.topology.faces].astype(np.int32))
    )


def copied(rng, mesh):
    """A vertex for each pair of vertex and UV, and none that is not used."""
    corners = np.stack([mesh.topology.faces, mesh.topology.face_uv], axis=2).reshape(-1, 2)
    pairs, index = np.unique(corners, axis=0, return_inverse=True)
    faces = index.reshape(-1, 3).astype(np.int32)
    return Written(mesh.vertices[pairs[:, 0]], replace(mesh.topology, faces=faces))


def soup(rng, mesh):
    """A vertex for each corner."""
    faces = np.arange(mesh.topology.faces.size, dtype=np.int32).reshape(-1, 3)
    return Written(mesh.vertices[mesh.topology.faces].reshape(-1, 3), replace(mesh.topology, faces=faces))


def spare(rng, mesh):
    """More vertices that no triangle uses, before the others."""
    vertices = np.concatenate([rng.normal(size=(3, 3)).astype(np.float32), mesh.vertices])
    return Written(vertices, replace(mesh.topology, faces=mesh.topology.faces + 3))


# In an order in which each can follow the others.
NUMBERED = (cut_otherwise, turned, reordered, unshared_uvs, reordered_uvs, rounded_uvs)
WRITINGS = (cut_otherwise, renumbered, copied, soup, spare, *NUMBERED[1:])


@st.composite
def written(draw, ways=WRITINGS):
    """A neutral, an expression in its order, and the same as it may be written."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    neutral = sheet(rng, draw(st.integers(3, 7)))
    meant = replace(neutral, vertices=rng.normal(size=neutral.vertices.shape).astype(np.float32))
    seen = meant
    for way in ways:
        if draw(st.booleans()):
            seen = way(rng, seen)
    return neutral, meant, seen, rng


def ordered(neutral, seen):
    return in_order_of(NAME, neutral.vertices, neutral.topology, seen.vertices, seen.topology)


@settings(deadline=None, max_examples=300)
@given(written())
def test_a_mesh_is_in_the_neutrals_order_however_it_was_written(case):
    neutral, meant, seen, _ = case
    used = np.unique(neutral.topology.faces)
    np.testing.assert_array_equal(ordered(neutral, seen)[used], meant.vertices[used])


@settings(deadline=None)
@given(written(NUMBERED))
def test_vertices_of_the_neutrals_numbers_stay_as_they_are(case):
    neutral, meant, seen, _ = case
    np.testing.assert_array_equal(ordered(neutral, seen), meant.vertices)


@settings(deadline=None)
@given(written())
def test_a_neutral_with_copies_of_its_vertices_takes_a_mesh_without(case):
    neutral, meant, seen, rng = case
    apart = soup(rng, neutral)
    np.testing.assert_array_equal(ordered(apart, seen), meant.vertices[neutral.topology.faces].reshape(-1, 3))


@settings(deadline=None)
@given(written())
def test_a_neutral_whose_uvs_differ_in_their_last_digits_at_every_corner_is_the_same(case):
    neutral, meant, seen, rng = case
    noise = rng.uniform(-1e-6, 1e-6, (neutral.topology.faces.size, 2)).astype(np.float32)
    loose = unshared_uvs(rng, neutral)
    loose = loose.with_topology(uv=loose.topology.uv + noise)
    used = np.unique(neutral.topology.faces)
    np.testing.assert_array_equal(ordered(loose, seen)[used], meant.vertices[used])


def mirrored(rng, mesh):
    return mesh.with_topology(uv=mesh.topology.uv * np.float32([-1, 1]) + np.float32([1, 0]))


def moved_uv(rng, mesh):
    uv = mesh.topology.uv.copy()
    uv[rng.choice(mesh.topology.face_uv.ravel())] += np.float32(30 * UV_TOLERANCE)
    return mesh.with_topology(uv=uv)


def fewer(rng, mesh):
    keep = rng.permutation(len(mesh.topology.faces)) > 0
    return mesh.with_topology(faces=mesh.topology.faces[keep], face_uv=mesh.topology.face_uv[keep])


def more(rng, mesh):
    at = rng.integers(len(mesh.topology.faces))
    faces, face_uv = (
        np.concatenate([each, each[at : at + 1, ::-1]]) for each in (mesh.topology.faces, mesh.topology.face_uv)
    )
    return mesh.with_topology(faces=faces, face_uv=face_uv)


def wound(rng, mesh):
    at = rng.integers(len(mesh.topology.faces))
    faces, face_uv = mesh.topology.faces.copy(), mesh.topology.face_uv.copy()
    faces[at], face_uv[at] = faces[at, ::-1].copy(), face_uv[at, ::-1].copy()
    return mesh.with_topology(faces=faces, face_uv=face_uv)


def another(rng, mesh):
    """A corner that lies elsewhere, in as many triangles."""
    faces, face_uv = mesh.topology.faces.copy(), mesh.topology.face_uv.copy()
    at, uv = rng.integers(len(faces)), mesh.topology.uv
    gaps = np.abs(uv[face_uv][:, :, None] - uv[face_uv[at]]).max(axis=3).min(axis=2)
    elsewhere = tuple(rng.choice(np.argwhere(gaps > 0.01)))
    faces[at, 1], face_uv[at, 1] = faces[elsewhere], face_uv[elsewhere]
    return mesh.with_topology(faces=faces, face_uv=face_uv)


@pytest.mark.parametrize(
    ("spoil", "reason"),
    [
        (mirrored, "another UV layout than neutral.obj at .* corners, first in its triangle"),
        (moved_uv, "another UV layout than neutral.obj at .* corners, first in its triangle"),
        (fewer, r"\d+ triangles, the neutral has \d+; the neutral's triangle \d+ is missing"),
        (more, r"\d+ triangles, the neutral has \d+; its triangle \d+ is not one of the neutral's"),
        (wound, r"its triangle \d+ is wound the other way round"),
        (another, r"another UV layout|its triangle \d+ is not one of the neutral's"),
    ],
)
@settings(deadline=None, max_examples=60)
@given(case=written(NUMBERED[1:]))
def test_another_mesh_is_refused_in_one_line_that_says_where(case, spoil, reason):
    neutral, _, seen, rng = case
    with pytest.raises(FaceZipError, match=rf"^smile\.obj: .*(?:{reason})") as caught:
        ordered(neutral, spoil(rng, seen))
    assert caught.value.code is ErrorCode.TOPOLOGY_MISMATCH
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("spoil", [mirrored, moved_uv, fewer, more, wound, another])
@settings(deadline=None, max_examples=60)
@given(case=written())
def test_another_mesh_is_refused_whatever_else_was_written_otherwise(case, spoil):
    neutral, _, seen, rng = case
    with pytest.raises(FaceZipError, match=r"^smile\.obj: ") as caught:
        ordered(neutral, spoil(rng, seen))
    assert caught.value.code is ErrorCode.TOPOLOGY_MISMATCH


def test_copies_of_a_vertex_that_are_apart_are_refused():
    rng = np.random.default_rng(0)
    neutral = sheet(rng, 4)
    torn = soup(rng, neutral)
    torn.vertices[np.flatnonzero(neutral.topology.faces.ravel() == 5)[0]] += 0.1
    with pytest.raises(FaceZipError, match="vertex 6 of the neutral is at places that lie 0.1 apart"):
        ordered(neutral, torn)


def test_parts_with_the_same_uvs_are_told_apart_by_their_order_alone():
    rng = np.random.default_rng(0)
    part = sheet(rng, 4)
    faces, face_uv = part.topology.faces, part.topology.face_uv
    both = Topology(np.concatenate([faces, faces + 18]), part.topology.uv, np.concatenate([face_uv, face_uv]))
    neutral = Written(rng.normal(size=(36, 3)).astype(np.float32), both)
    used = np.unique(both.faces)
    seen = renumbered(rng, neutral)
    np.testing.assert_array_equal(ordered(neutral, seen)[used], neutral.vertices[used])
    with pytest.raises(FaceZipError, match="is not one of the neutral's"):
        ordered(neutral, reordered(rng, seen))


@pytest.mark.parametrize("corners", [[0, 0, 1], [0, 1, 0], [1, 0, 0]])
def test_a_triangle_of_two_vertices_may_begin_at_any_corner(corners):
    neutral = sheet(np.random.default_rng(0), 3)
    faces = [np.concatenate([neutral.topology.faces, np.array([each], np.int32)]) for each in ([0, 0, 1], corners)]
    mesh, seen = (neutral.with_topology(faces=each, face_uv=each) for each in faces)
    np.testing.assert_array_equal(ordered(mesh, seen), neutral.vertices)


def test_a_triangle_without_area_in_the_uvs_may_begin_at_any_corner_and_is_refused():
    rng = np.random.default_rng(0)
    neutral = soup(rng, unshared_uvs(rng, sheet(rng, 4)))
    neutral.topology.uv[:3] = neutral.topology.uv[0]
    np.testing.assert_array_equal(ordered(neutral, renumbered(rng, neutral)), neutral.vertices)
    with pytest.raises(FaceZipError, match="is not one of the neutral's"):
        ordered(neutral, reordered(rng, renumbered(rng, neutral)))


def test_a_polygon_may_be_cut_in_any_way():
    around = np.linspace(0, 2 * np.pi, 7, endpoint=False)
    uv = np.stack([np.cos(around), np.sin(around)], axis=1).astype(np.float32)
    fan = np.array([[0, k, k + 1] for k in range(1, 6)], np.int32)
    strip = np.array([[0, 1, 6], [1, 2, 6], [2, 5, 6], [2, 3, 5], [3, 4, 5]], np.int32)
    vertices = np.c_[uv, uv[:, 0] ** 2].astype(np.float32)
    neutral, seen = (Written(vertices, Topology(faces, uv, faces)) for faces in (fan, strip))
    np.testing.assert_array_equal(ordered(neutral, seen), vertices)
    with pytest.raises(FaceZipError, match="its triangle 1 is not one"):
        ordered(neutral, Written(vertices, Topology(strip[[0, 1, 3, 4, 4]], uv, strip[[0, 1, 3, 4, 4]])))
