"""Vectors that are written as such do what arithmetic on arrays does, number by number."""

import numpy as np
import pytest

from facezip.machine import vectors
from facezip.machine.kernels import kernel
from facezip.machine.vectors import (
    LANES,
    all_of,
    clipped,
    load,
    load_texels,
    minus,
    minus_product,
    plus,
    plus_product,
    reciprocal_root,
    store,
    times,
    totals,
)

A, B, C, D = np.random.default_rng(0).normal(size=(4, LANES)).astype(np.float32)


@kernel()
def _written(a, b, c, out):
    x, y, z = load(a, 0), load(b, 0), load(c, 0)
    store(out, 0, plus(x, y))
    store(out, LANES, minus(x, y))
    store(out, 2 * LANES, times(x, y))
    store(out, 3 * LANES, plus_product(z, x, y))
    store(out, 4 * LANES, minus_product(z, x, y))
    store(out, 5 * LANES, clipped(x))
    store(out, 6 * LANES, reciprocal_root(x, all_of(np.float32(0.5))))


@kernel()
def _totals(a, b, c, d):
    return totals(load(a, 0), load(b, 0), load(c, 0), load(d, 0))


@kernel()
def _spread(texels, at, out):
    found = load_texels(texels, at)
    for c in range(3):
        store(out, c * LANES, found[c])


def test_every_operation_is_that_of_arrays():
    out = np.zeros((7, LANES), np.float32)
    _written(A, B, C, out)
    root = 1 / np.sqrt(np.maximum(A, 0.5))
    expected = [A + B, A - B, A * B, C + A * B, C - A * B, np.clip(A, 0, 1), root]
    np.testing.assert_allclose(out, expected, rtol=1e-5, atol=1e-6)


def test_totals_are_sums_each_of_its_own_vector():
    np.testing.assert_allclose(_totals(A, B, C, D), [part.sum() for part in (A, B, C, D)], rtol=1e-5)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_texels_come_apart_into_channels(dtype):
    texels = (200 * np.random.default_rng(1).random((2, 20, 3))).astype(dtype)
    out = np.zeros((3, LANES), np.float32)
    _spread(texels, 3 * 21, out)
    np.testing.assert_array_equal(out, texels[1, 1 : 1 + LANES].T)


def test_lanes_are_a_multiple_of_what_is_taken_abreast():
    assert LANES % vectors.ABREAST == 0
