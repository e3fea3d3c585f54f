"""The test keeps its promise when nothing differs, and finds what does; on noise that is not Gaussian."""

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given, settings
from scipy import ndimage, stats

from render.plugin.reference import Reference
from render.plugin.statistics import SCALES, STATISTICS, Spread, block_sums, noise_ratios, rounding_of
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


def before_a_backdrop(seed):
    """Noise before one value, with noise of its own that is as small as the rounding to half floats."""
    rng = np.random.default_rng(seed)
    image = np.float32(0.3001) * (1 + rng.normal(0, 5e-4, (SIDE, SIDE, 3)))
    image[8:24, 8:24] = rng.normal(0.5, 0.05, (16, 16, 3))
    return image.astype(np.float32)


def in_8_bits(seed):
    """One value that lies near the middle between two codes: whole renders, and single pixels, fall on either."""
    rng = np.random.default_rng(seed)
    image = np.full((SIDE, SIDE, 3), 0.3 + (rng.random() < 0.02) / 255)
    return (image + (rng.random((SIDE, SIDE, 1)) < 1e-4) / 255).astype(np.float32)


@pytest.mark.parametrize("make", [noisy, filtered, before_a_backdrop, in_8_bits])
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


def backdrop(seeds, value, gain=1.0):
    """Renders of noise before one value, which is a part of what is drawn."""
    images = [np.full((SIDE, SIDE, 3), value, np.float32) for _ in seeds]
    for seed, image in zip(seeds, images, strict=True):
        image[8:24, 8:24] = np.random.default_rng(seed).normal(0.5 * gain, 0.05, (16, 16, 3))
    return np.stack(images)


@settings(deadline=None, max_examples=30)
@given(st.floats(0, 6e4, width=32))
def test_the_value_of_a_flat_region_is_no_alarm_and_hides_none(value):
    reference = Reference.of(backdrop(range(8), value))
    assert reference.compare(backdrop(range(100, 108), value)).probability > 0.01
    assert reference.compare(backdrop(range(100, 108), np.float32(1.01 * value + 1e-3))).probability < 1e-6
    assert reference.compare(backdrop(range(100, 108), value, gain=1.05)).probability < 1e-3


@given(st.floats(-6e4, 6e4))
def test_no_half_float_is_further_than_the_rounding_says(value):
    stored = np.float64(np.float16(value))
    assert abs(value - stored) <= rounding_of(stored) <= np.spacing(np.float16(max(abs(value), 2.0**-14)))


@settings(deadline=None, max_examples=30)
@given(st.floats(1e-4, 6e4), st.floats(-1, 1), st.sampled_from([1, 8]))
def test_a_difference_that_may_be_rounding_counts_nothing_in_no_block(value, part, count):
    mean = np.full((SIDE, SIDE, 3), np.float64(np.float16(value)))
    reach = rounding_of(mean)
    test = np.repeat((mean + part * reach)[None], count, axis=0)
    for ratios in noise_ratios(test, mean, np.zeros_like(mean), 32, reach).values():
        assert not ratios.values.any()


def test_what_one_render_alone_shows_is_an_event_and_what_all_show_a_difference():
    reference = Reference.of(backdrop(range(32), 0.3))
    test = backdrop(range(100, 108), 0.3)
    test[3, :, :8] += np.float32(1 / 255)
    assert reference.compare(test).probability > 0.01
    test[:, :, :8] = test[3, :, :8]
    assert reference.compare(test).probability < 1e-6


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
