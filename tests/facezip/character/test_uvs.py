"""UVs: one texture is repeated over the plane, tiles are not; nothing is clamped to a border in silence."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facezip import ErrorCode, FaceZipError
from facezip.character.loading import load_character, save_character
from facezip.character.meshes import check_digits
from facezip.character.tiles import place_of
from facezip.character.uvs import check_on_tiles, in_unit_square
from facezip.files.obj import Topology, write_obj
from tests.facezip.conftest import grid_topology, random_character
from tests.facezip.surfaces import random_surface

MESH, TEXEL = Path("neutral.obj"), 1 / 1024
SHEET = grid_topology(5)
SQUARES = st.tuples(st.integers(-40, 40), st.integers(-40, 40))


def sheets(*places, side=0.3):
    """Charts of one sheet: each at (u, v), of a side."""
    count = len(SHEET.uv)
    uv = np.concatenate([SHEET.uv * side + np.array(place) for place in places]).astype(np.float32)
    faces = np.concatenate([SHEET.faces + k * count for k in range(len(places))])
    return replace(SHEET, faces=faces, uv=uv, face_uv=faces)


def refused(call, *arguments):
    with pytest.raises(FaceZipError) as caught:
        call(MESH, *arguments)
    assert caught.value.code is ErrorCode.UNREADABLE_MESH
    assert str(caught.value).startswith("neutral.obj: ")
    return str(caught.value)


# The first call compiles.
@settings(deadline=None)
@given(SQUARES, SQUARES)
def test_charts_in_any_unit_squares_come_back_to_where_a_repeated_texture_shows_them(one, other):
    apart = (0.1, 0.1), (0.6, 0.5)
    whole, notes = in_unit_square(MESH, sheets(*apart), TEXEL)
    assert notes == []
    moved, notes = in_unit_square(MESH, sheets(*np.add(apart, [one, other])), TEXEL)
    np.testing.assert_allclose(moved.uv, whole.uv, atol=1e-5)
    assert len(notes) == ((one, other) != ((0, 0), (0, 0)))
    assert all(note.asks == (one != other) for note in notes)


@given(SQUARES, st.floats(0.71, 0.99), st.booleans(), st.booleans())
def test_a_chart_across_a_border_is_refused_wherever_it_lies(square, start, along_u, along_v):
    place = np.add(square, [start if along_u or not along_v else 0.2, start if along_v else 0.2])
    assert "across its border" in refused(in_unit_square, sheets(tuple(place)), TEXEL)


@settings(deadline=None)
@given(st.sampled_from([(1, 0), (0, 1), (3, -2)]))
def test_charts_of_several_squares_that_would_share_texels_are_refused(step):
    two = sheets((0.1, 0.1), tuple(np.add((0.15, 0.2), step)))
    assert "by their tiles" in refused(in_unit_square, two, TEXEL)


@given(st.integers(2**14, 2**22))
def test_uvs_without_digits_for_a_texel_are_refused(far):
    for call in (in_unit_square, lambda *a: check_on_tiles(*a[:2], (1001,), a[2])):
        assert "no digits" in refused(call, sheets((far + 0.1, 0.1)), TEXEL)


@given(st.sets(st.integers(1001, 1040), min_size=1, max_size=4), st.integers(1001, 1040))
def test_triangles_on_a_tile_without_textures_are_refused_and_those_without_triangles_are_found(tiles, other):
    places = [np.add(place_of(tile), 0.3) for tile in sorted(tiles)]
    with_textures = tuple(sorted({*tiles, other}))
    assert check_on_tiles(MESH, sheets(*places), with_textures, TEXEL) == tuple({other} - tiles)
    if other not in tiles:
        message = refused(check_on_tiles, sheets(*places, np.add(place_of(other), 0.3)), tuple(sorted(tiles)), TEXEL)
        assert f"tile {other}" in message
        assert f"first of them number {len(places) * len(SHEET.faces) + 1}," in message


@given(st.sampled_from([(-1, 0), (0, -1), (10, 0), (12, 3)]))
def test_triangles_outside_of_all_tiles_are_refused(square):
    assert "outside of all tiles" in refused(check_on_tiles, sheets((0.2, 0.2), np.add(square, 0.2)), (1001,), TEXEL)


def test_a_chart_over_several_tiles_needs_textures_on_all_that_its_triangles_reach():
    across = sheets((0.85, 0.85))
    corner = (1001, 1002, 1011, 1012)
    assert check_on_tiles(MESH, across, corner, TEXEL) == ()
    for missing in corner:
        message = refused(check_on_tiles, across, tuple(tile for tile in corner if tile != missing), TEXEL)
        assert f"tile {missing}" in message


def test_triangles_that_pass_a_square_at_its_corner_do_not_reach_it():
    passing = replace(
        SHEET,
        faces=SHEET.faces[:1],
        face_uv=np.array([[0, 1, 2]]),
        uv=np.array([[0.9, 0.2], [1.9, 0.2], [1.9, 1.7]], np.float32),
    )
    assert check_on_tiles(MESH, passing, (1001, 1002, 1012), TEXEL) == ()
    assert "tile 1012" in refused(check_on_tiles, passing, (1001, 1002, 1011), TEXEL)


def test_a_texel_beside_the_square_is_rounding():
    rounded = replace(SHEET, uv=(SHEET.uv * (1 + TEXEL) - TEXEL / 2).astype(np.float32))
    assert in_unit_square(MESH, rounded, TEXEL) == (rounded, [])
    assert check_on_tiles(MESH, rounded, (1001,), TEXEL) == ()


@settings(max_examples=10, deadline=None)
@given(squares=st.lists(SQUARES, min_size=3, max_size=3))
def test_meshes_whose_uvs_lie_in_squares_of_their_own_are_one_layout(squares, tmp_path_factory):
    character, folder = random_character(expressions=2, side=16), tmp_path_factory.mktemp("scans") / "scans"
    save_character(character, folder)
    topology = character.meshes.topology
    for name, square in zip(("neutral", *character.expressions), squares, strict=True):
        moved = replace(topology, uv=(topology.uv + np.array(square)).astype(np.float32))
        write_obj(folder / f"{name}.obj", character.mesh_vertices(name), moved)
    found = load_character(folder)
    np.testing.assert_allclose(found.meshes.topology.uv, topology.uv, atol=1e-5)
    np.testing.assert_array_equal(found.meshes.vertices, character.meshes.vertices)
    assert len(found.notes) == sum(square != (0, 0) for square in squares)


def test_a_tile_without_triangles_is_noted(tmp_path):
    surface = random_surface(expressions=2, side=16, maps=(), tiles=(2, 1))
    save_character(surface, tmp_path / "scans")
    topology = surface.meshes.topology
    half = replace(topology, uv=(topology.uv * (0.5, 1)).astype(np.float32))
    for name in ("neutral", *surface.expressions):
        write_obj(tmp_path / "scans" / f"{name}.obj", surface.mesh_vertices(name), half)
    (note,) = load_character(tmp_path / "scans").notes
    assert note.file == "neutral.1002.png"
    assert "tile 1002" in note.words


@given(st.floats(0.1, 1000), st.integers(0, 40))
def test_coordinates_that_swallow_a_head_are_refused_and_no_others(size, doublings):
    vertices = np.random.default_rng(0).random((150, 3)) * size
    far = (vertices + size * 2.0**doublings).astype(np.float32)
    moved = np.abs(far.astype(np.float64) - size * 2.0**doublings - vertices).max() / size
    faces = np.arange(150, dtype=np.int32).reshape(-1, 3)
    # A vertex that no face has is of no account, wherever it lies.
    far = np.concatenate([far, [[1e20, 0, 0]]]).astype(np.float32)
    try:
        check_digits(MESH, far, Topology(faces, np.zeros((1, 2), np.float32), 0 * faces))
    except FaceZipError:
        assert moved > 2e-6
    else:
        assert moved < 3e-5
