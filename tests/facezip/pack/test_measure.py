from dataclasses import replace

import numpy as np
import pytest

from facezip import compress
from facezip.pack.errors import mean_rmse, model_errors, pack_errors, texture_errors
from facezip.pack.read import read_pack
from facezip.pack.write import write_pack
from tests.facezip.conftest import principal_components, random_character, refine


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_a_character_has_no_error_against_itself(dtype):
    character = random_character(dtype=dtype)
    assert set(texture_errors(character, character.texture).values()) == {0.0}


def test_errors_are_root_mean_squares_in_grey_levels(character):
    other = np.random.default_rng(0).random((32, 32, 3)).astype(np.float32)
    errors = texture_errors(character, lambda name: other)
    for name in character.expressions:
        expected = 255 * np.sqrt(np.mean((character.texture(name) - other) ** 2))
        assert errors[name] == pytest.approx(expected, rel=1e-5)


def test_texels_count_by_their_mask(character):
    mask = np.random.default_rng(1).random((32, 32)).astype(np.float32)
    error = texture_errors(replace(character, mask=mask), lambda name: character.texture("neutral"))["expr_1"]
    squared = ((character.texture("expr_1") - character.texture("neutral")) ** 2).mean(axis=2)
    assert error == pytest.approx(255 * np.sqrt(np.average(squared, weights=mask)), rel=1e-5)


def test_one_grey_level_everywhere_is_an_error_of_one(character):
    errors = texture_errors(character, lambda name: character.texture(name) + np.float32(1 / 255))
    assert mean_rmse(errors) == pytest.approx(1, rel=1e-4)


def test_the_mean_is_over_expressions():
    assert mean_rmse({"a": 1.0, "b": 4.0}) == 2.5


def test_errors_of_a_model_are_those_of_its_reconstructions():
    character = random_character(side=70, expressions=5)
    mask = np.random.default_rng(2).random(character.first.resolution).astype(np.float32)
    character = replace(character, mask=mask)
    for model in (principal_components(character, 2), refine(character, 3, 8)):
        whole, fused = texture_errors(character, model.reconstruct), model_errors(character, model)
        assert fused == pytest.approx(whole, rel=1e-5)


@pytest.mark.parametrize(("method", "dtype"), [("refined", np.uint8), ("pca", np.uint16)])
def test_errors_of_a_pack_are_those_of_the_model_that_it_gives_back(method, dtype, tmp_path):
    character = random_character(side=70, expressions=5, dtype=dtype)
    write_pack(
        compress(character, method, differences=3), tmp_path / "pack", neutral_bits=8 * character.first.neutral.itemsize
    )
    read_back = model_errors(character, read_pack(tmp_path / "pack"))
    assert pack_errors(character, tmp_path / "pack") == pytest.approx(read_back, rel=1e-5)
