import numpy as np
import pytest

from facezip.blocks.codecs import ASTC_BLOCKS, astc, bc1, bc7, raw

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
