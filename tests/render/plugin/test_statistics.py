"""The test keeps its promise when nothing differs, and finds what does; on noise that is not Gaussian."""

import numpy as np
import pytest
from scipy import ndimage, stats

from render.plugin.reference import Reference
from render.plugin.statistics import SCALES, STATISTICS, Spread, block_sums, noise_ratios
from tests.render.plugin.conftest import SIDE, noisy, renders, scene_mean


def alarms(make, references, tests, level):
    """How many of equal tests fall below the level; no render serves twice."""
    seeds = iter(range(10**6))
    below = 0
    for _ in range(references):
        reference = Reference.of(np.stack([make(next(seeds)) for _ in range(16)]))
        for _ in range(tests):
            below += reference.compare(np.stack([make(next(seeds)) for _ in range(4)])).probability < level
    return below


def filtered(seed):
    """Noise that a reconstruction filter has spread over neighbours: nothing is independent."""
    noise = np.random.default_rng(seed).normal(0, 0.05, (SIDE, SIDE, 3))
    return (scene_mean() + ndimage.gaussian_filter(noise, (1, 1, 0))).astype(np.float32)


@pytest.mark.parametrize("make", [noisy, filtered], ids=["fireflies and edges", "filtered"])
def test_false_alarms_are_no_more_often_than_promised(make):
    level, trials = 0.05, 200
    below = alarms(make, 20, trials // 20, level)
    # A test that kept its promise would exceed this once in a thousand.
    assert below <= stats.binom.ppf(0.999, trials, level)


@pytest.mark.parametrize(
    "spoil",
    [
        pytest.param(lambda image: image * np.float32(1.03), id="everything 3 % brighter"),
        pytest.param(lambda image: np.roll(image, 1, axis=1), id="shifted by a pixel"),
        pytest.param(lambda image: image[::-1].copy() * np.linspace(1, 1.05, SIDE)[:, None, None], id="gradient"),
    ],
)
def test_defects_are_found_every_time(reference, spoil):
    tests = (np.stack([spoil(noisy(seed)) for seed in range(100 + 8 * k, 108 + 8 * k)]) for k in range(10))
    assert max(reference.compare(test).probability for test in tests) < 1e-3


def test_a_faint_spot_where_nothing_is_drawn_is_found(reference):
    image = renders(range(100, 108))
    image[:, 0, 0, 2] += 0.001
    assert reference.compare(image).probability < 1e-6


def test_equal_images_without_noise_pass_and_rounding_is_no_difference():
    image = np.random.default_rng(0).random((SIDE, SIDE, 3), dtype=np.float32)
    reference = Reference.of(np.stack([image] * 8))
    assert reference.compare(image[None]).probability == 1
    assert reference.compare(image[None] * np.float32(1 + 1e-6)).probability == 1
    assert reference.compare(image[None] * np.float32(1.01)).probability < 1e-6


def test_more_renders_find_less():
    reference = Reference.of(renders(range(32), fireflies=False))
    few, many = (reference.compare(renders(range(100, 100 + count), gain=1.004, fireflies=False)) for count in (1, 32))
    assert many.probability < few.probability


def test_a_permutation_of_the_renders_changes_nothing(reference):
    test = renders(range(50, 58))
    assert reference.compare(test).probability == pytest.approx(reference.compare(test[::-1]).probability, rel=1e-6)


def test_exposure_changes_no_probability():
    """Twice the light is twice the noise: powers of two are exact in every float."""
    first, second = (
        Reference.of(gain * renders(range(16))).compare(gain * renders(range(50, 54)))
        for gain in (np.float32(1), np.float32(4))
    )
    assert second.probability == pytest.approx(first.probability, rel=1e-3)


@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize("shape", [(32, 32), (33, 21), (5, 3), (1, 1)])
def test_blocks_sum_what_they_cover(scale, shape):
    image = np.random.default_rng(0).random((*shape, 2))
    step = max(scale // 2, 1)
    sums = block_sums(image, scale)
    for row, column in np.ndindex(*sums.shape[:2]):
        y, x = row * step, column * step
        np.testing.assert_allclose(sums[row, column], image[y : y + scale, x : x + scale].sum(axis=(0, 1)))


def test_ratios_of_gaussian_noise_have_their_variance():
    rng = np.random.default_rng(0)
    shape = (160, 160, 3)
    for count in (1, 8):
        test = rng.normal(0, 0.1, (count, *shape))
        ratios = noise_ratios(test, np.zeros(shape), np.full(shape, 0.01), 1000)
        for scale in SCALES:
            assert np.var(ratios[scale].values) == pytest.approx(1, abs=0.15)


@pytest.mark.parametrize("name", STATISTICS)
def test_a_tail_falls_with_the_value_and_is_half_near_the_mean(name):
    spread = Spread(1.0, 0.1, 32)
    tails = [spread.tail(name, value) for value in (0.5, 1.0, 1.3, 2.0, 8.0)]
    assert tails == sorted(tails, reverse=True)
    assert 0.35 < tails[1] < 0.65
