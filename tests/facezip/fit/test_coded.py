from dataclasses import replace

import numpy as np
import pytest

from facezip.blocks.codecs import astc, bc7, raw
from facezip.fit.coded import coded_afterwards, fit_coded
from facezip.fit.methods import compress
from facezip.fit.storage import Storage
from facezip.pack.errors import mean_rmse, texture_errors
from facezip.pack.quantise import quantise
from tests.facezip.conftest import random_character, random_model

ASTC = Storage(astc((6, 6), "fast"), weights_in_bc4=True)


@pytest.fixture(scope="module")
def character():
    return random_character(seed=4, expressions=9, side=48)


def rmse(character, model):
    return mean_rmse(texture_errors(character, model.reconstruct))


@pytest.mark.parametrize("block", [(4, 4), (8, 8)])
def test_a_fit_with_the_codec_in_the_loop_beats_coding_afterwards(character, block):
    storage = Storage(astc(block, "fast"), weights_in_bc4=True)
    after = Storage(astc(block, "fast"))
    refined = compress(character, method="refined", differences=3, weight_scale=4)
    assert rmse(character, fit_coded(character, 3, 4, storage)) < 0.9 * rmse(
        character, coded_afterwards(refined, after)
    )


def test_it_is_the_same_every_time(character):
    one, other = fit_coded(character, 2, 4, ASTC), fit_coded(character, 2, 4, ASTC)
    np.testing.assert_array_equal(one.differences, other.differences)
    np.testing.assert_array_equal(one.weights, other.weights)


def test_no_more_differences_than_expressions(character):
    few = replace(character, expressions=character.expressions[:2], textures=character.first.textures[:2])
    assert len(fit_coded(few, 4, 8, ASTC).differences) == 2


def test_raw_storage_is_that_of_a_pack():
    model = random_model()
    maps = quantise(model)
    stored = coded_afterwards(model, Storage(raw(3)))
    steps = (maps.difference_scale / 255)[:, None, None]
    np.testing.assert_allclose(stored.differences, (maps.differences.astype(np.float32) - 128) * steps, atol=1e-6)
    np.testing.assert_allclose(stored.neutral, maps.neutral / 255, atol=1e-7)


def test_bytes_are_those_of_all_maps():
    model = random_model(size=(24, 40), weights=(3, 5), slots=5, expressions=3)
    assert Storage(raw(3)).bytes_of(model) == 6 * 24 * 40 * 3 + 3 * 15 * 8
    assert Storage(bc7(), weights_in_bc4=True).bytes_of(model) == 6 * 24 * 40 + 3 * 5 * 2 * 8
    uniform = replace(model, weights=model.weights[:, :1, :1])
    assert Storage(raw(3)).bytes_of(uniform) == 6 * 24 * 40 * 3
