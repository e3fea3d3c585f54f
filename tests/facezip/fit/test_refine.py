from dataclasses import replace

import numpy as np
import pytest

from facezip.character.samples import samples_of
from facezip.fit.pca import principal_weights
from facezip.fit.refine import balanced_start, fit_weights
from facezip.fit.sweep import solve_textures
from facezip.pack.measure import mean_rmse, model_errors
from facezip.pack.quantise import dequantise, quantise
from tests.facezip.conftest import principal_components, random_character, refine


def stored(model):
    return dequantise(quantise(model), model.expressions, model.method, None)


def error(character, model):
    return mean_rmse(model_errors(character, model))


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("differences", [1, 3])
@pytest.mark.parametrize("weight_scale", [4, 16])
def test_never_worse_than_pca_of_the_same_rank(differences, seed, weight_scale):
    character = random_character(seed=seed, expressions=7)
    pca = error(character, stored(principal_components(character, differences)))
    assert error(character, stored(refine(character, differences, weight_scale))) <= pca


def test_as_many_textures_as_expressions_lose_only_rounding():
    character = random_character(expressions=3)
    assert error(character, stored(refine(character, 3, 8))) < 0.6


def test_more_textures_and_finer_weights_are_never_worse():
    character = random_character(side=64, expressions=9)
    by_rank = [error(character, refine(character, differences, 8)) for differences in (1, 2, 4, 8)]
    assert by_rank == sorted(by_rank, reverse=True)
    by_scale = [error(character, refine(character, 2, scale)) for scale in (4, 8, 16, 32)]
    assert by_scale == sorted(by_scale)


def test_what_a_pack_stores_is_exactly_what_was_fitted():
    model = refine(random_character(side=64, expressions=6), 3, 8)
    back = stored(model)
    np.testing.assert_allclose(back.differences, model.differences, atol=1e-6)
    np.testing.assert_allclose(back.weights, model.weights, atol=1e-6)


def test_storage_costs_little():
    character = random_character(side=64, expressions=9)
    samples = samples_of(character)
    weights = fit_weights([samples], 3, 8)
    unrounded = replace(
        refine(character, 3, 8),
        differences=solve_textures(samples, weights),
        weights=np.ascontiguousarray(weights.transpose(2, 0, 3, 1)),
    )
    assert error(character, stored(refine(character, 3, 8))) < 1.02 * error(character, unrounded)


def test_texels_of_no_importance_do_not_change_the_weights(character):
    importance = np.ones(character.resolution, np.float32)
    importance[:, 16:] = 0
    other = character.textures.copy()
    other[:, :, 16:] = 77
    first, again = (refine(replace(character, textures=t), 2, 8, importance) for t in (character.textures, other))
    np.testing.assert_array_equal(first.weights, again.weights)


def test_what_the_mask_hides_is_fitted_too_and_costs_the_face_little():
    """Ears and necks are seen in renders, though errors are judged on the face."""
    character = random_character(side=64, expressions=9)
    face = np.zeros(character.resolution, np.float32)
    face[:, :32] = 1
    blind = refine(character, 3, 8, face)
    seeing = refine(replace(character, mask=face), 3, 8)
    inside, outside = (replace(character, mask=mask) for mask in (face, 1 - face))
    assert error(outside, seeing) < 0.8 * error(outside, blind)
    assert error(inside, seeing) < 1.05 * error(inside, blind)


def test_importance_moves_the_error_to_where_it_counts_less():
    character = random_character(side=64, expressions=9)
    importance = np.full(character.resolution, 0.02, np.float32)
    importance[:, :32] = 1
    left = replace(character, mask=(importance == 1).astype(np.float32))
    # Within one weight texel of the border both sides share weights, so only there can one give way to the other.
    assert error(left, refine(character, 1, 32, importance)) < error(left, refine(character, 1, 32))


def test_same_bytes_whatever_the_number_of_threads(character, monkeypatch):
    models = []
    for threads in (1, 2, 7):
        monkeypatch.setattr("facezip.machine.cores._share", threads)
        models.append(refine(character, 2, 8))
    for model in models[1:]:
        np.testing.assert_array_equal(model.weights, models[0].weights)
        np.testing.assert_array_equal(model.differences, models[0].differences)


def test_the_start_is_pca_in_another_gauge(character):
    """Textures fitted to it explain exactly what PCA's textures do where the gauge is uniform."""
    samples = samples_of(character)
    start = balanced_start([samples], principal_weights([samples], 2), (1, 1))
    pca = principal_components(character, 2).weights[:, 0, 0]
    mixture = np.linalg.lstsq(pca, start[0, :, :, 0].T, rcond=None)[0]
    np.testing.assert_allclose(pca @ mixture, start[0, :, :, 0].T, atol=1e-5)
    assert np.linalg.matrix_rank(mixture) == 2


def test_the_start_has_weights_and_textures_of_one_size(character):
    """In its gauge W Wᵀ and the mean of D Dᵀ over texels and channels are one matrix."""
    samples = samples_of(character)
    start = balanced_start([samples], principal_weights([samples], 3), (1, 1))
    textures = solve_textures(samples, start)
    weights = start[0, :, :, 0]
    np.testing.assert_allclose(
        np.einsum("ihwc,jhwc->ij", textures, textures) / textures[0].size, weights @ weights.T, rtol=0.02, atol=1e-4
    )
