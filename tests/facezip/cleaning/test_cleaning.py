"""Cleaning: what a capture added goes, what is clean stays to the bit, detail survives, orders do not matter."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from facezip.character.maps import Map
from facezip.character.scans import Stack
from facezip.cleaning.cells import cells_of
from facezip.cleaning.exposure import even_out
from facezip.cleaning.filters import Filter
from facezip.cleaning.neutral import fused
from facezip.cleaning.noise import Noise
from facezip.cleaning.steps import STEPS, clean
from facezip.documents.document import plain
from facezip.machine import memory
from scenes.character import Person, make_character
from tests.facezip.conftest import one_albedo

SIDE, SCANS = 96, 12


@pytest.fixture(scope="module")
def truth():
    """Skin: detail of all sizes, and pores that are deep in the middle and absent at either side."""
    rng = np.random.default_rng(0)
    layers = [gaussian_filter(rng.standard_normal((SIDE, SIDE)), width) * width for width in (0.6, 2, 8)]
    layers[0] *= np.clip(np.sin(np.linspace(0, np.pi, SIDE)) * 1.5 - 0.5, 0, 1)
    return (0.55 + 0.05 * sum(layers)[..., None] * [1, 0.9, 0.8]).astype(np.float32)


def scans_of(truth, noise, seed=1, change=0.0):
    """Scans of the same skin with noise, in the first of which a corner changed; the mask is the whole texture."""
    rng = np.random.default_rng(seed)
    images = truth + noise * rng.standard_normal((SCANS + 1, *truth.shape))
    images[1:3, :32, :32] += change
    texels = np.rint(255 * np.clip(images, 0, 1)).astype(np.uint8)
    return Stack(texels[0], texels[1:])


def rmse(texels, truth):
    return 255 * np.sqrt(np.mean(np.square(texels / 255.0 - truth)))


def bright(stack, gains):
    values = np.rint(np.clip(stack.textures * np.array(gains).reshape(-1, 1, 1, 1), 0, 255))
    return replace(stack, textures=values.astype(np.uint8))


def test_a_neutral_of_many_scans_has_little_of_their_noise(truth):
    stack = scans_of(truth, 2 / 255)
    made = fused(stack)
    assert made.noise == pytest.approx(2, rel=0.15)
    assert rmse(made.stack.neutral, truth) < 0.6 * rmse(stack.neutral, truth)


@pytest.mark.parametrize("dtype", [np.uint16, np.float32])
def test_finer_texels_are_cleaned_alike(truth, dtype):
    stack = scans_of(truth, 2 / 255)
    one = fused(stack)
    most = 1 if dtype == np.float32 else 257
    finer = Stack(
        *((texels / (255 if most == 1 else 1) * most).astype(dtype) for texels in (stack.neutral, stack.textures))
    )
    other = fused(finer)
    assert other.stack.neutral.dtype == dtype
    assert other.noise == pytest.approx(one.noise, rel=1e-3)
    gap = other.stack.neutral * (255.0 if most == 1 else 1 / 257) - one.stack.neutral
    assert np.abs(gap).max() < 0.51


def test_what_moved_in_some_scans_is_not_in_the_neutral(truth):
    made = fused(scans_of(truth, 2 / 255, change=0.2))
    assert rmse(made.stack.neutral[:32, :32], truth[:32, :32]) < 2


@pytest.mark.parametrize("blur", [0.0, 0.7])
def test_pores_keep_their_contrast(truth, blur):
    """The power above a quarter of the sampling frequency, though all scans but the neutral are blurred."""
    stack = scans_of(truth, 1 / 255)
    if blur:
        soft = gaussian_filter(stack.textures.astype(np.float32), (0, blur, blur, 0))
        stack = replace(stack, textures=np.rint(soft).astype(np.uint8))

    def power(image):
        tapered = (image.mean(axis=2) - image.mean()) * np.hanning(SIDE)[:, None] * np.hanning(SIDE)
        fine = np.hypot(np.fft.fftfreq(SIDE)[:, None], np.fft.fftfreq(SIDE)) > 0.25
        return np.square(np.abs(np.fft.fft2(tapered)))[fine].sum()

    assert power(fused(stack).stack.neutral / 255.0) == pytest.approx(power(truth), rel=0.1)


def test_scans_without_noise_are_left_alone(truth):
    stack = scans_of(truth, 0.0, change=0.1)
    assert fused(stack).stack is stack


def test_the_order_of_the_scans_does_not_matter(truth):
    stack = scans_of(truth, 2 / 255, change=0.1)
    order = np.random.default_rng(2).permutation(SCANS)
    other = fused(replace(stack, textures=stack.textures[order])).stack
    one = fused(stack).stack
    # Sums of floats in another order may round a texel otherwise.
    assert (one.neutral != other.neutral).mean() < 1e-3
    assert (one.textures[order] != other.textures).mean() < 1e-3


def test_the_same_scans_give_the_same_bits(truth):
    stack = scans_of(truth, 2 / 255)
    one, other = fused(stack).stack, fused(stack).stack
    assert np.array_equal(one.neutral, other.neutral)
    assert np.array_equal(one.textures, other.textures)


def test_noise_that_grows_with_brightness_is_found():
    rng = np.random.default_rng(3)
    ramp = np.broadcast_to(np.linspace(0.1, 0.9, 256)[:, None], (256, 256, 3))
    images = ramp + rng.standard_normal((8, 256, 256, 3)) * np.sqrt(1e-5 + 1e-4 * ramp)
    texels = np.clip(images, 0, 1).astype(np.float32)
    noise = Noise.of(cells_of(Stack(texels[0], texels[1:])))
    found = noise.at(np.array([0.2, 0.8], np.float32))
    np.testing.assert_allclose(found, 1e-5 + 1e-4 * np.array([0.2, 0.8]), rtol=0.3)


def test_exposures_come_back_to_that_of_the_neutral(truth):
    """The scans' mean is not far from the neutral's exposure: that is kept."""
    gains = np.linspace(0.97, 1.03, SCANS)
    stack = scans_of(truth, 1 / 255)
    evened, found = even_out(one_albedo(bright(stack, gains)))
    means = evened.first.textures.mean(axis=(1, 2, 3)) / stack.neutral.mean()
    np.testing.assert_allclose(means, 1, atol=2e-3)
    assert np.array_equal(evened.first.neutral, stack.neutral)
    np.testing.assert_allclose(found["expr_0"], gains[0], atol=2e-3)


def test_a_neutral_that_is_off_comes_to_the_scans(truth):
    stack = scans_of(truth, 1 / 255)
    dark = replace(stack, neutral=np.rint(0.95 * stack.neutral).astype(np.uint8))
    evened, found = even_out(one_albedo(dark))
    assert evened.first.neutral.mean() / stack.neutral.mean() == pytest.approx(1, abs=0.006)
    assert found["neutral"] == pytest.approx([0.95] * 3, abs=0.006)


def test_every_map_of_colours_is_evened_out_by_itself(truth):
    """One that needs nothing takes nothing from those before it."""
    stack = scans_of(truth, 1 / 255)
    uneven = bright(stack, np.linspace(0.97, 1.03, SCANS))
    one = one_albedo(uneven)
    makeup, key = Map("makeup", "srgb"), ("makeup", 1001)
    evened, found = even_out(replace(one, maps=(*one.maps, makeup), stacks={**one.stacks, key: stack}))
    np.testing.assert_array_equal(evened.first.textures, even_out(one)[0].first.textures)
    assert evened.stacks[key] is stack
    assert found == even_out(one)[1]
    both, gains = even_out(replace(one, maps=(*one.maps, makeup), stacks={**one.stacks, key: uneven}))
    np.testing.assert_array_equal(both.stacks[key].textures, evened.first.textures)
    assert gains == found | {f"{name} makeup": gain for name, gain in found.items()}


def test_equal_exposures_stay_to_the_bit(truth):
    character = one_albedo(scans_of(truth, 1 / 255, change=0.1))
    evened, found = even_out(character)
    assert not found
    assert evened is character


def test_a_filter_is_found_again(truth):
    taps = np.zeros((5, 5), np.float32)
    taps[1:4, 1:4] = np.array([[1, 2, 1], [2, 4, 2], [1, 2, 1]]) / 16
    blurred = Filter(taps)(truth)
    np.testing.assert_allclose(Filter.towards(truth, blurred, np.ones(truth.shape[:2])).taps, taps, atol=1e-3)


@pytest.fixture(scope="module")
def captured():
    return {nuisances: make_character(128, 8, seed=6, nuisances=nuisances) for nuisances in (0.0, 1.0)}


def test_a_clean_character_stays_to_the_bit(captured):
    made = clean(captured[0.0])
    assert set(plain(made.facts)) == set(STEPS)
    assert not made.character.notes
    for key, stack in captured[0.0].stacks.items():
        assert np.array_equal(made.character.stacks[key].neutral, stack.neutral)
        assert np.array_equal(made.character.stacks[key].textures, stack.textures)


def test_a_capture_comes_nearer_to_the_truth_and_says_so(captured):
    made = clean(captured[1.0])
    true = Person.make(128, 6).texture({})
    before, after = (rmse(one.first.neutral, true) for one in (captured[1.0], made.character))
    assert after < 0.75 * before
    assert any("evened out" in note.words for note in made.character.notes)
    assert made.facts.neutral["albedo.1001"].noise > 0.5


def test_within_a_limit_of_memory_the_result_is_the_same(captured, monkeypatch, tmp_path):
    monkeypatch.setattr(memory, "LEAST", -(10**9))
    with memory.limited(1, tmp_path):
        streamed = clean(captured[1.0])
    whole = clean(captured[1.0])
    assert streamed.facts == whole.facts
    for key, stack in whole.character.stacks.items():
        assert np.array_equal(streamed.character.stacks[key].neutral, stack.neutral)
        assert np.array_equal(streamed.character.stacks[key].textures, stack.textures)


def test_no_step_is_taken_that_was_not_asked_for(captured):
    made = clean(captured[1.0], ())
    assert made.character is captured[1.0]
    assert not plain(made.facts)
