from dataclasses import replace

import numpy as np
import pytest

from facezip.baselines import principal_components
from facezip.measure import mean_rmse, texture_errors
from facezip.model import blend_differences
from facezip.refine import WeightSystem, refine, rounded, solve_textures, solve_weights, weight_system
from tests.facezip.conftest import random_character


def upsampling(side, low):
    """Bilinear upsampling of a flat ``low`` x ``low`` map as a matrix, from the model's own sampler."""
    columns = []
    for texel in range(low * low):
        weights = np.zeros((low * low, 1), np.float32)
        weights[texel] = 1
        ones = np.ones((1, side, side, 1), np.float32)
        columns.append(blend_differences(np.zeros((side, side, 1), np.float32), ones, weights.reshape(low, low, 1)))
    return np.stack([column.ravel() for column in columns], axis=1).astype(float)


def pixels(character):
    return np.stack([character.texture(name) - character.texture("neutral") for name in character.expressions])


def random_weights(low, slots, count, seed=0):
    return np.random.default_rng(seed).normal(size=(low, low, slots, count)).astype(np.float32)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("differences", [1, 3])
def test_never_worse_than_pca_of_the_same_rank(differences, seed):
    character = random_character(seed=seed, expressions=7)
    pca = texture_errors(character, principal_components(character, differences).reconstruct)
    assert mean_rmse(texture_errors(character, refine(character, differences, 8).reconstruct)) <= mean_rmse(pca)


def test_as_many_textures_as_expressions_lose_nothing():
    character = random_character(expressions=3)
    assert mean_rmse(texture_errors(character, refine(character, 3, 8).reconstruct)) < 0.05


def test_textures_are_the_least_squares_solution_of_every_texel(character):
    weights = random_weights(4, 2, 5)
    textures = solve_textures(character, weights)
    sampled = (upsampling(32, 4) @ weights.reshape(16, 10)).reshape(32 * 32, 2, 5)
    texel = 345
    expected = np.linalg.lstsq(sampled[texel].T, pixels(character).reshape(5, -1, 3)[:, texel], rcond=None)[0]
    np.testing.assert_allclose(textures.reshape(2, -1, 3)[:, texel], expected, rtol=1e-3, atol=1e-5)


def test_weights_are_the_least_squares_solution_under_the_sampler(character):
    mask = np.random.default_rng(3).random(character.resolution).astype(np.float32)
    character = replace(character, mask=mask)
    start = random_weights(4, 2, 5)
    textures = solve_textures(character, start).reshape(2, -1, 3)
    up = upsampling(32, 4)
    design = np.einsum("p,ipc,pa->pcai", np.sqrt(mask.ravel()), textures, up).reshape(-1, 32)
    target = (np.sqrt(mask.ravel())[:, None] * pixels(character).reshape(5, -1, 3)).reshape(5, -1)
    expected = np.linalg.lstsq(design, target.T, rcond=None)[0].reshape(4, 4, 2, 5)
    weights = start
    for _ in range(20):
        weights = solve_weights(weight_system(character, start), 0.0, weights)
    np.testing.assert_allclose(weights, expected, rtol=1e-3, atol=1e-3)


def test_smoothness_spreads_weights_over_texels_that_nothing_sees():
    matrix, right = np.zeros((5, 5, 9, 1, 1)), np.zeros((5, 5, 1, 1))
    matrix[2, 2, 4], right[2, 2] = 1, 3
    weights = solve_weights(WeightSystem(matrix, right), 0.1, np.zeros((5, 5, 1, 1), np.float32))
    np.testing.assert_allclose(weights, 3, atol=1e-4)


def test_texels_that_the_mask_hides_do_not_change_the_weights(character):
    mask = np.ones(character.resolution, np.float32)
    mask[:, 16:] = 0
    other = character.textures.copy()
    other[:, :, 16:] = 77
    first, again = (refine(replace(character, textures=t, mask=mask), 2, 8) for t in (character.textures, other))
    np.testing.assert_array_equal(first.weights, again.weights)


def test_rounded_weights_stay_as_they_are_when_rounded_again():
    once = rounded(random_weights(6, 3, 4))
    np.testing.assert_allclose(rounded(once), once, atol=1e-6)
    assert all(len(np.unique(np.round(once[:, :, i], 5))) <= 256 for i in range(3))
