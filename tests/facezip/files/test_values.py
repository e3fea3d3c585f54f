"""Masks: the channel that holds the numbers is found, wherever it is certain, and nothing else is guessed."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from facezip import FaceZipError
from facezip.files.images import write_texture
from facezip.files.values import read_mask, read_values
from tests.facezip.files import profiles, stored

RNG = np.random.default_rng(0)
MASK = np.zeros((40, 12), np.uint8)
MASK[5:30, 2:9] = RNG.integers(1, 256, (25, 7))
ONE, NONE = np.full_like(MASK, 255), np.zeros_like(MASK)
OTHER = np.ascontiguousarray(MASK[::-1])


def stack(*channels):
    return np.stack(channels, axis=-1)


CERTAIN = {
    "grey": stack(MASK),
    "grey and opaque": stack(MASK, ONE),
    "alpha of white": stack(ONE, MASK),
    "alpha of black": stack(NONE, MASK),
    "three alike": stack(MASK, MASK, MASK),
    "red alone": stack(MASK, NONE, NONE),
    "blue alone": stack(NONE, ONE, MASK),
    "yellow": stack(MASK, MASK, NONE),
    "opaque": stack(MASK, MASK, MASK, ONE),
    "an alpha that nobody filled": stack(MASK, MASK, MASK, NONE),
    "in the alpha of one colour": stack(ONE, NONE, NONE + 7, MASK),
    "in colours and alpha": stack(MASK, MASK, MASK, MASK),
    "white where it is visible": stack(*[np.where(MASK > 0, ONE, NONE)] * 3, MASK),
    "all white": stack(ONE, ONE, ONE),
    "nothing": stack(NONE, NONE, NONE, ONE),
}
MEANT = {"all white": ONE, "nothing": NONE}


@pytest.mark.parametrize("bits", [8, 16])
@pytest.mark.parametrize("name", CERTAIN)
def test_the_channel_that_is_meant_is_found(tmp_path, name, bits):
    texels = CERTAIN[name].astype(np.uint16) * 257 if bits == 16 else CERTAIN[name]
    (tmp_path / "mask.png").write_bytes(stored.png(texels))
    np.testing.assert_allclose(read_mask(tmp_path / "mask.png")[0], MEANT.get(name, MASK) / 255, atol=1e-6)


UNCERTAIN = {
    "two masks": (stack(MASK, OTHER, NONE), "channels R, G differ"),
    "a colour and an alpha": (stack(OTHER, OTHER, OTHER, MASK), "colours and its alpha differ"),
    "grey and another alpha": (stack(OTHER, MASK), "colours and its alpha differ"),
    "a colour all over": (stack(ONE, NONE, NONE), "channels R, G, B differ"),
}


@pytest.mark.parametrize("name", UNCERTAIN)
def test_channels_that_differ_are_named(tmp_path, name):
    texels, says = UNCERTAIN[name]
    (tmp_path / "mask.png").write_bytes(stored.png(texels))
    with pytest.raises(FaceZipError, match=rf"mask\.png: its {says}.*export it as one grey channel"):
        read_mask(tmp_path / "mask.png")


@given(seed=st.integers(0, 99), quality=st.integers(80, 100), opaque=st.booleans())
@settings(max_examples=20, deadline=None)
def test_a_lossy_compression_hides_no_channel(tmp_path_factory, seed, quality, opaque):
    y, x = np.mgrid[:64, :64]
    smooth = np.rint(255 * np.exp(-((x - 20 - seed / 9) ** 2 + (y - 30) ** 2) / 200)).astype(np.uint8)
    texels = stack(smooth, smooth, smooth) if opaque else stack(*[np.full_like(smooth, 255)] * 3, smooth)
    path = tmp_path_factory.mktemp("lossy") / ("mask.jpg" if opaque else "mask.webp")
    Image.fromarray(texels).save(path, quality=quality)
    assert np.abs(read_mask(path)[0] - smooth / 255).max() < 16 / 255


STATEMENTS = {
    "gamma": [stored.gama(1)],
    "profile": [stored.iccp(profiles.icc(profiles.COLUMNS["ProPhoto"], [profiles.curve(1.8)] * 3))],
    "code points": [(b"cICP", bytes([9, 16, 0, 1]))],
}


@pytest.mark.parametrize("name", STATEMENTS)
def test_numbers_of_a_mask_are_of_no_colour_space(tmp_path, name):
    (tmp_path / "mask.png").write_bytes(stored.png(stack(MASK, MASK, MASK), STATEMENTS[name]))
    np.testing.assert_array_equal(read_mask(tmp_path / "mask.png")[0], MASK.astype(np.float32) / np.float32(255))


def test_floats_of_a_mask_are_as_they_are_stored(tmp_path):
    values = RNG.random((9, 8, 1)).astype(np.float32)
    (tmp_path / "mask.exr").write_bytes(stored.exr({"Y": (values[..., 0], 1)}, (9, 8)))
    np.testing.assert_array_equal(read_mask(tmp_path / "mask.exr")[0], values[..., 0])


def test_a_brush_of_openexr_is_its_alpha(tmp_path):
    alpha = MASK.astype(np.float32) / 255
    (tmp_path / "mask.exr").write_bytes(stored.exr(dict.fromkeys("RGBA", (alpha, 1)), MASK.shape))
    np.testing.assert_allclose(read_mask(tmp_path / "mask.exr")[0], alpha, atol=1e-6)


@pytest.mark.parametrize(("value", "says"), [(np.nan, "not finite"), (-1, "negative"), (3, "values up to 3")])
def test_what_is_no_mask_is_refused(tmp_path, value, says):
    values = np.full((4, 4), 0.5, np.float32)
    values[1, 2] = value
    (tmp_path / "mask.exr").write_bytes(stored.exr({"Y": (values, 1)}, (4, 4)))
    with pytest.raises(FaceZipError, match=says):
        read_mask(tmp_path / "mask.exr")
    if value == 3:
        assert read_values(tmp_path / "mask.exr").max() == 3


def test_what_is_written_as_a_mask_is_read_again(tmp_path):
    write_texture(tmp_path / "mask.png", MASK[..., None])
    np.testing.assert_array_equal(read_mask(tmp_path / "mask.png")[0], MASK.astype(np.float32) / np.float32(255))
