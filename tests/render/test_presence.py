"""A picture without a face is an error, whatever its other numbers say."""

from dataclasses import replace

import numpy as np
import pytest

from facezip.character.maps import ALBEDO
from facezip.errors import ErrorCode, FaceZipError
from render.presence import check_present, face_triangles
from scenes.tiles import in_tiles
from tests.facezip.conftest import random_character, with_albedo

SEEN = np.array([[-1, 0], [1, 1]], np.int32)
GREY = np.full((2, 2, 3), 0.5, np.float32)


def refused(linear, triangles, face):
    with pytest.raises(FaceZipError) as error:
        check_present(linear, triangles, np.array(face), "smile, front view")
    assert error.value.code is ErrorCode.NOTHING_TO_SEE
    assert str(error.value).startswith("smile, front view: ")
    return str(error.value)


def test_a_face_in_the_picture_is_let_through():
    check_present(GREY, SEEN, np.array([True, False]), "smile")


def test_a_face_that_covers_no_pixel_is_refused():
    assert "the face covers no pixel" in refused(GREY, SEEN, [False, False, True])
    assert "the head covers no pixel" in refused(GREY, np.full_like(SEEN, -1), [True, True])


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_values_that_are_no_numbers_are_refused(value):
    linear = GREY.copy()
    linear[0, 0, 1] = value
    assert "no numbers" in refused(linear, SEEN, [True, True])


def test_a_black_face_is_refused_whatever_is_around_it():
    linear = GREY.copy()
    linear[1] = 0
    assert "black" in refused(linear, SEEN, [False, True])


def masked(mask):
    return with_albedo(random_character(side=32), mask=mask.astype(np.float32))


def test_all_triangles_are_of_the_face_where_no_mask_is():
    assert face_triangles(random_character()).all()


@pytest.mark.parametrize("tiles", [(1, 1), (2, 1), (1, 2)])
def test_triangles_are_of_the_face_where_the_mask_shows_them(tiles):
    mask = np.zeros((32, 32))
    mask[:, :8] = 1
    scans = in_tiles(masked(mask), *tiles)
    topology = scans.meshes.topology
    left = topology.uv[topology.face_uv][:, :, 0].min(axis=1) / tiles[0]
    on_face = face_triangles(scans)
    assert on_face[left < 0.2].all()
    assert not on_face[left > 0.26].any()


def test_a_mask_that_no_triangle_bears_has_no_face():
    scans = masked(np.zeros((32, 32)))
    assert not face_triangles(replace(scans, stacks={key: scans.stacks[key] for key in [(ALBEDO, 1001)]})).any()
