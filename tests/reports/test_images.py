"""Laws of the colour scale, the display, crops and embedded pictures."""

import base64
import io

import numpy as np
import pytest
from PIL import Image

from facezip.files.srgb import encode_srgb
from reports.images import BACKDROP, ColourScale, Crop, data_uri, difference, display, to_bytes


def pixels_of(uri):
    return np.asarray(Image.open(io.BytesIO(base64.b64decode(uri.partition(",")[2]))).convert("RGB"))


@pytest.mark.parametrize("limit", [1.0, 4.0, 16.0, 64.0])
def test_no_difference_is_the_lowest_colour_and_the_limit_the_highest(limit):
    scale = ColourScale(limit)
    colours = scale.colours(np.array([[0, limit, 2 * limit, 255]], np.float32))
    assert (colours[0, 0] == scale.table[0]).all()
    assert (colours[0, 1:] == scale.table[-1]).all()


def test_a_larger_difference_is_never_darker():
    luma = ColourScale(16.0).table @ np.array([0.2126, 0.7152, 0.0722])
    assert (np.diff(luma) > -0.5).all()
    assert luma[-1] > 10 * max(luma[0], 1)


@pytest.mark.parametrize("rmse", [0.0, 0.1, 0.26, 1.0, 3.3, 15.0])
def test_a_scale_holds_four_times_its_error_and_no_more_than_eight(rmse):
    scale = ColourScale.for_error(rmse)
    assert scale.limit >= 4 * rmse
    assert scale.limit <= max(8 * rmse, 1)
    assert scale.factor * scale.limit == 256


def test_gradient_runs_from_the_first_colour_to_the_last():
    scale = ColourScale(8.0)
    stops = scale.gradient(5).split(", ")
    assert len(stops) == 5
    assert stops[0] == "#" + bytes(scale.table[0].tolist()).hex()
    assert stops[-1] == "#" + bytes(scale.table[-1].tolist()).hex()


def test_equal_pictures_have_no_difference_and_order_does_not_matter():
    rng = np.random.default_rng(0)
    a, b = rng.random((2, 5, 7, 3)).astype(np.float32)
    assert (difference(a, a) == 0).all()
    np.testing.assert_array_equal(difference(a, b), difference(b, a))
    np.testing.assert_allclose(difference(a, b), 255 * np.abs(a - b).max(axis=2), rtol=1e-6)


def test_a_covered_pixel_shows_its_own_colour_and_an_empty_one_the_backdrop():
    render = np.zeros((1, 2, 4), np.float32)
    render[0, 0] = 0.25, 0.5, 3.0, 1.0
    shown = display(render)
    expected = encode_srgb(np.array([0.25, 0.5, 1.0], np.float32))
    np.testing.assert_allclose(shown[0, 0], expected, atol=1e-6)
    assert tuple(to_bytes(shown)[0, 1]) == BACKDROP


def test_a_crop_holds_every_covered_pixel_of_every_picture():
    first, second = np.zeros((2, 100, 80), np.float32)
    first[40, 30] = second[60, 50] = 0.01
    crop = Crop.around([first, second], margin=0)
    assert crop == Crop(40, 61, 30, 51)
    assert crop.of(first).shape == (21, 21) == crop.size
    assert Crop.around([first, second], margin=1) == Crop(0, 100, 0, 80)


def test_a_crop_of_nothing_is_everything():
    assert Crop.around([np.zeros((6, 9), np.float32)]) == Crop(0, 6, 0, 9)


def test_a_lossless_picture_comes_back_exactly():
    pixels = np.random.default_rng(1).integers(0, 256, (17, 23, 3), np.uint8)
    np.testing.assert_array_equal(pixels_of(data_uri(pixels)), pixels)


def test_a_lossy_picture_is_smaller_and_close():
    y, x = np.mgrid[:64, :64]
    pixels = np.stack([2 * x + y, x + y, 60 + x], axis=2).astype(np.uint8)
    noisy = pixels + np.random.default_rng(2).integers(0, 4, pixels.shape).astype(np.uint8)
    uri = data_uri(noisy, 90)
    assert len(uri) < len(data_uri(noisy))
    assert np.abs(pixels_of(uri).astype(float) - noisy).mean() < 3
