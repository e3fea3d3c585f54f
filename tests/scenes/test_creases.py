"""Folds: valleys between ridges, in places that never move, as deep as the strain across them says."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scenes.character import Person
from scenes.face.skin.creases import Creases, depths, profile
from scenes.face.skin.lines import lines_of
from scenes.face.skin.sampling import TexelGrid
from scenes.face.traits import traits

WIDTH, REST = 0.09, 0.2
presses = st.floats(0.0, 0.5)
# Kernels compile at their first call.
KERNEL = settings(deadline=None)


def point(turn=0.0):
    """A point at the origin of a line across which ``turn`` (radians) leads from the frame's first axis."""
    u, v = np.cos(turn), np.sin(turn)
    return np.array([0, 0, 0, u, v, 0, u * u, 2 * u * v, v * v, WIDTH, 0.9, 0.5, REST], np.float32)


def pressed(amount, turn=0.0):
    """Fields of a strain that shortens the skin by ``amount`` along a direction, and leaves it as it is across."""
    u, v = np.cos(turn), np.sin(turn)
    excess = (1 - amount) ** 2 - 1
    return np.array([excess * u * u, excess * u * v, excess * v * v, -amount])


@KERNEL
@given(st.floats(-3, 3))
def test_without_strain_a_line_is_as_deep_as_at_rest(turn):
    rest, deep = depths(point(turn), np.zeros(4))
    assert rest == deep == np.float32(REST)


@KERNEL
@given(presses, presses, st.floats(-3, 3))
def test_the_more_the_skin_is_pressed_together_the_deeper_a_line(one, other, turn):
    shallow, deep = (depths(point(turn), pressed(amount, turn))[1] for amount in sorted((one, other)))
    assert REST - 1e-5 <= shallow <= deep + 1e-5 <= 1 + 1e-5


@KERNEL
@given(presses, st.floats(-3, 3))
def test_pressure_along_a_line_does_not_fold_it(amount, turn):
    assert depths(point(turn), pressed(amount, turn + np.pi / 2))[1] == pytest.approx(REST, abs=1e-3)


@KERNEL
@given(st.floats(0.01, 0.5))
def test_stretch_smooths_a_line(amount):
    assert 0 < depths(point(), pressed(-amount))[1] < REST


@KERNEL
@given(st.floats(0.05, 1.0), st.floats(0.0, 0.4), st.floats(0.001, 0.2))
def test_a_fold_is_alike_on_both_sides(depth, away, texel):
    left, right = (profile(point(), np.array([x, 0, 0]), depth, texel) for x in (-away, away))
    np.testing.assert_allclose(left, right, atol=1e-6)


@KERNEL
@given(st.floats(0.05, 1.0))
def test_a_fold_is_a_valley_between_ridges(depth):
    places = np.linspace(0, 0.6, 200)
    valley, ridge, _ = np.array([profile(point(), np.array([x, 0, 0]), depth, 0.001) for x in places]).T
    assert valley[0] == pytest.approx(1)
    assert (np.diff(valley) <= 0).all()
    assert 0 < ridge.argmax() < 150
    assert ridge[0] < 0.05
    assert max(valley[-1], ridge[-1]) < 1e-2


def test_a_line_narrower_than_texels_is_fainter_not_wider_than_it_can_be_seen():
    coarse, fine = (profile(point(), np.zeros(3), 0.5, texel)[0] for texel in (0.3, 0.01))
    assert coarse < 0.5 * fine


def test_a_line_is_wider_the_deeper_it_is():
    assert profile(point(), np.zeros(3), 1.0, 0.01)[2] > profile(point(), np.zeros(3), 0.3, 0.01)[2]


def test_lines_of_both_sides_are_the_same_ones_and_not_alike():
    lines = lines_of(traits(4))
    left, right = ([line for line in lines if (side * line.points[:, 0] > 0.3).all()] for side in (1, -1))
    assert abs(len(left) - len(right)) <= 6
    assert not any(
        len(a.points) == len(b.points) and np.allclose(a.points, b.points * [-1, 1]) for a in left for b in right
    )


def test_age_leaves_lines():
    young, old = (sum(line.permanent for line in lines_of(traits(0)._replace(age=age))) for age in (22.0, 65.0))
    assert old > 4 * young


def test_creases_are_the_same_to_the_byte_and_lie_on_the_skin():
    person = Person.make(128)
    again = Creases.of(person.head, TexelGrid.of(person.head, 128), traits(0))
    np.testing.assert_array_equal(again.nearest, person.creases.nearest)
    np.testing.assert_array_equal(again.points, person.creases.points)
    assert np.isfinite(again.points).all()
    assert -1 == again.nearest.min() < again.nearest.max() < len(again.points)
    assert 0.01 < (again.nearest >= 0).mean() < 0.5
    np.testing.assert_allclose(np.linalg.norm(again.points[:, 3:6], axis=1), 1, atol=1e-5)


def test_folds_of_a_weak_expression_lie_where_those_of_a_strong_one_do():
    person = Person.make(256)
    weak, strong = (person.relief({"browInnerUp": weight}).cavity for weight in (0.5, 1.0))
    still = person.relief({}).cavity
    assert np.corrcoef((weak - still).ravel(), (strong - still).ravel())[0, 1] > 0.9
