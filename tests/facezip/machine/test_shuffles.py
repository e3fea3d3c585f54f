"""Numbers that change places are where arrays would have them."""

import numpy as np
import pytest

from facezip.machine.kernels import kernel
from facezip.machine.shuffles import add_fours, folded, maximum, split_texels, store_texels, totals, transposed
from facezip.machine.vectors import ABREAST, LANES, load, load_abreast, store

FOUR = np.random.default_rng(0).normal(size=(ABREAST, LANES)).astype(np.float32)


@kernel()
def _totals(four):
    a, b, c, d = load_abreast(four, 0)
    return totals(a, b, c, d)


@kernel()
def _maximum(numbers):
    return maximum(load(numbers, 0))


@kernel()
def _split(texels, at, out):
    split_texels(texels, at, 3, out, LANES, 2 * LANES)


@kernel()
def _copied(texels, at, out):
    split_texels(texels, at, 1, out, LANES, 0)


@kernel()
def _joined(channels, at, out):
    store_texels(out, at, (load(channels, 0), load(channels, LANES), load(channels, 2 * LANES)))


@kernel()
def _transposed(four, out):
    store(out, 0, transposed(load_abreast(four, 0)))


@kernel()
def _folded(four, out):
    store(out, 0, folded(load_abreast(four, 0)))


@kernel()
def _added(four, out):
    add_fours(out, 2, 7, load(four, 0))


def test_totals_are_sums_each_of_its_own_vector():
    np.testing.assert_allclose(_totals(FOUR), FOUR.sum(axis=1), rtol=1e-5)


@pytest.mark.parametrize("at", range(LANES))
def test_the_largest_number_is_found_in_every_place(at):
    numbers = np.roll(np.arange(LANES, dtype=np.float32), at)
    assert _maximum(numbers) == LANES - 1


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_texels_come_apart_into_channels(dtype):
    texels = (200 * np.random.default_rng(1).random((2, 20, 3))).astype(dtype)
    out = np.zeros((6, LANES), dtype)
    _split(texels, 3 * 21, out)
    np.testing.assert_array_equal(out[1::2], texels[1, 1 : 1 + LANES].T)
    assert not out[::2].any()


def test_texels_of_one_channel_are_copied():
    texels, out = np.arange(40, dtype=np.uint8), np.zeros((3, LANES), np.uint8)
    _copied(texels, 21, out)
    np.testing.assert_array_equal(out[1], texels[21 : 21 + LANES])
    assert not out[::2].any()


def test_channels_become_texels_again():
    out = np.zeros((2, 20, 3), np.float32)
    _joined(FOUR[:3], 3 * 21, out)
    np.testing.assert_array_equal(out[1, 1 : 1 + LANES], FOUR[:3].T)
    assert not out[0].any()


def test_squares_of_four_are_turned_over():
    out = np.zeros_like(FOUR)
    _transposed(FOUR, out)
    np.testing.assert_array_equal(out.reshape(4, -1, 4), FOUR.reshape(4, -1, 4).transpose(2, 1, 0))


def test_folding_sums_every_fourth_number():
    out = np.zeros(LANES, np.float32)
    _folded(FOUR, out)
    np.testing.assert_allclose(out.reshape(4, 4), FOUR.reshape(4, -1, 4).sum(axis=1).T, rtol=1e-5)


def test_fours_are_added_to_rows():
    out = np.ones((4, 7), np.float32)
    _added(FOUR, out)
    np.testing.assert_allclose(out[:, 2:6], 1 + FOUR[0].reshape(4, 4), rtol=1e-6)
    assert (out[:, :2] == 1).all()
    assert (out[:, 6:] == 1).all()
