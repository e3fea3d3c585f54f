from dataclasses import replace

import numpy as np
import pytest

from facezip import compress
from facezip.documents.document import plain
from facezip.pack.errors import albedo_errors, mean_rmse, model_errors, pack_errors, rmse_per_expression, texture_errors
from facezip.pack.read import read_pack
from facezip.pack.write import write_pack
from scenes.tiles import in_tiles
from tests.facezip.conftest import principal_components, random_character, refine, with_albedo
from tests.facezip.surfaces import random_surface


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_a_character_has_no_error_against_itself(dtype):
    character = random_character(dtype=dtype)
    assert set(rmse_per_expression(texture_errors(character, character.texels)).values()) == {0.0}


def test_errors_are_root_mean_squares_in_grey_levels(character):
    other = np.random.default_rng(0).random((32, 32, 3)).astype(np.float32)
    errors = rmse_per_expression(texture_errors(character, lambda *_: other))
    for name in character.expressions:
        expected = 255 * np.sqrt(np.mean((character.texture(name) - other) ** 2))
        assert errors[name] == pytest.approx(expected, rel=1e-5)


def test_texels_count_by_their_mask(character):
    mask = np.random.default_rng(1).random((32, 32)).astype(np.float32)
    masked = with_albedo(character, mask=mask)
    error = rmse_per_expression(texture_errors(masked, lambda *_: character.first.neutral))["expr_1"]
    squared = ((character.texture("expr_1") - character.texture("neutral")) ** 2).mean(axis=2)
    assert error == pytest.approx(255 * np.sqrt(np.average(squared, weights=mask)), rel=1e-5)


def test_one_grey_level_everywhere_is_an_error_of_one(character):
    errors = texture_errors(character, lambda name, _: character.texture(name) + np.float32(1 / 255))
    assert errors["albedo"].rmse == pytest.approx(1, rel=1e-4)


def test_the_mean_is_over_expressions():
    assert mean_rmse({"a": 1.0, "b": 4.0}) == 2.5


def test_errors_of_a_model_are_those_of_its_reconstructions():
    character = random_character(side=70, expressions=5)
    mask = np.random.default_rng(2).random(character.first.resolution).astype(np.float32)
    character = with_albedo(character, mask=mask)
    for model in (principal_components(character, 2), refine(character, 3, 8)):
        whole = texture_errors(character, lambda name, key, model=model: model.texels({name: 1.0}, key))
        assert albedo_errors(character, model) == pytest.approx(rmse_per_expression(whole), rel=1e-5)


def test_errors_of_tiles_are_those_of_the_whole(surface):
    """Of textures that are not fitted: the neutral in the place of every expression."""

    def neutrals(character):
        return texture_errors(character, lambda _, key: character.stacks[key].neutral)

    whole, cut = neutrals(surface), neutrals(in_tiles(surface, 2, 2))
    for name, found in whole.items():
        for key, value in plain(found).items():
            assert plain(cut[name])[key] == pytest.approx(value, rel=1e-5)


def test_normals_are_measured_in_degrees(surface):
    turned = surface.kind("normal")
    flat = turned.encode(np.broadcast_to(np.array([0, 0, 1], np.float32), (64, 64, 3)))
    errors = texture_errors(surface.only("albedo", "normal"), lambda name, key: flat)["normal"]
    expected = [
        np.degrees(np.arccos(np.clip(surface.texture(name, "normal")[..., 2], -1, 1))).mean()
        for name in surface.expressions
    ]
    assert list(errors.angular_error_per_expression.values()) == pytest.approx(expected, rel=1e-3)


def test_a_tile_whose_mask_is_black_has_no_say(surface):
    cut = in_tiles(surface, 2, 1)
    blank = {key: replace(stack, mask=np.full(stack.resolution, key[1] == 1001, np.float32))
             for key, stack in cut.stacks.items()}  # fmt: skip
    half = replace(cut, stacks=blank)
    errors = texture_errors(
        half, lambda name, key: cut.texels(name, key) if key[1] == 1001 else cut.stacks[key].neutral
    )
    assert errors["albedo"].rmse == 0


@pytest.mark.parametrize(("method", "dtype"), [("refined", np.uint8), ("pca", np.uint16)])
def test_errors_of_a_pack_are_those_of_the_model_that_it_gives_back(method, dtype, tmp_path):
    character = random_character(side=70, expressions=5, dtype=dtype)
    write_pack(compress(character, method, differences=3), tmp_path / "pack")
    read_back = albedo_errors(character, read_pack(tmp_path / "pack"))
    found = rmse_per_expression(pack_errors(character, tmp_path / "pack"))
    assert found == pytest.approx(read_back, rel=1e-5)


def test_errors_of_a_pack_of_maps_and_tiles_are_those_of_its_model(tmp_path):
    character = random_surface(tiles=(2, 1))
    write_pack(compress(character), tmp_path / "pack")
    ours, theirs = pack_errors(character, tmp_path / "pack"), model_errors(character, read_pack(tmp_path / "pack"))
    for name in theirs:
        for key, value in plain(theirs[name]).items():
            assert plain(ours[name])[key] == pytest.approx(value, rel=1e-4)
