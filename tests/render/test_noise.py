import numpy as np
import pytest

from facezip.files.srgb import encode_srgb
from render.noise import Halves, debiased_rmse, noise_floor
from render.paired import Images

HEAD = np.ones((64, 64), bool)


def noisy(sigma, error, seed):
    """Original and one candidate: independent noise of a given strength on each half, and a known error."""
    rng = np.random.default_rng(seed)
    base = np.full((64, 64, 3), 0.5)
    halves = [np.stack([base, base + error]) + rng.normal(0, sigma, (2, 64, 64, 3)) for _ in range(2)]
    return Halves(*(Images(half.astype(np.float32), HEAD.astype(np.float32)) for half in halves))


@pytest.fixture
def linear_display(monkeypatch):
    monkeypatch.setattr("render.noise.display", lambda image: image)


def test_the_floor_is_the_difference_of_two_full_renders(linear_display):
    sigma = 0.02
    assert noise_floor(noisy(sigma, 0, 0), HEAD) == pytest.approx(255 * sigma, rel=0.02)


def test_noise_does_not_bias_the_debiased_error(linear_display):
    sigma, error = 0.02, 0.01
    estimates = [debiased_rmse(noisy(sigma, error, seed), 1, HEAD) for seed in range(12)]
    assert np.mean(estimates) == pytest.approx(255 * error, rel=0.03)


def test_without_a_difference_the_debiased_error_is_zero():
    halves = noisy(0.02, 0, 0)
    same = Halves(*(Images(half.linear[[0, 0]], half.coverage) for half in (halves.first, halves.second)))
    assert debiased_rmse(same, 1, HEAD) == 0


def test_in_linear_values_the_debiased_error_is_the_product_of_the_halves_differences(linear_display):
    halves = noisy(0.02, 0.03, 0)
    first, second = (half.linear[0].astype(float) - half.linear[1] for half in (halves.first, halves.second))
    assert debiased_rmse(halves, 1, HEAD) == pytest.approx(255 * np.sqrt(np.mean(first * second)), rel=1e-4)


def test_the_displays_curve_does_not_bias_the_debiased_error():
    """Light that flickers by a third, as with few samples, on a dark skin whose albedo is off by a tenth."""
    rng = np.random.default_rng(0)
    lights = rng.lognormal(-0.05, 0.3, (2, 64, 64, 3)).astype(np.float32)
    halves = Halves(*(Images(np.stack([0.1 * light, 0.11 * light]), HEAD.astype(np.float32)) for light in lights))
    mean = float(np.exp(-0.05 + 0.3**2 / 2))
    true = 255 * float(np.diff(encode_srgb(np.float32([0.1 * mean, 0.11 * mean])))[0])
    assert debiased_rmse(halves, 1, HEAD) == pytest.approx(true, rel=0.005)
