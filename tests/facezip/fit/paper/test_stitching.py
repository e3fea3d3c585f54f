from itertools import permutations, product

import numpy as np
import pytest

from facezip.fit.paper.stitching import SWEEPS, search, stitching_cost, unpermuted

ORDERS = np.array(list(permutations(range(3))))


def random_table(count=4, slots=3, seed=0):
    table = np.random.default_rng(seed).random((count, count, slots, slots))
    table[np.arange(count), np.arange(count)] = 0
    return table + table.transpose(1, 0, 3, 2)


def agreeing_table(hidden):
    """Clusters of two masks match where a hidden permutation puts them into the same texture."""
    count = len(hidden)
    place = np.argsort(hidden, axis=1)
    apart = (place[:, None, :, None] != place[None, :, None, :]).astype(float)
    apart[np.arange(count), np.arange(count)] = 0
    return apart


def every_choice(count):
    return (ORDERS[list(choice)] for choice in product(range(6), repeat=count))


def test_the_cost_sums_the_table_over_ordered_pairs():
    table = random_table(2)
    permutation = np.array([[0, 1, 2], [2, 0, 1]])
    expected = 2 * (table[0, 1, 0, 2] + table[0, 1, 1, 0] + table[0, 1, 2, 1])
    assert stitching_cost(table, permutation) == pytest.approx(expected)


@pytest.mark.parametrize("seed", range(4))
def test_enough_starts_find_the_optimum_of_a_small_problem(seed):
    table = random_table(seed=seed)
    optimum = min(stitching_cost(table, choice) for choice in every_choice(4))
    assert search(table, restarts=60, seed=0).cost == pytest.approx(optimum)


def test_a_hidden_permutation_is_recovered_exactly():
    rng = np.random.default_rng(2)
    hidden = np.stack([rng.permutation(4) for _ in range(15)])
    found = search(agreeing_table(hidden), restarts=20, seed=0)
    assert found.cost == 0
    textures_of_clusters = np.argsort(found.permutation, axis=1)[np.arange(15)[:, None], hidden]
    assert (textures_of_clusters == textures_of_clusters[0]).all()


def test_every_mask_takes_every_cluster_once():
    found = search(random_table(20, 4), restarts=3, seed=1)
    np.testing.assert_array_equal(np.sort(found.permutation, axis=1), np.tile(np.arange(4), (20, 1)))


def test_renaming_the_textures_does_not_change_the_cost():
    table, random = random_table(6), np.random.default_rng(0)
    permutation = np.stack([random.permutation(3) for _ in range(6)])
    renamed = permutation[:, [2, 0, 1]]
    assert stitching_cost(table, renamed) == pytest.approx(stitching_cost(table, permutation))


def test_the_cost_never_rises_from_sweep_to_sweep():
    history = search(random_table(20, 4), restarts=10, seed=0).history
    assert history.shape == (10, SWEEPS + 1)
    assert (np.diff(history, axis=1) <= 1e-9).all()


def test_the_reported_cost_is_that_of_the_permutation_and_the_lowest_in_the_history():
    table = random_table(20, 4)
    found = search(table, restarts=10, seed=0)
    assert found.cost == pytest.approx(stitching_cost(table, found.permutation))
    assert found.cost == found.history[:, -1].min()


def test_more_restarts_of_a_seed_are_never_worse():
    table = random_table(20, 4)
    costs = [search(table, restarts, seed=3).cost for restarts in (1, 5, 25)]
    assert costs == sorted(costs, reverse=True)


def test_the_same_seed_finds_the_same_permutation_even_among_equals():
    table = np.zeros((5, 5, 3, 3))
    first, again = (search(table, 4, seed=9) for _ in range(2))
    np.testing.assert_array_equal(first.permutation, again.permutation)


def test_without_permutation_clusters_keep_their_numbers():
    table = random_table(4)
    plain = unpermuted(table)
    np.testing.assert_array_equal(plain.permutation, np.tile(np.arange(3), (4, 1)))
    assert plain.cost == stitching_cost(table, plain.permutation)


def test_a_single_mask_costs_nothing():
    assert search(np.zeros((1, 1, 4, 4)), restarts=2, seed=0).cost == 0
