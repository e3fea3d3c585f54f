"""Masks and importances of maps of other sizes: their nearest texels."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from facezip.character.masks import nearest

sides = st.integers(1, 40)


@given(height=sides, width=sides, h=sides, w=sides)
def test_each_texel_is_the_one_nearest_to_its_centre(height, width, h, w):
    rows, columns = np.mgrid[:height, :width].astype(np.float32)
    for index, side, low in ((nearest(rows, (h, w))[:, 0], height, h), (nearest(columns, (h, w))[0], width, w)):
        off = np.abs((index + 0.5) / side - (np.arange(low) + 0.5) / low)
        assert off.max() <= 0.5 / side + 1e-6


@pytest.mark.parametrize("size", [(7, 9), (5, 30)])
def test_a_turned_mask_gives_the_turned_texels(size):
    """Where no centre lies between two texels."""
    mask = np.random.default_rng(0).random((21, 45)).astype(np.float32)
    np.testing.assert_array_equal(nearest(mask[::-1, ::-1], size)[::-1, ::-1], nearest(mask, size))


def test_a_mask_of_its_own_size_is_the_same():
    mask = np.random.default_rng(0).random((6, 10)).astype(np.float32)
    assert nearest(mask, (6, 10)) is mask
