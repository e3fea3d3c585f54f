"""The test keeps its promise when nothing differs, and finds what does; on noise that is not Gaussian."""

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given, settings
from scipy import ndimage, stats

from render.plugin.reference import Reference
from render.plugin.statistics import (
    SCALES,
    STATISTICS,
    Ratios,
    Spread,
    block_sums,
    leave_one_out,
    noise_ratios,
    normalised,
    probability,
    ratio_probabilities,
    rounding_of,
    statistics,
    theoretical_tail,
)
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


@given(st.floats(-6e4, 6e4) | st.floats(-1e-4, 1e-4))
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
    sums, covered = block_sums(image, scale), np.zeros(shape, bool)
    for row, column in np.ndindex(*sums.shape[:2]):
        y, x = row * step, column * step
        covered[y : y + scale, x : x + scale] = True
        np.testing.assert_allclose(sums[row, column], image[y : y + scale, x : x + scale].sum(axis=(0, 1)))
    assert covered.all()


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


def of_one_noise(renders, tests, side, deviation=1.0):
    """Independent renders and tests of one noise on grey, the first as noise_ratios takes them."""
    rng = np.random.default_rng(0)
    seen, test = (rng.normal(0.3, deviation, (count, side, side, 2)) for count in (renders, tests))
    # One noise for all pixels, so that none is quieter than its neighbours.
    seen = seen.mean(axis=0) + (seen - seen.mean(axis=0)) / seen.std(axis=0, ddof=1)
    return test, seen.mean(axis=0), seen.var(axis=0, ddof=1), seen


@pytest.mark.parametrize(("renders", "tests"), [(3, 1), (8, 2), (5, 9)])
def test_a_ratio_of_pixels_is_that_of_two_samples_by_student(renders, tests):
    test, mean, variance, seen = of_one_noise(renders, tests, 6)
    expected = stats.ttest_ind(test, seen, axis=0)
    ratios = noise_ratios(test, mean, variance, renders)[1]
    np.testing.assert_allclose(ratios.values, expected.statistic, rtol=1e-5)
    if tests == 1:
        np.testing.assert_allclose(ratios.freedom, expected.df, rtol=1e-5)


@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize(("renders", "tests"), [(3, 1), (8, 2), (5, 9)])
def test_a_ratio_of_a_block_is_that_of_its_sums(scale, renders, tests):
    """The variance of a sum of independent pixels, from the renders, and that of the test's sums, by Satterthwaite."""
    test, mean, variance, _ = of_one_noise(renders, tests, 16)
    found, step = noise_ratios(test, mean, variance, renders)[scale], max(scale // 2, 1)
    for row, column, c in np.ndindex(found.values.shape):
        block = (..., slice(row * step, row * step + scale), slice(column * step, column * step + scale), c)
        sums, count = (test - mean)[block].sum(axis=(-2, -1)), mean[block].size
        own = sums.var(ddof=1) if tests > 1 else 0.0
        terms = [(renders - 1, count, renders - 1), (tests - 1, own, tests - 1)]
        both = sum(freedom * noise for freedom, noise, _ in terms) / (renders + tests - 2)
        assert found.values[row, column, c] == pytest.approx(
            sums.mean() / np.sqrt(both * (1 / renders + 1 / tests)), rel=1e-5
        )
        # Every pixel of the renders is an estimate of its own.
        squares = ((renders - 1) * count + (tests - 1) * own**2) / (renders + tests - 2) ** 2
        assert found.freedom[row, column, c] == pytest.approx(both**2 / squares, rel=1e-5)


def test_a_pixel_is_as_noisy_as_its_neighbours():
    mean, variance = np.full((9, 9, 1), 0.3), np.ones((9, 9, 1))
    variance[4, 4] = 0
    quiet, even = (noise_ratios(mean[None] + 1, mean, of, 10**6)[1].values for of in (variance, np.ones_like(variance)))
    assert quiet[4, 4] == pytest.approx(even[4, 4] / np.sqrt(8 / 9))
    np.testing.assert_allclose(np.delete(quiet.ravel(), 40), np.delete(even.ravel(), 40))


@pytest.mark.parametrize("scale", SCALES)
def test_ignored_pixels_count_for_nothing(scale):
    """Whatever they show, and however noisy they are; a block of nothing else has a ratio of 0."""
    test, mean, variance, _ = of_one_noise(8, 4, 32)
    ignored = np.zeros((32, 32), bool)
    ignored[:20, 4:] = True
    wild = mean + 1e3 * ignored[..., None], variance + 1e3 * ignored[..., None]
    plain, other = (noise_ratios(test, *of, 8, rounding_of(mean), ignored)[scale] for of in ((mean, variance), wild))
    np.testing.assert_array_equal(plain.values, other.values)
    np.testing.assert_array_equal(plain.freedom, other.freedom)
    assert np.isfinite(plain.values).all()
    assert (plain.freedom > 0).all()
    if scale < 16:
        assert (plain.values == 0).any()


def test_a_spread_is_that_of_every_render_against_the_others():
    images = renders(range(9))
    expected = {name: [] for name in STATISTICS}
    for k, one in enumerate(images.astype(np.float64)):
        others = np.delete(images, k, axis=0).astype(np.float64)
        found = statistics(noise_ratios(one[None], others.mean(axis=0), others.var(axis=0, ddof=1), 8))
        for name, values in expected.items():
            values.append(normalised(name, found[name]))
    for name, spread in leave_one_out(images).items():
        assert (spread.mean, spread.deviation, spread.count) == pytest.approx(
            (np.mean(expected[name]), np.std(expected[name], ddof=1), 9), rel=1e-6
        )


def test_the_tail_of_many_renders_is_that_of_the_law_with_their_moments():
    """Gumbel's for the largest, the normal law for the cube root of sums."""
    spread, value = Spread(1.2, 0.3, 10**9), 1.7
    scale = 0.3 * np.sqrt(6) / np.pi
    gumbel = stats.gumbel_r(1.2 - np.euler_gamma * scale, scale)
    assert (gumbel.mean(), gumbel.std()) == pytest.approx((1.2, 0.3))
    assert spread.tail("largest_4", value) == pytest.approx(gumbel.sf(value), rel=1e-6)
    assert spread.tail("sum_4", value**3) == pytest.approx(stats.norm.sf(value, 1.2, 0.3), rel=1e-6)


def test_the_tail_of_few_renders_is_as_often_so_small_as_it_says():
    """A next one of normal values, whose mean and deviation only four have told."""
    values = np.random.default_rng(0).normal(10, 1, (4000, 5))
    tails = [
        Spread(few.mean(), few.std(ddof=1), 4).tail("sum_1", last**3)
        for *few, last in values
        for few in [np.array(few)]
    ]
    assert stats.kstest(tails, "uniform").pvalue > 0.01


def test_where_nothing_varied_theory_alone_counts():
    assert Spread(1.0, 0.0, 8).tail("sum_1", 1.0) == 0


def gaussian(side, freedom=1e9):
    values = np.random.default_rng(0).normal(size=(side, side, 3))
    return Ratios(values, np.full(values.shape, freedom))


def test_of_many_ratios_the_least_likely_is_as_likely_as_in_so_many_tries():
    values = np.array([0.0, 0.5, -3.0, 4.0]).reshape(2, 2, 1)
    found = ratio_probabilities(Ratios(values, np.full(values.shape, 7.0)))
    single = np.array([1, *(2 * stats.t.sf(x, 7) for x in (0.5, 3.0, 4.0))]).reshape(2, 2, 1)
    np.testing.assert_allclose(found, 1 - (1 - single) ** 4)
    assert theoretical_tail("largest_1", 4.0, Ratios(values, np.full(values.shape, 7.0))) == found.min()


def test_the_sum_of_squares_of_gaussian_noise_is_a_chi_square_of_what_is_drawn():
    ratios = gaussian(8)
    value = np.square(ratios.values).mean()
    found = theoretical_tail("sum_1", value, ratios)
    assert found == pytest.approx(stats.chi2.sf(np.square(ratios.values).sum(), ratios.values.size))
    padded = np.concatenate([ratios.values, np.zeros_like(ratios.values)])
    assert theoretical_tail("sum_1", value / 2, Ratios(padded, np.ones_like(padded))) == pytest.approx(found)


def test_the_square_of_one_ratio_is_as_likely_as_the_ratio():
    values = np.zeros((2, 2, 3))
    values[1, 0, 2] = -2.5
    found = theoretical_tail("sum_1", np.square(values).mean(), Ratios(values, np.ones_like(values)))
    assert found == pytest.approx(2 * stats.norm.sf(2.5))


def test_where_nothing_is_drawn_no_difference_is_certain():
    assert theoretical_tail("sum_1", 0.0, Ratios(np.zeros((2, 2, 3)), np.ones((2, 2, 3)))) == 1


def test_a_probability_is_the_least_of_its_statistics_times_how_many_there_are():
    """For each the larger of theory and experience."""
    ratios = {scale: gaussian(8) for scale in (1, 4)}
    ratios[4].values[0, 0, 0] = 6
    loose, strict = Spread(0.0, 1e3, 8), Spread(0.0, 1e-3, 8)
    theory = theoretical_tail("largest_4", 6.0, ratios[4])
    assert probability(ratios, {"largest_1": loose, "largest_4": strict}) == (
        pytest.approx(2 * max(theory, strict.tail("largest_4", 6.0))), "largest_4",
    )  # fmt: skip
    told, _ = probability(ratios, {"largest_4": loose})
    assert told == pytest.approx(loose.tail("largest_4", 6.0))
    assert told > theory


def test_an_outlier_adds_to_a_sum_as_much_as_any_further_one():
    found = [gaussian(8), gaussian(8)]
    for ratios, outlier in zip(found, (5.0, -500.0), strict=True):
        ratios.values[0, 0, 0] = outlier
    near, far = (statistics({1: ratios}) for ratios in found)
    assert near["sum_1"] == far["sum_1"]
    assert (near["largest_1"], far["largest_1"]) == (5, 500)
