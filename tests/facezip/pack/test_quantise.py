import numpy as np
import pytest

from facezip.pack.quantise import STEPS, best_ranges, quantise_weights


def storage_error(values, limit):
    step = limit / STEPS
    return np.square(np.clip(np.rint(values / step), -STEPS, STEPS) * step - values).mean()


def test_a_few_outliers_do_not_widen_the_range_of_all():
    values = np.random.default_rng(0).normal(size=(1, 256, 256, 1)).astype(np.float32)
    values[0, 0, 0, 0] = 20
    chosen = best_ranges(values, np.ones((256, 256), np.float32))[0, 0]
    assert chosen < 17
    assert storage_error(values, chosen) < storage_error(values, 20)


def test_the_range_is_the_best_of_all():
    values = np.random.default_rng(1).laplace(size=(1, 200, 200, 2)).astype(np.float32)
    chosen = best_ranges(values, np.ones((200, 200), np.float32))[0]
    for c in range(2):
        candidates = np.linspace(0.2, 1, 81) * np.abs(values[..., c]).max()
        best = min(storage_error(values[..., c], limit) for limit in candidates)
        assert storage_error(values[..., c], chosen[c]) == pytest.approx(best, rel=0.03)


def test_texels_that_do_not_count_have_no_say():
    values = np.random.default_rng(2).normal(size=(2, 64, 64, 3)).astype(np.float32)
    values[:, :10] *= 50
    importance = np.ones((64, 64), np.float32)
    importance[:10] = 0
    assert best_ranges(values, importance).max() < 6


def test_rounded_weights_stay_as_they_are_when_rounded_again():
    once = quantise_weights(np.random.default_rng(0).normal(size=(4, 6, 6, 3)).astype(np.float32)).values
    np.testing.assert_allclose(quantise_weights(once).values, once, atol=1e-6)
    assert all(len(np.unique(np.round(once[..., i], 5))) <= 256 for i in range(3))
