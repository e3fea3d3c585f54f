"""The certificate: never above what is known, never a false bound, and a proof where tables are like those of faces."""

import numpy as np
import pytest

from facezip.fit.paper.beam import beam_search
from facezip.fit.paper.certificate import certify
from facezip.fit.paper.stitching import stitching_cost, unpermuted
from tests.facezip.fit.paper.test_beam import SMALL, optimum, surface_table
from tests.facezip.fit.paper.test_stitching import agreeing_table, random_table


@pytest.mark.parametrize("size", SMALL, ids=str)
@pytest.mark.parametrize("seed", range(3))
def test_it_finds_and_proves_the_optimum_from_any_permutation(size, seed):
    table = random_table(*size, seed)
    certified = certify(table, unpermuted(table))
    assert certified.cost == pytest.approx(optimum(table))
    assert certified.gap == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("size", SMALL, ids=str)
@pytest.mark.parametrize("width", [1, 3])
def test_no_permutation_is_below_the_bound_of_a_narrow_one(size, width):
    for seed in range(3):
        table = random_table(*size, seed)
        certified = certify(table, unpermuted(table), width)
        assert certified.lower_bound <= optimum(table) * (1 + 1e-9)
        assert certified.lower_bound <= certified.cost <= unpermuted(table).cost


@pytest.mark.parametrize("seed", range(3))
def test_on_a_surface_the_optimum_is_proved(seed):
    table = surface_table(30, seed)
    known = beam_search(table, 20)
    certified = certify(table, known)
    assert known.gap > 0
    assert certified.gap == pytest.approx(0, abs=1e-9)
    assert certified.cost <= known.cost
    assert certified.cost == stitching_cost(table, certified.permutation)


def test_where_it_finds_nothing_better_the_known_one_stays():
    table = surface_table(20)
    known = beam_search(table)
    certified = certify(table, known)
    assert certified.cost == known.cost
    np.testing.assert_array_equal(certified.permutation, known.permutation)


def test_the_gap_never_widens():
    table = random_table(20, 4)
    known = beam_search(table)
    certified = certify(table, known, 1)
    assert certified.lower_bound >= known.lower_bound
    assert certified.gap <= known.gap


def test_it_finds_the_same_every_time():
    table = surface_table(15)
    first, again = (certify(table, unpermuted(table)) for _ in range(2))
    np.testing.assert_array_equal(first.permutation, again.permutation)
    assert first.lower_bound == again.lower_bound


@pytest.mark.parametrize(
    "table",
    [
        np.zeros((1, 1, 4, 4)),
        np.zeros((6, 6, 4, 4)),
        random_table(6, 1),
        random_table(6, 1).repeat(3, 2).repeat(3, 3),
        agreeing_table(np.tile(np.arange(4), (6, 1))),
    ],
    ids=["one mask", "no overlap", "one cluster", "equal costs", "agreement"],
)
def test_where_nothing_is_to_be_gained_that_is_proved(table):
    certified = certify(table, unpermuted(table))
    assert certified.cost == pytest.approx(unpermuted(table).cost)
    assert certified.gap == pytest.approx(0, abs=1e-9)
