"""Beam search: the optimum where it can be counted out, a true bound, the same result every time."""

from itertools import permutations, product

import numpy as np
import pytest

from facezip.fit.paper.beam import beam_search
from facezip.fit.paper.stitching import Stitching, search, stitching_cost, unpermuted
from tests.facezip.fit.paper.test_stitching import agreeing_table, random_table


def optimum(table):
    """The least cost of all choices; the first mask keeps its order, because renaming the textures costs nothing."""
    count, _, slots, _ = table.shape
    orders = np.array(list(permutations(range(slots))))
    choices = product(range(1), *(range(len(orders)) for _ in range(count - 1)))
    return min(stitching_cost(table, orders[list(choice)]) for choice in choices)


def tree_table(count, slots, seed=0):
    """Every mask overlaps one earlier mask and its later ones."""
    rng = np.random.default_rng(seed)
    parents = [int(rng.integers(0, k)) for k in range(1, count)]
    overlap = np.zeros((count, count, 1, 1))
    overlap[range(1, count), parents] = 1
    return random_table(count, slots, seed) * (overlap + overlap.transpose(1, 0, 2, 3))


def surface_table(count, seed=0):
    """Masks about points of a sheet, their clusters' means numbered at random: what tables of characters are like."""
    rng = np.random.default_rng(seed)
    places = rng.random((count, 2))
    means = np.sin(places @ rng.normal(0, 6, (4, 2, 8)) + rng.random((4, 1, 8)) * 6).transpose(1, 0, 2)
    means = np.stack([rng.permutation(mean) for mean in means + rng.normal(0, 0.5, means.shape)])
    overlap = np.exp(-30 * ((places[:, None] - places) ** 2).sum(axis=2)) - np.eye(count)
    gaps = means[:, None, :, None] - means[None, :, None]
    return overlap[:, :, None, None] * (gaps**2).sum(axis=-1)


def chain_table(count, slots):
    near = np.abs(np.subtract.outer(np.arange(count), np.arange(count))) == 1
    return random_table(count, slots) * near[:, :, None, None]


SMALL = [(1, 4), (2, 4), (5, 2), (4, 3), (4, 4), (3, 1)]


@pytest.mark.parametrize("size", SMALL, ids=str)
@pytest.mark.parametrize("seed", range(3))
def test_a_wide_beam_finds_and_proves_the_optimum(size, seed):
    table = random_table(*size, seed)
    found = beam_search(table, 24**3)
    assert found.cost == pytest.approx(optimum(table))
    assert found.gap == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("size", SMALL, ids=str)
@pytest.mark.parametrize("width", [1, 2, 7])
def test_no_permutation_is_below_the_bound(size, width):
    for seed in range(5):
        table = random_table(*size, seed)
        found = beam_search(table, width)
        assert found.lower_bound <= optimum(table) * (1 + 1e-12)
        assert found.lower_bound <= found.cost
        assert 0 <= found.gap <= 1


@pytest.mark.parametrize(
    "table", [chain_table(30, 4), tree_table(30, 4), tree_table(40, 3, 1)], ids=["chain", "a", "b"]
)
def test_masks_that_overlap_in_a_tree_need_no_beam(table):
    assert beam_search(table, 1).gap == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("count", [10, 40])
def test_on_a_surface_it_is_never_worse_than_many_starts_of_the_papers_search(count, seed):
    table = surface_table(count, seed)
    assert beam_search(table).cost <= search(table, 300, seed).cost * (1 + 1e-12)


def test_a_hidden_permutation_is_recovered_and_proved():
    rng = np.random.default_rng(2)
    found = beam_search(agreeing_table(np.stack([rng.permutation(4) for _ in range(15)])))
    assert found.cost == found.lower_bound == found.gap == 0


def test_the_cost_is_that_of_the_permutation_to_the_last_bit():
    table = random_table(20, 4)
    found = beam_search(table, 10)
    np.testing.assert_array_equal(np.sort(found.permutation, axis=1), np.tile(np.arange(4), (20, 1)))
    assert found.cost == stitching_cost(table, found.permutation) == found.history[0, -1]


def test_the_papers_sweeps_gain_nothing_after_it():
    table = random_table(20, 4)
    history = beam_search(table, 1).history
    assert history.shape == (1, 11)
    assert (np.diff(history) <= 1e-9).all()
    assert history[0, -1] == pytest.approx(history[0, -2])


def test_it_finds_the_same_every_time():
    table = random_table(20, 4)
    first, again = beam_search(table, 20), beam_search(table, 20)
    np.testing.assert_array_equal(first.permutation, again.permutation)
    assert (first.cost, first.lower_bound) == (again.cost, again.lower_bound)


def test_names_of_clusters_and_masks_do_not_matter():
    table, rng = random_table(5, 3, seed=6), np.random.default_rng(0)
    names = np.stack([rng.permutation(3) for _ in range(5)])
    masks = rng.permutation(5)
    renamed = np.empty_like(table)
    for k, other in product(range(5), repeat=2):
        renamed[k, other] = table[masks[k], masks[other]][np.ix_(names[k], names[other])]
    first, second = beam_search(table), beam_search(renamed)
    assert second.cost == pytest.approx(first.cost)
    assert second.lower_bound == pytest.approx(first.lower_bound)


def test_renaming_the_textures_does_not_change_the_cost():
    table = random_table(12, 4)
    found = beam_search(table)
    assert stitching_cost(table, found.permutation[:, [2, 0, 3, 1]]) == pytest.approx(found.cost)


@pytest.mark.parametrize(
    "table",
    [np.zeros((1, 1, 4, 4)), np.zeros((6, 6, 4, 4)), random_table(6, 1), random_table(6, 1).repeat(3, 2).repeat(3, 3)],
    ids=["one mask", "no overlap", "one cluster", "equal costs"],
)
def test_where_nothing_can_be_chosen_the_cost_is_proved(table):
    found = beam_search(table)
    assert found.cost == pytest.approx(unpermuted(table).cost)
    assert found.gap == pytest.approx(0, abs=1e-12)


def test_a_gap_is_the_share_that_no_search_can_gain():
    found = Stitching(np.zeros((1, 1), int), 8.0, np.zeros((1, 1)), 6.0)
    assert found.gap == 0.25
    assert search(random_table(), 1, 0).gap is None
