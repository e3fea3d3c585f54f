from dataclasses import replace

import numpy as np
import pytest

from facezip.character.samples import samples_of
from facezip.fit.pca import combine_differences, difference_gram
from facezip.pack.errors import albedo_errors
from tests.facezip.conftest import part_of, principal_components, random_character, rmse, weights_of, with_albedo


def pixels(character):
    return np.stack([character.texture(name) - character.texture("neutral") for name in character.expressions])


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
@pytest.mark.parametrize("count", [1, 3, 5])
def test_components_are_the_truncated_singular_value_decomposition_of_the_pixels(count, dtype):
    character = random_character(dtype=dtype)
    model = principal_components(character, count)
    flat = pixels(character).reshape(5, -1).astype(float)
    u, s, vt = np.linalg.svd(flat, full_matrices=False)
    expected = (u[:, :count] * s[:count]) @ vt[:count]
    ours = weights_of(model)[:, 0, 0] @ part_of(model).differences.reshape(count, -1)
    np.testing.assert_allclose(ours, expected, atol=2e-5)


def test_all_components_reconstruct_the_textures():
    character = random_character()
    errors = albedo_errors(character, principal_components(character, 5))
    assert max(errors.values()) < 1e-3


def test_more_components_are_never_worse(character):
    errors = [rmse(character, principal_components(character, k)) for k in range(1, 6)]
    assert errors == sorted(errors, reverse=True)


def test_texels_that_the_mask_hides_do_not_count(character):
    mask = np.ones(character.first.resolution, np.float32)
    mask[:, 16:] = 0
    noisy = character.first.textures.copy()
    noisy[:, :, 16:] = np.random.default_rng(0).integers(0, 256, noisy[:, :, 16:].shape)
    clean, spoilt = (
        principal_components(with_albedo(character, textures=t, mask=mask), 3)
        for t in (character.first.textures, noisy)
    )
    np.testing.assert_array_equal(weights_of(clean), weights_of(spoilt))
    np.testing.assert_array_equal(part_of(clean).differences[:, :, :16], part_of(spoilt).differences[:, :, :16])


def test_the_gram_matrix_weighs_texels_by_the_mask(character):
    mask = np.random.default_rng(0).random(character.first.resolution).astype(np.float32)
    expected = np.einsum("hw,nhwc,mhwc->nm", mask, *(2 * [pixels(character)]), optimize=True)
    np.testing.assert_allclose(difference_gram(samples_of(replace(character.first, mask=mask))), expected, rtol=1e-4)


def test_combinations_are_linear(character):
    mixture = np.random.default_rng(0).normal(size=(3, 5)).astype(np.float32)
    expected = np.einsum("rn,nhwc->rhwc", mixture, pixels(character))
    np.testing.assert_allclose(combine_differences(character.first, mixture), expected, atol=1e-5)
