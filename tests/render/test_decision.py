import numpy as np
import pytest
from scipy import stats

from render.decision import interval, judge, of_halves, stream, unbiased, without_bias
from render.limits import Limit, Thresholds
from render.metrics import Picture, compare

HEAD = np.ones((24, 24), bool)
GREY = np.full((24, 24, 3), 0.5, np.float32)


def test_intervals_hold_the_converged_value_as_often_as_they_say():
    """Metrics with a bias that falls with the number of samples, and normal noise."""
    rng = np.random.default_rng(0)
    halves = 1 + 2 * 0.05 + rng.normal(0, 0.02, (4000, 2))
    wholes = halves.mean(axis=1) - 0.05
    inside = [low <= 1 <= high for low, high in (interval(w, h) for w, h in zip(wholes, halves, strict=True))]
    assert np.mean(inside) == pytest.approx(0.95, abs=0.012)


def test_an_interval_of_two_halves_is_that_of_scipy():
    halves = (0.8, 0.9)
    expected = stats.t.interval(0.95, 1, loc=unbiased(0.84, halves), scale=stats.sem(halves))
    assert interval(0.84, halves) == pytest.approx(expected, rel=1e-4)


def test_without_noise_an_interval_is_a_point():
    assert interval(0.7, (0.7, 0.7)) == pytest.approx((0.7, 0.7))


def test_intervals_do_not_reach_below_zero():
    assert interval(0.1, (0.0, 0.2))[0] == 0


def judged(errors, limits=None):
    """A whole and two halves whose candidates are brighter by these amounts."""
    whole, *halves = (Picture(GREY + np.float32(error), HEAD) for error in errors)
    original = Picture(GREY, HEAD)
    return judge(compare(original, whole), [(original, half) for half in halves], limits or Thresholds())


def test_a_render_far_from_every_limit_is_decided():
    near = judged((0.002,) * 3)
    assert (near.level, near.decided) == ("indistinguishable", True)
    assert judged((0.3, 0.29, 0.31)).level == "fails"
    assert judged((0.3, 0.29, 0.31)).decided


def test_intervals_are_told_around_the_metrics():
    found = judged((0.01, 0.002, 0.018))
    assert found.interval.keys() == {"delta_e_p95", "delta_e_local", "flip"}
    assert all(low <= getattr(found, name) <= high and low < high for name, (low, high) in found.interval.items())


def test_noise_across_a_limit_is_not_decided():
    assert not judged((0.01, 0.002, 0.018)).decided


def test_an_identical_render_is_decided_as_such():
    assert judged((0, 0, 0)).level == "identical"
    assert judged((0, 0, 0)).decided


def test_streams_repeat_and_do_not_meet():
    seeds = [stream(seed, before, half, repeat) for seed in range(6) for before in (0, 16) for half in (0, 1)
             for repeat in (0, 1)]  # fmt: skip
    assert len({*seeds}) == len(seeds)
    assert stream(3, 16, 1) == stream(3, 16, 1)


def test_noise_does_not_bias_the_95th_percentile():
    rng = np.random.default_rng(0)
    pattern = rng.uniform(0, 0.03, (24, 24, 1)).astype(np.float32)
    original, truth = Picture(GREY, HEAD), compare(Picture(GREY, HEAD), Picture(GREY + pattern, HEAD)).delta_e_p95
    plain, free = [], []
    for _ in range(40):
        one, other = (GREY + pattern + rng.normal(0, 0.008, GREY.shape).astype(np.float32) for _ in range(2))
        found = compare(original, Picture((one + other) / 2, HEAD))
        halves = [(original, Picture(half, HEAD)) for half in (one, other)]
        plain.append(found.delta_e_p95)
        free.append(without_bias(found, of_halves(halves))["delta_e_p95"])
    assert np.mean(plain) > 1.02 * truth
    assert np.mean(free) == pytest.approx(truth, rel=0.3 * (np.mean(plain) / truth - 1))


def test_the_level_is_that_of_the_metrics_that_are_told():
    """With all samples barely beyond a limit, with half of them further beyond: without noise, within."""
    found = judged((0.01, 0.011, 0.011))
    beyond, told = judged((0.01,) * 3).delta_e_p95, found.delta_e_p95
    limit = (beyond + told) / 2
    level = judged((0.01, 0.011, 0.011), Thresholds(Limit(limit, 99, 1), Limit(99, 99, 1))).level
    assert told < limit < beyond
    assert level == "indistinguishable"


def test_only_equal_images_are_identical():
    found = judged((0.001, 0.005, 0.005))
    assert found.delta_e_p95 == found.flip == found.delta_e_local == 0
    assert found.level == "indistinguishable"
