"""The fast paper mode against the straightforward one on the same character."""

import numpy as np
import pytest

from facezip.fit.paper.factorise import cluster_shares, difference_textures, weight_maps
from facezip.fit.paper.fragments import gram_rows, lloyd, masked_gram, starts
from facezip.fit.paper.masks import compute_masks
from facezip.fit.paper.paircosts import pair_costs
from facezip.fit.paper.stitching import search
from facezip.fit.paper.stitching import stitching_cost as table_cost
from tests.facezip.conftest import ALBEDO_KEY, random_character
from tests.facezip.fit.paper import straightforward


@pytest.fixture(scope="module", params=[np.uint8, np.uint16, np.float32])
def both(request):
    character = random_character(seed=3, expressions=7, side=40, dtype=request.param)
    return (
        character,
        straightforward.paper(character, count=9, restarts=4, seed=5),
        compute_masks(character, 9, 5)[ALBEDO_KEY],
    )


def test_masks_are_those_of_one_dense_solve_each(both):
    _, plain, masks = both
    dense = np.stack([masks.dense(k) for k in range(masks.count)])
    np.testing.assert_allclose(dense, plain.masks, atol=1e-5)


def test_grams_are_the_inner_products_of_the_fragments(both):
    character, plain, masks = both
    for gram, mask in zip(masked_gram(character.first, masks), plain.masks, strict=True):
        pixels = straightforward.fragments(character, mask)
        np.testing.assert_allclose(gram, pixels @ pixels.T, rtol=1e-4, atol=1e-5)


def test_clusters_are_those_of_k_means_on_pixels_from_the_same_start(both):
    character, plain, masks = both
    for gram, mask in zip(masked_gram(character.first, masks), plain.masks, strict=True):
        pixels, rows = straightforward.fragments(character, mask), gram_rows(gram)
        for start in starts(rows, 4, seed=1):
            ours, theirs = lloyd(rows, start), straightforward.cluster_from(pixels, start)
            np.testing.assert_array_equal(ours.labels_, theirs.labels_)
            assert ours.inertia_ == pytest.approx(theirs.inertia_, rel=1e-3)


def test_the_cost_of_any_permutation_is_equation_3_on_pixels(both):
    character, plain, masks = both
    table = pair_costs(character.first, masks, plain.labels, 4)
    pairs = straightforward.pair_pixels(character, plain.masks, plain.labels, 4)
    random = np.random.default_rng(0)
    for _ in range(5):
        permutation = np.stack([random.permutation(4) for _ in range(masks.count)])
        expected = straightforward.stitching_cost(pairs, permutation)
        assert table_cost(table, permutation) == pytest.approx(expected, rel=1e-5)


def test_the_search_takes_the_steps_of_the_search_on_pixels(both):
    character, plain, masks = both
    found = search(pair_costs(character.first, masks, plain.labels, 4), restarts=4, seed=5)
    # The slots of all masks together may stand in any order: costs are equal then.
    order = [found.permutation[0].tolist().index(cluster) for cluster in plain.permutation[0]]
    np.testing.assert_array_equal(found.permutation[:, order], plain.permutation)
    assert found.cost == pytest.approx(plain.cost, rel=1e-5)


def test_textures_and_weights_are_equations_5_and_6(both):
    character, plain, masks = both
    shares, alpha = cluster_shares(plain.labels, plain.permutation)
    np.testing.assert_allclose(difference_textures(character.first, masks, shares), plain.differences, atol=1e-6)
    averaged = plain.weights.reshape(7, 5, 8, 5, 8, 4).mean(axis=(2, 4))
    np.testing.assert_allclose(weight_maps(masks, alpha, 8), averaged, atol=1e-5)
