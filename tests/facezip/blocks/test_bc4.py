import numpy as np
import pytest
import texture2ddecoder

from facezip.blocks import bc4


def maps(height=24, width=40, seed=0):
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:height, :width] / 10
    return np.clip(0.5 + 0.4 * np.sin(x + y) + rng.normal(0, 0.02, (height, width)), 0, 1).astype(np.float32)


def decoded(blocks, height, width):
    bgra = np.frombuffer(texture2ddecoder.decode_bc4(blocks, width, height), np.uint8)
    return bgra.reshape(height, width, 4)[..., 2]


@pytest.mark.parametrize("texels", [maps(), np.full((8, 8), 0.3, np.float32), np.eye(12, dtype=np.float32)])
def test_a_decoder_of_others_sees_what_the_round_trip_says(texels):
    seen = decoded(bc4.encode(texels).tobytes(), *texels.shape)
    assert np.abs(seen - 255 * bc4.round_trip(texels)).max() < 1


@pytest.mark.parametrize("texels", [maps(21, 33), np.full((8, 8), 0.3, np.float32), np.eye(12, dtype=np.float32)])
def test_what_is_decoded_is_the_round_trip(texels):
    np.testing.assert_array_equal(bc4.decode(bc4.encode(texels), *texels.shape), bc4.round_trip(texels))


def test_the_blocks_take_as_many_bytes_as_are_counted():
    assert bc4.encode(maps(21, 33)).nbytes == bc4.bytes_of(21, 33) == 6 * 9 * 8


def test_texels_past_the_border_do_not_change_those_within():
    texels = maps(21, 33)
    padded = np.pad(texels, ((0, 3), (0, 3)), mode="edge")
    np.testing.assert_array_equal(bc4.round_trip(texels), bc4.round_trip(padded)[:21, :33])


def test_many_maps_are_coded_one_by_one():
    many = np.stack([maps(seed=s) for s in range(3)])
    np.testing.assert_array_equal(bc4.round_trip(many), np.stack([bc4.round_trip(one) for one in many]))


def test_values_that_the_steps_can_hold_come_back():
    steps = np.random.default_rng(0).integers(0, 8, (16, 16))
    steps[::4, ::4], steps[1::4, ::4] = 0, 7  # both end points in every block
    texels = ((30 + 14 * steps) / 255).astype(np.float32)
    np.testing.assert_allclose(bc4.round_trip(texels), texels, atol=1e-6)


def test_it_loses_less_than_least_and_greatest_values_as_end_points():
    texels = maps() * 255
    blocks = texels.reshape(6, 4, 10, 4).swapaxes(1, 2).reshape(-1, 16)
    low, range_ = blocks.min(axis=1, keepdims=True), np.ptp(blocks, axis=1, keepdims=True)
    plain = low + np.rint((blocks - low) / range_ * 7) * range_ / 7
    ours = 255 * bc4.round_trip(texels / 255)
    assert np.square(ours - texels).sum() < 0.9 * np.square(plain - blocks).sum()
