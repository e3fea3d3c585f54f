import numpy as np
import pytest

from facezip import compress
from facezip.fit.paper.factorise import cluster_shares, difference_textures, weight_maps
from facezip.fit.paper.masks import compute_masks
from tests.facezip.conftest import ALBEDO_KEY, random_character

LABELS = np.array([[0, 1, 1, 3, 0], [2, 2, 2, 2, 2]], np.int32)
PERMUTATION = np.array([[3, 1, 0, 2], [0, 1, 2, 3]])


def test_shares_average_the_members_of_a_cluster():
    shares, alpha = cluster_shares(LABELS, PERMUTATION)
    np.testing.assert_array_equal(shares[0], [[0, 0, 0, 1, 0], [0, 0.5, 0.5, 0, 0], [0.5, 0, 0, 0, 0.5], [0] * 5])
    np.testing.assert_array_equal(alpha.sum(axis=1), 1)


def test_a_cluster_without_members_leaves_its_texture_empty():
    shares, _ = cluster_shares(LABELS, PERMUTATION)
    np.testing.assert_array_equal(shares[1].sum(axis=1), [0, 0, 1, 0])


def test_one_mask_and_a_cluster_each_give_the_differences_back():
    character = random_character(expressions=4)
    masks = compute_masks(character, 1, 0)[ALBEDO_KEY]
    shares, _ = cluster_shares(np.arange(4, dtype=np.int32)[None], np.arange(4)[None])
    expected = [character.texture(name) - character.texture("neutral") for name in character.expressions]
    np.testing.assert_allclose(difference_textures(character.first, masks, shares), expected, atol=1e-6)


@pytest.mark.parametrize("scale", [4, 8, 16])
def test_weights_of_an_expression_sum_to_one(character, scale):
    masks = compute_masks(character, 9, 0)[ALBEDO_KEY]
    labels = np.random.default_rng(0).integers(0, 4, (9, 5)).astype(np.int32)
    _, alpha = cluster_shares(labels, np.tile(np.arange(4), (9, 1)))
    weights = weight_maps(masks, alpha, scale)
    assert weights.shape == (5, 32 // scale, 32 // scale, 4)
    np.testing.assert_allclose(weights.sum(axis=3), 1, atol=1e-5)


def test_four_expressions_are_nearly_lossless():
    """Every cluster is one expression; what is left comes from sampling the weights at an eighth of the size."""
    character = random_character(expressions=4, side=64)
    model = compress(character, masks=6, restarts=20)
    name = character.expressions[2]
    error = np.abs(model.reconstruct(name) - character.texture(name)).mean()
    assert error < 0.25 * np.abs(character.texture("neutral") - character.texture(name)).mean()
