"""Heads stand upright and look at +z, whichever way their files had them; what is not certain is asked."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from facezip.character.motion import angle_between, nearest_axes
from facezip.character.orientation import generic_face, orientation_of
from facezip.character.placement import AXES, UNITS, Placement, placed
from facezip.errors import ErrorCode, FaceZipError
from scenes import generic_face as made
from tests.facezip.character.heads import head, moved
from tests.facezip.conftest import random_character

TURNS = Rotation.create_group("O").as_matrix().round()
people = st.tuples(st.integers(0, 2), st.booleans())
turns = st.sampled_from(list(TURNS))


def tilts(most):
    axes = st.sampled_from([(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0), (1, -1, 1)])
    return st.builds(tilt, axes, st.floats(-most, most))


def tilt(axis, degrees):
    return Rotation.from_rotvec(np.radians(degrees) * np.array(axis) / np.linalg.norm(axis)).as_matrix()


def standing(meshes, **stated):
    names = tuple(f"expression_{n:02}" for n in range(len(meshes.vertices)))
    return placed(meshes, names, Placement(**stated), Path("scans"))


# The axes that are found are up to 11 degrees off, and have to be within 30 of those of the space.
@settings(max_examples=8, deadline=None)
@given(people, turns, tilts(15))
def test_a_head_is_turned_by_right_angles_to_where_it_looked_before(person, turn, tilt):
    meshes = head(*person)
    tilted = moved(meshes, tilt)
    found, notes = standing(moved(tilted, turn))
    np.testing.assert_allclose(found.neutral, tilted.neutral, atol=1e-4)
    np.testing.assert_allclose(found.vertices, tilted.vertices, atol=1e-4)
    assert bool(notes) != np.array_equal(turn, np.eye(3))
    assert not any(note.asks for note in notes)


@settings(max_examples=5, deadline=None)
@given(people, st.floats(1e-3, 1e3), tilts(20))
def test_its_axes_are_found_in_any_size_and_place(person, size, tilt):
    meshes = head(*person)
    found = orientation_of(moved(meshes, size * tilt, 3 * size))
    assert angle_between(found.axes, tilt.T) < 15


@settings(max_examples=20, deadline=None)
@given(st.sampled_from(sorted(AXES)), st.sampled_from(sorted(AXES)))
def test_what_character_toml_says_is_done_without_a_look(up, front):
    if up[-1] == front[-1]:
        with pytest.raises(ValueError, match="one line"):
            Placement.of({"up": up, "front": front})
        return
    meshes = random_character().meshes
    found, _ = standing(meshes, **vars(Placement.of({"up": up, "front": front})))
    axes = np.stack([np.cross(AXES[up], AXES[front]), AXES[up], AXES[front]])
    np.testing.assert_allclose(found.neutral, meshes.neutral @ axes.T, atol=1e-5)
    assert np.linalg.det(axes) == 1


@pytest.mark.parametrize("unit", sorted(UNITS))
def test_a_stated_unit_becomes_centimetres(unit):
    centimetres = head()
    found, notes = standing(moved(centimetres, np.eye(3) / UNITS[unit]), unit=unit)
    np.testing.assert_allclose(found.neutral, centimetres.neutral, atol=1e-4)
    assert bool(notes) == (unit != "cm")


def test_a_unit_that_makes_a_giant_of_a_head_is_refused():
    with pytest.raises(FaceZipError, match=r"cm large; say another unit") as refused:
        standing(head(), unit="m")
    assert refused.value.code is ErrorCode.BAD_CHARACTER


@pytest.mark.parametrize(("key", "value"), [("up", "w"), ("front", 1), ("unit", "mile"), ("up", "z")])
def test_what_it_may_not_say_is_named(key, value):
    with pytest.raises(ValueError, match=key):
        Placement.of({key: value})


@pytest.mark.parametrize("seed", range(5))
def test_what_is_no_head_is_left_as_it_is(seed):
    meshes = random_character(seed, grid=24).meshes
    assert standing(meshes) == (meshes, ())


def test_the_generic_face_is_the_embedded_characters():
    kept, new = generic_face(), made.generic_face()
    for name in ("points", "normals", "active"):
        np.testing.assert_allclose(getattr(kept, name), getattr(new, name), atol=1e-5)


@given(turns, tilts(20))
def test_a_tilt_has_the_axes_that_it_was_tilted_from(turn, tilt):
    np.testing.assert_array_equal(nearest_axes(turn @ tilt), turn)
