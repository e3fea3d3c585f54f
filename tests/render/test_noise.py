import numpy as np
import pytest

from render.noise import Halves, debiased_rmse, noise_floor
from render.paired import Images

HEAD = np.ones((64, 64), bool)


def noisy(sigma, error, seed):
    """Original and one candidate: independent noise of a given strength on each half, and a known error."""
    rng = np.random.default_rng(seed)
    base = np.full((64, 64, 3), 0.5)
    halves = [np.stack([base, base + error]) + rng.normal(0, sigma, (2, 64, 64, 3)) for _ in range(2)]
    return Halves(*(Images(half.astype(np.float32), HEAD.astype(np.float32)) for half in halves))


@pytest.fixture(autouse=True)
def linear_display(monkeypatch):
    monkeypatch.setattr("render.noise.display", lambda image: image)


def test_the_floor_is_the_difference_of_two_full_renders():
    sigma = 0.02
    assert noise_floor(noisy(sigma, 0, 0), HEAD) == pytest.approx(255 * sigma, rel=0.02)


def test_noise_does_not_bias_the_debiased_error():
    sigma, error = 0.02, 0.01
    estimates = [debiased_rmse(noisy(sigma, error, seed), 1, HEAD) for seed in range(12)]
    assert np.mean(estimates) == pytest.approx(255 * error, rel=0.03)


def test_without_a_difference_the_debiased_error_is_zero():
    halves = noisy(0.02, 0, 0)
    same = Halves(*(Images(half.linear[[0, 0]], half.coverage) for half in (halves.first, halves.second)))
    assert debiased_rmse(same, 1, HEAD) == 0
