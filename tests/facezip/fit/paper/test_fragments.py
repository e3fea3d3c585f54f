from dataclasses import replace

import numpy as np
import pytest

from facezip.character.scans import Stack
from facezip.fit.paper.fragments import cluster_fragments, gram_rows, masked_gram
from facezip.fit.paper.masks import compute_masks
from tests.facezip.conftest import ALBEDO_KEY, random_character


def planted(groups, per_group, coordinates=9, seed=0):
    """The Gram matrix of points around well separated centres, and whose point each is."""
    rng = np.random.default_rng(seed)
    member = rng.permutation(np.repeat(np.arange(groups), per_group))
    points = 10 * rng.normal(size=(groups, coordinates))[member] + 0.1 * rng.normal(size=(len(member), coordinates))
    return points @ points.T, member


def same_partition(labels, others):
    return np.array_equal(labels[:, None] == labels, others[:, None] == others)


def test_rows_of_the_square_root_have_the_inner_products_of_the_gram_matrix():
    gram, _ = planted(3, 4)
    rows = gram_rows(gram)
    np.testing.assert_allclose(rows @ rows.T, gram, atol=1e-9)


@pytest.mark.parametrize("seed", range(5))
def test_separate_groups_are_found(seed):
    gram, member = planted(4, 5, seed=seed)
    assert same_partition(cluster_fragments(gram[None], 4, seed)[0], member)


def test_clusters_ignore_the_scale_and_rotation_of_texel_values():
    gram, _ = planted(6, 3)
    assert same_partition(*(cluster_fragments(np.stack([gram, 1e-8 * gram]), 4, 0)))


def test_clusters_follow_the_order_of_the_expressions():
    gram, _ = planted(4, 5)
    order = np.random.default_rng(1).permutation(20)
    labels = cluster_fragments(np.stack([gram, gram[order][:, order]]), 4, 0)
    assert same_partition(labels[0][order], labels[1])


def test_the_same_seed_gives_the_same_labels():
    gram, _ = planted(9, 2)
    first, again = (cluster_fragments(gram[None], 4, 7) for _ in range(2))
    np.testing.assert_array_equal(first, again)


def test_fragments_that_do_not_move_leave_clusters_empty():
    labels = cluster_fragments(np.zeros((1, 6, 6)), 4, 0)
    assert len(np.unique(labels)) == 1


def test_as_many_clusters_as_expressions_keep_all_apart():
    gram, _ = planted(3, 1)
    assert len(np.unique(cluster_fragments(gram[None], 3, 0))) == 3


def test_grams_are_zero_for_an_expression_that_is_the_neutral():
    character = random_character(expressions=3)
    textures = character.first.textures.copy()
    textures[1] = character.first.neutral
    grams = masked_gram(replace(character.first, textures=textures), compute_masks(character, 5, 0)[ALBEDO_KEY])
    assert (grams[:, 1] == 0).all()
    assert (grams[:, 0, 0] > 0).all()


def test_grams_scale_with_the_range_of_the_stored_type():
    """8-bit values times 257 are the same colours in 16 bits."""
    character = random_character()
    eight, masks = character.first, compute_masks(character, 5, 0)[ALBEDO_KEY]
    sixteen = Stack(eight.neutral.astype(np.uint16) * 257, eight.textures.astype(np.uint16) * 257)
    np.testing.assert_allclose(masked_gram(sixteen, masks), masked_gram(eight, masks), rtol=1e-4, atol=1e-7)


def test_rounding_decides_no_tie():
    """As two processors see the same fragments: the last bits of their Gram matrices differ."""
    gram, _ = planted(4, 1, coordinates=3)
    nudged = gram * (1 + 1e-15 * np.random.default_rng(0).normal(size=gram.shape))
    labels = cluster_fragments(gram[None], 4, 0)
    for matrix in (nudged, (nudged + nudged.T) / 2):
        np.testing.assert_array_equal(cluster_fragments(matrix[None], 4, 0), labels)
