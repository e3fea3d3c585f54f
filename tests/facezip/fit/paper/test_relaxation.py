"""The semidefinite relaxation: below every stitching, near to the best, and indifferent to names."""

from itertools import product

import numpy as np
import pytest

from facezip.fit.paper.beam import beam_search
from facezip.fit.paper.relaxation import relax
from facezip.fit.paper.stitching import stitching_cost
from tests.facezip.fit.paper.test_beam import SMALL, optimum, surface_table, tree_table
from tests.facezip.fit.paper.test_stitching import agreeing_table, random_table


@pytest.mark.parametrize("steps", [1, 20])
def test_every_cost_is_the_bound_and_two_terms_that_are_not_negative(steps):
    table, rng = random_table(6, 3), np.random.default_rng(1)
    relaxation = relax(table, steps)
    assert relaxation.entries.min() >= 0
    assert np.linalg.eigvalsh(relaxation.slack)[0] > 0
    for _ in range(5):
        permutation = np.stack([rng.permutation(3) for _ in range(6)])
        # Row k·R + a, column i: whether texture i takes cluster a of mask k.
        placed = (permutation[:, None, :] == np.arange(3)[:, None]).reshape(18, 3)
        products = placed.astype(float) @ placed.T
        entries = (relaxation.entries.transpose(0, 2, 1, 3).reshape(18, 18) * products).sum()
        slack = (relaxation.slack * (products - 1 / 3)).sum()
        assert relaxation.bound + entries + slack == pytest.approx(stitching_cost(table, permutation))
        assert slack >= 0


@pytest.mark.parametrize("size", SMALL, ids=str)
@pytest.mark.parametrize("steps", [1, 3, 30, 300])
def test_no_permutation_is_below_it_however_few_the_steps(size, steps):
    for seed in range(5):
        table = random_table(*size, seed)
        assert relax(table, steps).bound <= optimum(table) * (1 + 1e-9)


def test_it_is_the_optimum_where_masks_overlap_in_a_tree():
    table = tree_table(12, 4)
    assert relax(table, 1000).bound == pytest.approx(beam_search(table).cost, rel=2e-3)


@pytest.mark.parametrize("seed", range(3))
def test_on_a_surface_it_is_tighter_than_the_bound_of_the_beam(seed):
    table = surface_table(30, seed)
    found, bound = beam_search(table), relax(table).bound
    assert found.lower_bound < bound <= found.cost
    assert bound > 0.95 * found.cost


def test_where_all_masks_agree_it_is_their_cost():
    rng = np.random.default_rng(0)
    hidden = np.stack([rng.permutation(4) for _ in range(15)])
    table = agreeing_table(hidden) + 0.1 * random_table(15, 4)
    assert relax(table).bound == pytest.approx(stitching_cost(table, hidden), rel=0.01)


def test_it_does_not_depend_on_names():
    table, rng = random_table(6, 3), np.random.default_rng(0)
    names, masks = np.stack([rng.permutation(3) for _ in range(6)]), rng.permutation(6)
    renamed = np.empty_like(table)
    for k, other in product(range(6), repeat=2):
        renamed[k, other] = table[masks[k], masks[other]][np.ix_(names[k], names[other])]
    assert relax(renamed, 50).bound == pytest.approx(relax(table, 50).bound)


def test_it_scales_with_the_costs():
    table = random_table(6, 3)
    assert relax(1e-6 * table, 50).bound == pytest.approx(1e-6 * relax(table, 50).bound)


@pytest.mark.parametrize(
    ("table", "expected"),
    [(np.zeros((1, 1, 4, 4)), 0), (np.zeros((6, 6, 4, 4)), 0), (random_table(6, 1), random_table(6, 1).sum())],
    ids=["one mask", "no overlap", "one cluster"],
)
def test_where_nothing_can_be_chosen_it_is_the_cost(table, expected):
    assert relax(table, 20).bound == pytest.approx(expected, abs=1e-7)


def test_it_is_the_same_every_time():
    table = random_table(10, 4)
    assert relax(table, 20).bound == relax(table, 20).bound
