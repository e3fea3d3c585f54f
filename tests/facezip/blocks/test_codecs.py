from dataclasses import replace

import numpy as np
import pytest

from facezip.blocks import bc4 as least_squares
from facezip.blocks.codecs import ASTC_BLOCKS, astc, bc1, bc4, bc5, bc7, raw

CODECS = [bc1(), bc7(), *(astc(block, "fast") for block in ASTC_BLOCKS)]
names = pytest.mark.parametrize("codec", CODECS, ids=lambda codec: codec.name)


def smooth(height, width):
    y, x = np.mgrid[:height, :width]
    values = np.stack([128 + 60 * np.sin(x / 20), 100 + 50 * np.cos(y / 15), 60 + 90 * x / width], axis=2)
    return values.astype(np.uint8)


@names
def test_the_encoder_writes_as_many_bytes_as_are_counted(codec):
    height, width = 60, 120  # whole blocks of every size but 8 x 8 and 8 x 6
    height, width = (-(-size // b) * b for size, b in zip((height, width), codec.block[::-1], strict=True))
    assert len(codec.encode(np.zeros((height, width, 3), np.uint8))) == codec.bytes_of(height, width)


@names
def test_smooth_texels_come_back_nearly_as_they_were(codec):
    texels = smooth(61, 83)  # no whole number of blocks
    stored = codec.round_trip(texels)
    assert stored.shape == texels.shape
    assert np.abs(stored.astype(int) - texels).mean() < 3


@names
def test_a_round_trip_is_the_same_every_time(codec):
    texels = np.random.default_rng(0).integers(0, 256, (24, 40, 3), dtype=np.uint8)
    np.testing.assert_array_equal(codec.round_trip(texels), codec.round_trip(texels))


def test_texels_of_one_channel_are_coded_as_grey():
    texels = smooth(32, 32)[..., :1]
    assert np.abs(bc7().round_trip(texels).astype(int) - texels).max() <= 3


def test_larger_blocks_of_astc_lose_more():
    texels = np.random.default_rng(0).normal(128, 20, (48, 48, 3)).clip(0, 255).astype(np.uint8)
    errors = [np.square(astc(b, "fast").round_trip(texels).astype(float) - texels).mean() for b in ASTC_BLOCKS]
    assert errors == sorted(errors)


def test_raw_texels_stay_and_take_a_byte_a_channel():
    texels = smooth(5, 7)
    assert raw(3).round_trip(texels) is texels
    assert raw(3).bytes_of(5, 7) == 5 * 7 * 3


@pytest.mark.parametrize("codec", [*CODECS, bc4(), bc5()], ids=lambda codec: codec.name)
def test_bands_of_a_texture_are_coded_as_the_whole(codec):
    texels = smooth(85, 61)[..., : codec.channels]
    whole = replace(codec, band=0)
    np.testing.assert_array_equal(codec.store(texels), whole.store(texels))
    np.testing.assert_array_equal(codec.round_trip(texels), whole.round_trip(texels))


@pytest.mark.parametrize("codec", [bc4(), bc5()], ids=lambda codec: codec.name)
def test_channels_of_their_own_know_nothing_of_each_other(codec):
    texels = np.random.default_rng(0).integers(0, 256, (21, 33, 3), dtype=np.uint8)
    seen = codec.round_trip(texels)
    assert len(codec.store(texels)) == codec.bytes_of(21, 33)
    assert seen.shape == (21, 33, codec.channels)
    for k in range(codec.channels):
        alone = 65535 * least_squares.round_trip(texels[..., k] / np.float32(255))
        np.testing.assert_allclose(seen[..., k], alone, atol=0.51)


def test_two_channels_of_their_own_lose_less_than_three_that_share():
    texels = np.random.default_rng(0).normal(128, 10, (48, 48, 3)).clip(0, 255).astype(np.uint8)
    own, shared = bc5().round_trip(texels) / 257, bc7().round_trip(texels)[..., :2]
    errors = [np.square(seen - texels[..., :2].astype(float)).mean() for seen in (own, shared)]
    assert errors[0] < 0.5 * errors[1]
