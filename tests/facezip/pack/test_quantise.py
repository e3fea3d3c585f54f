import numpy as np
import pytest

from facezip.character.maps import ALBEDO, KNOWN
from facezip.pack.model import Part
from facezip.pack.quantise import (
    STEPS,
    StoredPart,
    StoredWeights,
    best_ranges,
    dequantise_part,
    quantise,
    quantise_part,
    quantise_weights,
)
from tests.facezip.conftest import masked, random_model


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


@pytest.mark.parametrize("law", [lambda p: 1 - p, lambda p: -np.log(p)], ids=["even", "exponential"])
def test_no_other_range_costs_less(law):
    """What steps of a range cost, r² / (12 · 127²), and what it cuts off, tried twice a bin, in any unit."""
    size = law((np.arange(256 * 256) + 0.5) / 256**2)
    values = (size * np.where(np.arange(256 * 256) % 2, 1, -1)).astype(np.float32).reshape(1, 256, 256, 1)
    tried = size.max() * np.arange(2049, 4097) / 4096
    costs = [np.square(np.maximum(size - r, 0)).mean() + (r / STEPS) ** 2 / 12 for r in tried]
    chosen = best_ranges(np.concatenate([values / 100, 3 * values]), np.ones((256, 256), np.float32))[:, 0]
    np.testing.assert_allclose(chosen * [100, 1 / 3], tried[np.argmin(costs)], rtol=0, atol=size.max() / 2048)


def test_values_of_one_size_are_the_range():
    values = np.where(np.arange(64) % 2, 0.7, -0.7).astype(np.float32).reshape(1, 8, 8, 1)
    assert best_ranges(values, np.ones((8, 8), np.float32))[0, 0] == np.float32(0.7)


def test_a_texture_of_nothing_has_a_range_still():
    """Which no division by it overflows."""
    chosen = best_ranges(np.zeros((1, 8, 8, 3), np.float32), np.ones((8, 8), np.float32))
    assert (chosen > 0).all()
    assert chosen.max() < 1e-6


@pytest.mark.parametrize("locked", [frozenset(), frozenset({1})])
@pytest.mark.parametrize("channels", [1, 3])
def test_bytes_that_were_values_are_the_same_bytes(locked, channels):
    """All of them, over several blocks of rows; a byte of 0 is beyond a range, and only of what is locked."""
    rng = np.random.default_rng(0)
    texels = rng.integers(0, 256, (2, 70, 40, channels)).astype(np.uint8)
    span = rng.uniform(0.1, 2, (2, channels)).astype(np.float32)
    neutral = rng.integers(0, 256, (70, 40, channels)).astype(np.uint8)
    part = dequantise_part(StoredPart(neutral, texels, span), KNOWN[ALBEDO])
    again = quantise_part(
        Part(part.neutral, part.differences, difference_range=span.astype(float) * STEPS / 255, locked=locked),
        KNOWN[ALBEDO],
    )
    expected = np.maximum(texels, 1)
    for slot in locked:
        expected[slot] = texels[slot]
    np.testing.assert_array_equal(again.differences, expected)
    np.testing.assert_array_equal(again.span, span)
    np.testing.assert_array_equal(again.neutral, neutral)


def test_the_range_is_the_largest_value_wherever_it_is():
    values = np.random.default_rng(0).uniform(-1, 1, (2, 70, 40, 3)).astype(np.float32)
    values[0, 69, 39, 0], values[1, 0, 0, 2] = -3, 5
    stored = quantise_part(Part(np.zeros((70, 40, 3), np.float32), values), KNOWN[ALBEDO])
    assert (stored.differences[0, 69, 39, 0], stored.differences[1, 0, 0, 2]) == (1, 255)
    np.testing.assert_allclose(stored.span * STEPS / 255, np.abs(values).max(axis=(1, 2)), rtol=1e-6)


def test_a_neutral_that_is_packed_already_is_kept():
    values = np.zeros((1, 4, 4, 3), np.float32)
    packed = np.random.default_rng(0).integers(0, 65536, (4, 4, 3)).astype(np.uint16)
    stored = quantise_part(Part(values[0], values, 8, packed=packed), KNOWN[ALBEDO])
    np.testing.assert_array_equal(stored.neutral, packed)
    assert stored.bits == 16


def stored_weights(shape):
    """Of every byte in every slot."""
    rng = np.random.default_rng(0)
    texels = rng.integers(0, 256, shape).astype(np.uint8)
    texels[0, 0, 0], texels[-1, -1, -1] = 0, 255
    span, offset = rng.uniform(0.1, 2, (2, shape[3])).astype(np.float32)
    return StoredWeights(texels, span, offset)


def test_weights_that_were_bytes_are_the_same_bytes():
    """Over several blocks of rows, with the least in the first and the largest in the last."""
    stored = stored_weights((3, 70, 9, 4))
    again = quantise_weights(stored.values)
    np.testing.assert_array_equal(again.texels, stored.texels)
    np.testing.assert_allclose([again.span, again.offset], [stored.span, stored.offset], rtol=1e-5)


def test_a_range_that_is_given_counts_and_one_that_is_not_is_found():
    stored = stored_weights((3, 5, 9, 2))
    ranges = np.array([[-1, np.nan], [4, np.nan]], np.float32)
    again = quantise_weights(stored.values, ranges)
    assert (again.offset[0], again.span[0]) == (-1, 4)
    np.testing.assert_array_equal(again.texels[..., 1], stored.texels[..., 1])
    np.testing.assert_allclose(again.values[..., 0], stored.values[..., 0], atol=0.51 * 4 / 255)


def test_weights_beyond_a_given_range_are_at_its_ends():
    ranges = np.array([[0], [1]], np.float32)
    stored = quantise_weights(np.array([-0.2, 0, 1, 1.004, 1.2], np.float32).reshape(1, 1, 5, 1), ranges)
    assert stored.texels.ravel().tolist() == [0, 0, 255, 255, 255]


def test_weights_that_are_all_the_same_stay_so():
    weights = np.full((2, 3, 4, 2), 0.7, np.float32)
    np.testing.assert_array_equal(quantise_weights(weights).values, weights)


def test_weights_are_uniform_where_every_map_is_one_texel():
    one, row, column = (quantise_weights(np.ones((3, *size, 2), np.float32)) for size in ((1, 1), (1, 4), (4, 1)))
    assert (one.uniform, row.uniform, column.uniform) == (True, False, False)
    numbers = np.random.default_rng(0).normal(size=(3, 1, 1, 2)).astype(np.float32)
    stored = quantise_weights(numbers)
    np.testing.assert_array_equal(stored.values, numbers)
    assert (*stored.span, *stored.offset) == (1, 1, 0, 0)


def test_weight_maps_of_masks_are_rounded_as_others_are():
    model = masked(random_model())
    stored = quantise(model)
    assert stored.dequantised().masked is model.masked
    expected, found = quantise_weights(model.weights[1001]), stored.weight_maps(1001)
    np.testing.assert_array_equal(found.texels, expected.texels)
    plain = quantise(random_model())
    assert plain.weight_maps(1001) is plain.weights[1001]
