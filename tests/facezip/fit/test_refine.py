import numpy as np
import pytest

from facezip.character.samples import samples_of
from facezip.fit.pca import principal_weights
from facezip.fit.refine import fit_weights
from facezip.fit.start import balanced_start
from facezip.fit.sweep import solve_textures
from facezip.pack.model import Part
from facezip.pack.quantise import quantise
from tests.facezip.conftest import (
    one_part,
    part_of,
    principal_components,
    random_character,
    refine,
    rmse,
    weights_of,
    with_albedo,
)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("differences", [1, 3])
@pytest.mark.parametrize("weight_scale", [4, 16])
def test_never_worse_than_pca_of_the_same_rank(differences, seed, weight_scale):
    character = random_character(seed=seed, expressions=7)
    pca = rmse(character, quantise(principal_components(character, differences)))
    assert rmse(character, quantise(refine(character, differences, weight_scale))) <= pca


def test_as_many_textures_as_expressions_lose_only_rounding():
    character = random_character(expressions=3)
    assert rmse(character, quantise(refine(character, 3, 8))) < 0.6


def test_more_textures_and_finer_weights_are_never_worse():
    character = random_character(side=64, expressions=9)
    by_rank = [rmse(character, refine(character, differences, 8)) for differences in (1, 2, 4, 8)]
    assert by_rank == sorted(by_rank, reverse=True)
    by_scale = [rmse(character, refine(character, 2, scale)) for scale in (4, 8, 16, 32)]
    assert by_scale == sorted(by_scale)


def test_what_a_pack_stores_is_exactly_what_was_fitted():
    model = refine(random_character(side=64, expressions=6), 3, 8)
    back = quantise(model).dequantised()
    np.testing.assert_allclose(part_of(back).differences, part_of(model).differences, atol=1e-6)
    np.testing.assert_allclose(weights_of(back), weights_of(model), atol=1e-6)


def test_storage_costs_little():
    character = random_character(side=64, expressions=9)
    samples = samples_of(character.first)
    weights = fit_weights([samples], 3, 8)
    neutral = part_of(refine(character, 3, 8)).neutral
    unrounded = one_part(
        Part(neutral, solve_textures(samples, weights)), np.ascontiguousarray(weights.transpose(2, 0, 3, 1))
    )
    assert rmse(character, quantise(refine(character, 3, 8))) < 1.02 * rmse(character, unrounded)


def test_texels_of_no_importance_do_not_change_the_weights(character):
    importance = np.ones(character.first.resolution, np.float32)
    importance[:, 16:] = 0
    other = character.first.textures.copy()
    other[:, :, 16:] = 77
    first, again = (
        refine(with_albedo(character, textures=t), 2, 8, importance) for t in (character.first.textures, other)
    )
    np.testing.assert_array_equal(weights_of(first), weights_of(again))


def test_what_the_mask_hides_is_fitted_too_and_costs_the_face_little():
    """Ears and necks are seen in renders, though errors are judged on the face."""
    character = random_character(side=64, expressions=9)
    face = np.zeros(character.first.resolution, np.float32)
    face[:, :32] = 1
    blind = refine(character, 3, 8, face)
    seeing = refine(with_albedo(character, mask=face), 3, 8)
    inside, outside = (with_albedo(character, mask=mask) for mask in (face, 1 - face))
    assert rmse(outside, seeing) < 0.8 * rmse(outside, blind)
    assert rmse(inside, seeing) < 1.05 * rmse(inside, blind)


def test_importance_moves_the_error_to_where_it_counts_less():
    character = random_character(side=64, expressions=9)
    importance = np.full(character.first.resolution, 0.02, np.float32)
    importance[:, :32] = 1
    left = with_albedo(character, mask=(importance == 1).astype(np.float32))
    # Within one weight texel of the border both sides share weights, so only there can one give way to the other.
    assert rmse(left, refine(character, 1, 32, importance)) < rmse(left, refine(character, 1, 32))


def test_same_bytes_whatever_the_number_of_threads(character, monkeypatch):
    models = []
    for threads in (1, 2, 7):
        monkeypatch.setattr("facezip.machine.cores._share", threads)
        models.append(refine(character, 2, 8))
    for model in models[1:]:
        np.testing.assert_array_equal(weights_of(model), weights_of(models[0]))
        np.testing.assert_array_equal(part_of(model).differences, part_of(models[0]).differences)


def test_the_start_is_pca_in_another_gauge(character):
    """Textures fitted to it explain exactly what PCA's textures do where the gauge is uniform."""
    samples = samples_of(character.first)
    start = balanced_start([samples], principal_weights([samples], 2), (1, 1))
    pca = weights_of(principal_components(character, 2))[:, 0, 0]
    mixture = np.linalg.lstsq(pca, start[0, :, :, 0].T, rcond=None)[0]
    np.testing.assert_allclose(pca @ mixture, start[0, :, :, 0].T, atol=1e-5)
    assert np.linalg.matrix_rank(mixture) == 2


def test_the_start_has_weights_and_textures_of_one_size(character):
    """In its gauge W Wᵀ and the mean of D Dᵀ over texels and channels are one matrix."""
    samples = samples_of(character.first)
    start = balanced_start([samples], principal_weights([samples], 3), (1, 1))
    textures = solve_textures(samples, start)
    weights = start[0, :, :, 0]
    np.testing.assert_allclose(
        np.einsum("ihwc,jhwc->ij", textures, textures) / textures[0].size, weights @ weights.T, rtol=0.02, atol=1e-4
    )
