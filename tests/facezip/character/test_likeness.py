"""Expressions in another unit, as offsets, turned or elsewhere come to the neutral; a head's own motion stays."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from facezip.character.likeness import brought_to_neutral
from facezip.errors import ErrorCode, FaceZipError
from tests.facezip.character.heads import head, moved, with_expression

NAMES = tuple(f"expression_{n:02}" for n in range(6))
ns = st.integers(0, 5)
people = st.tuples(st.integers(0, 1), st.booleans())
directions = st.sampled_from([(1, 0, 0), (0, -1, 0), (0, 0, 1), (1, 1, -1)])


def brought(meshes):
    return brought_to_neutral(meshes, NAMES, Path("scans"))


def restored(meshes, n, changed):
    """Bring a changed expression back: it alone has a note, and it is where it was, to this share of the head."""
    found, notes = brought(with_expression(meshes, n, changed))
    assert [note.file for note in notes] == [NAMES[n]]
    return np.abs(found.vertices - meshes.vertices).max() / np.ptp(meshes.neutral)


# All ways to name the axes of a right-handed system, but for the one that changes nothing.
TURNS = [turn for turn in Rotation.create_group("O").as_matrix().round() if not np.array_equal(turn, np.eye(3))]


@settings(max_examples=15, deadline=None)
@given(people, ns, st.sampled_from([0.01, 0.1, 10, 100, 1000, 2.54, 25.4, 1 / 2.54, 30.48]))
def test_another_unit_is_divided_out(person, n, factor):
    meshes = head(*person)
    assert restored(meshes, n, meshes.vertices[n] * factor) < 1e-5


@settings(max_examples=10, deadline=None)
@given(people, ns)
def test_offsets_are_added_to_the_neutral(person, n):
    meshes = head(*person)
    assert restored(meshes, n, meshes.deltas[n]) < 1e-5


@settings(max_examples=10, deadline=None)
@given(people, ns, directions, st.floats(1, 50))
def test_what_is_elsewhere_is_moved_onto_the_neutral(person, n, direction, sizes):
    meshes = head(*person)
    away = sizes * np.ptp(meshes.neutral) * np.array(direction)
    assert restored(meshes, n, meshes.vertices[n] + away) < 0.02


@settings(max_examples=10, deadline=None)
@given(people, ns, st.sampled_from(TURNS), st.booleans())
def test_other_axes_are_turned_back(person, n, turn, mirrored):
    meshes = head(*person)
    turn = turn @ np.diag([-1, 1, 1]) if mirrored else turn
    assert restored(meshes, n, meshes.vertices[n] @ turn.T) < 1e-5


@settings(max_examples=15, deadline=None)
@given(people, ns, directions, st.floats(-0.25, 0.25), st.floats(-40, 40), st.floats(0.9, 1.1))
def test_a_head_that_moves_stays_where_it_is(person, n, direction, sizes, degrees, size):
    meshes = head(*person)
    turn = Rotation.from_rotvec(np.radians(degrees) * np.array(direction) / np.linalg.norm(direction)).as_matrix()
    middle = meshes.neutral.mean(axis=0)
    shift = sizes * np.ptp(meshes.neutral, axis=0).max() * np.array(direction) / np.linalg.norm(direction)
    posed = size * (meshes.vertices[n] - middle) @ turn.T + middle + shift
    meshes = with_expression(meshes, n, posed)
    found, notes = brought(meshes)
    assert not notes
    assert found is meshes


@settings(max_examples=10, deadline=None)
@given(people, ns, st.sampled_from([1.7, 0.55, 5.3]))
def test_a_size_that_is_no_ratio_of_units_is_refused(person, n, factor):
    meshes = head(*person)
    with pytest.raises(FaceZipError, match=rf"'{NAMES[n]}'.* times as large as the neutral") as refused:
        brought(with_expression(meshes, n, meshes.vertices[n] * factor))
    assert refused.value.code is ErrorCode.BAD_CHARACTER


@settings(max_examples=5, deadline=None)
@given(people, ns, st.integers(0, 99))
def test_another_order_of_vertices_is_no_expression(person, n, seed):
    meshes = head(*person)
    scrambled = np.random.default_rng(seed).permutation(meshes.vertices[n])
    with pytest.raises(FaceZipError, match=rf"'{NAMES[n]}' is no form of the neutral's"):
        brought(with_expression(meshes, n, scrambled))


@pytest.mark.parametrize("sizes", [150, 400])
def test_a_head_that_is_far_away_comes_to_the_origin(sizes):
    away = sizes * float(np.ptp(head().neutral, axis=0).max()) * np.array([1, 0, 1])
    found, notes = brought(moved(head(), np.eye(3), away))
    assert len(notes) == 1
    assert np.abs(found.neutral).max() < 20
    np.testing.assert_allclose(found.deltas, head().deltas, atol=2e-5 * sizes)
