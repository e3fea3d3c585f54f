"""FLIP against its authors' own evaluator, and its laws."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from render.flip import PIXELS_PER_DEGREE, flip, seen

RNG = np.random.default_rng(0)


def smooth(shape):
    return gaussian_filter(RNG.random((*shape, 3)), (3, 3, 0)).astype(np.float32)


def step(shape):
    image = np.full((*shape, 3), 0.2, np.float32)
    image[:, shape[1] // 2 :] = [0.9, 0.4, 0.3]
    return image


PAIRS = {
    "noise": (RNG.random((40, 52, 3), np.float32), RNG.random((40, 52, 3), np.float32)),
    "smooth": (smooth((60, 33)), smooth((60, 33))),
    "small difference": (base := smooth((48, 48)), np.clip(base + np.float32(0.01), 0, 1)),
    "an edge moved": (step((40, 40)), np.roll(step((40, 40)), 2, axis=1)),
    "smaller than its filters": (RNG.random((5, 7, 3), np.float32), RNG.random((5, 7, 3), np.float32)),
    "black and white": (np.zeros((24, 24, 3), np.float32), np.ones((24, 24, 3), np.float32)),
    "green and blue": tuple(np.full((24, 24, 3), colour, np.float32) for colour in ([0, 1, 0], [0, 0, 1])),
}


@pytest.mark.parametrize("pair", PAIRS.values(), ids=PAIRS)
def test_every_pixel_is_that_of_the_authors_evaluator(pair):
    from flip_evaluator import evaluate

    settings = {"ppd": PIXELS_PER_DEGREE}
    expected, _, _ = evaluate(
        *pair, "LDR", inputsRGB=True, applyMagma=False, computeMeanError=False, parameters=settings
    )
    np.testing.assert_allclose(flip(*map(seen, pair)), expected[..., 0], atol=1e-4)


@pytest.mark.parametrize("pair", PAIRS.values(), ids=PAIRS)
def test_it_is_symmetric_and_within_its_range(pair):
    a, b = map(seen, pair)
    error = flip(a, b)
    np.testing.assert_array_equal(error, flip(b, a))
    assert error.min() >= 0
    assert error.max() <= 1


def test_equal_images_do_not_differ():
    image = smooth((31, 64))
    assert not flip(seen(image), seen(image.copy())).any()


def test_turning_both_images_turns_the_error():
    a, b = PAIRS["smooth"]
    turned = flip(seen(a[::-1, ::-1]), seen(b[::-1, ::-1]))
    np.testing.assert_allclose(turned, flip(seen(a), seen(b))[::-1, ::-1], atol=1e-4)
