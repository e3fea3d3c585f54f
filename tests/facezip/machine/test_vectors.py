"""Vectors that are written as such do what arithmetic on arrays does, number by number."""

import numpy as np
import pytest

from facezip.machine.kernels import kernel
from facezip.machine.vectors import (
    ABREAST,
    LANES,
    all_at,
    all_of,
    clipped,
    larger,
    load,
    load_abreast,
    minus,
    minus_product,
    plus,
    plus_product,
    reciprocal_root,
    room,
    store,
    times,
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
def _abreast(a, b, factor, out):
    four = load_abreast(a, 0)
    store(out, 0, plus_product(four, all_at(factor, 1), load_abreast(b, 0)))
    store(out, ABREAST * LANES, (larger(four[1], four[3]), load(b, 0)))


@kernel()
def _aligned(count):
    return room(count).ctypes.data % (4 * LANES)


@kernel()
def _loaded(numbers, at, out):
    store(out, 0, load(numbers, at))


def test_every_operation_is_that_of_arrays():
    out = np.zeros((7, LANES), np.float32)
    _written(A, B, C, out)
    root = 1 / np.sqrt(np.maximum(A, 0.5))
    expected = [A + B, A - B, A * B, C + A * B, C - A * B, np.clip(A, 0, 1), root]
    np.testing.assert_allclose(out, expected, rtol=1e-5, atol=1e-6)


def test_tuples_of_vectors_are_as_many_vectors():
    a, b = np.random.default_rng(2).normal(size=(2, ABREAST, LANES)).astype(np.float32)
    out = np.zeros((ABREAST + 2, LANES), np.float32)
    _abreast(a, b, np.float32([7, 3]), out)
    expected = [*(a + 3 * b), np.maximum(a[1], a[3]), b[0]]
    np.testing.assert_allclose(out, expected, rtol=1e-5, atol=1e-6)


def test_room_begins_with_a_line_of_the_cache():
    assert [_aligned(count) for count in range(1, 9)] == [0] * 8


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_numbers_of_every_type_become_floats(dtype):
    numbers = (250 * np.random.default_rng(1).random(40)).astype(dtype)
    out = np.zeros(LANES, np.float32)
    _loaded(numbers, 21, out)
    np.testing.assert_array_equal(out, numbers[21 : 21 + LANES])
