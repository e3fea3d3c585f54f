"""The relief of the embedded character, and what light makes of it."""

import numpy as np
import pytest

from scenes.character import Person
from scenes.face.skin.gloss import hollow, oil, roughness, specular

SIDE = 512
NUMBERS = ("roughness", "specular", "cavity")


@pytest.fixture(scope="module")
def person():
    return Person.make(SIDE)


@pytest.fixture(scope="module")
def still(person):
    return person.relief({})


@pytest.fixture(scope="module")
def raised(person):
    return person.relief({"browInnerUp": 1.0})


def test_every_value_is_in_its_range(still, raised):
    for found in (still, raised):
        for values in (getattr(found, name) for name in NUMBERS):
            assert values.shape == (SIDE, SIDE, 1)
            assert 0 <= values.min() < values.max() <= 1


@pytest.mark.parametrize("axis", [0, 1])
def test_slopes_of_neighbours_agree(still, raised, axis):
    """What texels cannot hold would be noise from one to the next, and glitter in a render."""
    for found in (still, raised):
        middle = found.slopes[SIDE // 8 : -SIDE // 8, SIDE // 4 : -SIDE // 4]
        here, there = np.delete(middle, -1, axis).ravel(), np.delete(middle, 0, axis).ravel()
        assert np.corrcoef(here, there)[0, 1] > 0.45


def test_a_fold_is_a_dark_valley_between_slopes(still, raised):
    deep = raised.cavity[..., 0] < 0.6 * still.cavity[..., 0]
    assert 100 < deep.sum() < 0.01 * deep.size
    tilt = np.abs(raised.slopes - still.slopes).sum(axis=2)
    assert tilt[deep].mean() > 10 * tilt[~deep].mean()


def test_an_expression_changes_nothing_where_it_does_not_move(still, raised):
    for name in ("slopes", "roughness", "cavity"):
        change = np.abs(getattr(raised, name) - getattr(still, name))
        assert change[: SIDE // 2].max() > 0.04
        assert change[SIDE * 5 // 8 :].max() < 1e-4
    np.testing.assert_array_equal(raised.specular, still.specular)


def test_oil_and_moisture_shine():
    """Points of the neutral (cm): a cheek; the tip of the nose, the middle of the forehead, the lower lip."""
    cheek, *shiny = (4.6, -4.4, 7.5), (0.0, -2.4, 11.0), (0.0, 4.6, 9.0), (0.0, -6.6, 9.5)
    for place in shiny:
        assert specular(*place, 0.05, 0) > specular(*cheek, 0.05, 0) + 0.04
        assert roughness(*place, 0.05, 0) < roughness(*cheek, 0.05, 0) - 0.04
    assert oil(*cheek) < 0.1 < 0.5 < oil(*shiny[0])


def test_light_stays_in_nostrils_and_between_the_lips():
    assert hollow(0.64, -3.7, 9.3) > 0.8
    assert hollow(0.0, -6.09, 9.5) > 0.5
    assert hollow(4.6, -4.4, 7.5) == 0
