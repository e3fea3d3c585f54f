"""A character at several texture sizes: halves are means, nothing is enlarged."""

from dataclasses import replace

import numpy as np
import pytest

from facezip.character.scans import Stack
from facezip.errors import ErrorCode, FaceZipError
from reports.paper.sizes import at_widths, halved, reduced, widths_of
from scenes.tiles import in_tiles
from tests.facezip.conftest import random_character, with_albedo


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_a_texel_of_the_half_is_the_mean_of_four(dtype):
    character = random_character(side=32, dtype=dtype)
    small = halved(character)
    corner = character.first.textures[:, :2, 2:4].astype(np.float64).mean(axis=(1, 2))
    assert small.first.textures.dtype == dtype
    assert small.first.resolution == (16, 16)
    np.testing.assert_allclose(small.first.textures[:, 0, 1], corner, atol=1e-6 if dtype == np.float32 else 0.5)


def test_the_mask_is_halved_with_the_textures_and_the_meshes_stay():
    mask = np.zeros((32, 32), np.float32)
    mask[:, :15] = 1
    character = with_albedo(random_character(side=32), mask=mask)
    small = halved(character)
    np.testing.assert_array_equal(small.first.mask[0, 6:9], [1, 0.5, 0])
    assert small.meshes is character.meshes


def test_sizes_are_the_own_one_and_its_halves_down_to_256():
    assert widths_of(random_character(side=1024, expressions=2)) == [1024, 512, 256]
    assert widths_of(random_character(side=64)) == [64]
    assert widths_of(random_character(side=600, expressions=2)) == [600, 300]


def test_wanted_sizes_come_largest_first_and_may_be_small():
    character = random_character(side=64)
    assert widths_of(character, [16, 64]) == [64, 16]
    sizes = list(at_widths(character, [64, 16]))
    assert sizes[0] is character
    np.testing.assert_array_equal(sizes[1].first.textures, halved(halved(character)).first.textures)


@pytest.mark.parametrize("width", [128, 48, 0])
def test_a_size_that_halving_does_not_reach_is_refused(width):
    with pytest.raises(FaceZipError, match=f"--resolution {width}: .*choose from 64") as caught:
        widths_of(random_character(side=64), [width])
    assert caught.value.code is ErrorCode.BAD_VALUE


def test_reducing_stops_at_the_limit_or_at_an_odd_side():
    assert reduced(random_character(side=64), 20).first.resolution == (16, 16)
    assert reduced(random_character(side=36), 8).first.resolution == (9, 9)
    character = random_character(side=16)
    assert reduced(character, 16) is character


def test_all_tiles_are_halved_as_long_as_every_side_of_them_is_even():
    tiled = in_tiles(random_character(side=64, expressions=2), 2, 1)
    assert [stack.resolution for stack in reduced(tiled, 16).stacks.values()] == [(16, 8), (16, 8)]
    odd = np.zeros((2, 12, 12, 3), np.uint8)
    other = replace(tiled, stacks={**tiled.stacks, ("albedo", 1002): Stack(odd[0], odd)})
    assert [stack.resolution for stack in reduced(other, 1).stacks.values()] == [(16, 8), (3, 3)]
    assert widths_of(tiled, [32, 16]) == [32, 16]
