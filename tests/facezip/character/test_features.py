"""Features: one that slipped or is lost is seen, one in its place is not; a texture that is turned is told."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import gaussian_filter

from facezip.character.features import SIDE, turned, worst_feature

CELLS = np.ones((32, 32), np.float32)
seeds = st.integers(0, 99)
places = st.integers(60, SIDE - 60)
turns = st.sampled_from(
    [
        ("upside down", lambda image: image[::-1]),
        ("mirrored", lambda image: image[:, ::-1]),
        ("turned by half", lambda image: image[::-1, ::-1]),
        ("transposed", lambda image: image.T),
    ]
)


def skin(seed, detail=2.0):
    """Log luminance ``(SIDE, SIDE)`` of something with structure everywhere."""
    return gaussian_filter(np.random.default_rng(seed).normal(0, 1, (SIDE, SIDE)), detail).astype(np.float32)


def noisy(image, seed):
    return image + np.random.default_rng(seed).normal(0, 0.02 * image.std(), image.shape).astype(np.float32)


@settings(max_examples=10, deadline=None)
@given(seeds, seeds)
def test_what_is_in_its_place_is_not_accused(seed, other):
    image = skin(seed)
    assert worst_feature(image, noisy(image, other), CELLS) is None
    assert turned(image, noisy(image, other)) is None


@settings(max_examples=10, deadline=None)
@given(seeds, places, places, st.integers(2, 4), st.sampled_from([(0, 1), (1, 0), (-1, 0), (0, -1)]))
def test_a_feature_that_slipped_is_found_with_its_place_and_way(seed, x, y, texels, way):
    y_, x_ = np.mgrid[:SIDE, :SIDE]
    # A feature stands out from the skin around it.
    image = (skin(seed, 1) * (1 + 2 * np.exp(-((x_ - x) ** 2 + (y_ - y) ** 2) / 40**2))).astype(np.float32)
    across, down = texels * way[0], texels * way[1]
    slipped, half = image.copy(), 24
    there = slice(y - half + down, y + half + down), slice(x - half + across, x + half + across)
    slipped[there] = image[y - half : y + half, x - half : x + half]
    found = worst_feature(image, slipped, CELLS)
    assert found.state == "slipped"
    assert found.texels == texels
    assert np.hypot(found.u * SIDE - x, (1 - found.v) * SIDE - y) < 2 * half


@settings(max_examples=10, deadline=None)
@given(seeds, places, places)
def test_a_feature_that_is_gone_is_lost(seed, x, y):
    image = skin(seed)
    y_, x_ = np.mgrid[:SIDE, :SIDE]
    gone = 1 / (1 + np.exp((np.hypot(x_ - x, y_ - y) - 30) / 2))
    found = worst_feature(image, (image * (1 - gone)).astype(np.float32), CELLS)
    assert found.state == "lost"
    assert np.hypot(found.u * SIDE - x, (1 - found.v) * SIDE - y) < 30


@settings(max_examples=10, deadline=None)
@given(seeds, places, places)
def test_a_wrinkle_is_no_loss(seed, x, y):
    image = skin(seed)
    _, x_ = np.mgrid[:SIDE, :SIDE]
    wrinkle = -2 * image.std() * np.exp(-(((x_ - x) / 2) ** 2))
    found = worst_feature(image, (image + wrinkle).astype(np.float32), CELLS)
    assert found is None


@settings(max_examples=20, deadline=None)
@given(seeds, turns)
def test_a_texture_that_is_turned_is_told_how(seed, turn):
    how, change = turn
    image = skin(seed, 4)
    assert turned(image, noisy(np.ascontiguousarray(change(image)), seed)) == how


@pytest.mark.parametrize("side", [4, 32, 64, 100])
def test_any_size_has_an_answer(side):
    image = np.random.default_rng(0).normal(size=(side, side)).astype(np.float32)
    assert worst_feature(image, image, CELLS) is None
    assert turned(image, image) is None
