from dataclasses import replace

import numpy as np
import pytest

from facezip.files.srgb import decode_srgb
from facezip.fit.methods import compress
from render.effect import image_errors
from render.importance import Sight, regularised, seen_importance, squared_error_weight
from render.metrics import display
from scenes.cameras import VIEWS

FRONT = ((VIEWS[0], "daylight"),)


@pytest.fixture(scope="module")
def sight():
    return Sight(FRONT, resolution=48, spp=16, material="diffuse")


@pytest.fixture(scope="module")
def seen(character, sight):
    return seen_importance(character, sight)


@pytest.fixture(scope="module")
def operator(character, sight):
    return next(sight.operators(character, sight.renderer(character), "smile"))


def squared_image_error(operator, encoded, other):
    head = operator.coverage >= 0.5
    shown = [display(operator.image(decode_srgb(texture)))[head].astype(np.float64) for texture in (encoded, other)]
    return np.square(shown[0] - shown[1]).mean()


def test_it_is_zero_exactly_where_no_camera_sees_a_texel(character, sight, seen):
    renderer = sight.renderer(character)
    looked_up = np.zeros(character.first.resolution)
    for name in character.expressions:
        for operator in sight.operators(character, renderer, name):
            head = np.repeat(operator.coverage[:, :, None] >= 0.5, 3, axis=2)
            looked_up += operator.transposed(head.astype(np.float32)).sum(axis=2)
    np.testing.assert_array_equal(seen > 0, looked_up > 0)
    assert 0.2 < (seen > 0).mean() < 0.8


def test_the_back_of_the_head_is_what_is_not_seen(seen):
    # The ball's u is 0.5 in front.
    assert (seen[16:48, 24:40] > 0).all()
    assert (seen[:, :4] == 0).all()


def test_equal_errors_in_all_texels_make_the_image_error_that_it_predicts(character, operator):
    encoded = character.texture("smile") * 0.8 + 0.1
    weight = squared_error_weight(operator, encoded)
    error = 1e-3
    actual = squared_image_error(operator, encoded, encoded + np.float32(error))
    assert error**2 * weight.sum() == pytest.approx(actual, rel=0.02)


@pytest.mark.parametrize("seed", range(3))
def test_it_bounds_the_image_error_of_any_small_error(character, operator, seed):
    encoded = character.texture("smile") * 0.8 + 0.1
    weight = squared_error_weight(operator, encoded)
    # The weight is the sum over channels: errors alike in all of them.
    error = 1e-3 * np.random.default_rng(seed).normal(size=(*weight.shape, 1)).astype(np.float32)
    actual = squared_image_error(operator, encoded, encoded + error)
    assert 0 < actual < 1.02 * (weight * error[:, :, 0] ** 2).sum()


def test_it_repeats(character, sight, seen):
    np.testing.assert_array_equal(seen_importance(character, sight), seen)


def test_it_adds_up_over_looks(character, sight, seen):
    side = ((VIEWS[4], "daylight"),)
    both = seen_importance(character, replace(sight, looks=FRONT + side))
    alone = seen_importance(character, replace(sight, looks=side))
    np.testing.assert_allclose(both, seen + alone, rtol=1e-5, atol=1e-12)


def test_the_floor_is_what_an_unseen_texel_counts(seen):
    mask = np.ones_like(seen)
    mask[:8] = 0
    weight = regularised(seen, mask, 0.25)
    assert np.average(weight, weights=mask) == pytest.approx(1, rel=1e-5)
    np.testing.assert_array_equal(weight[seen == 0], np.float32(0.25))


def test_a_floor_of_one_ignores_the_cameras(seen):
    np.testing.assert_array_equal(regularised(seen, None, 1), 1)


def test_a_fit_with_it_lowers_the_weighted_error(character, seen):
    importance = regularised(seen, None, 0.05)
    errors = []
    for weight in (None, importance):
        model = compress(character, differences=1, weight_scale=32, importance=weight)
        gaps = [model.reconstruct(name) - character.texture(name) for name in character.expressions]
        errors.append(sum(float((importance[:, :, None] * gap**2).sum()) for gap in gaps))
    assert errors[1] < errors[0]


def test_a_character_has_no_image_error_to_itself_and_more_to_worse_textures(character, sight):
    def off(by):
        return lambda name: np.clip(character.texture(name) + np.float32(by), 0, 1)

    none, small, large = image_errors(character, [character.texture, off(0.01), off(0.03)], sight)[:, :, 0]
    assert (none == 0).all()
    assert (small > 0.5).all()
    assert (large > 2 * small).all()
