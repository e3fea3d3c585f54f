import numpy as np
import pytest

from facezip import ErrorCode, FaceZipError, compress
from facezip.character.scans import Stack
from facezip.fit.methods import METHODS
from facezip.fit.settings import made_with
from facezip.pack.errors import texture_errors
from tests.facezip.conftest import one_albedo, part_of, random_character, rmse, weights_of, with_albedo


def assert_same(one, other):
    np.testing.assert_array_equal(part_of(one).differences, part_of(other).differences)
    np.testing.assert_array_equal(weights_of(one), weights_of(other))


def small(character, method, **settings):
    return compress(character, method, **{"masks": 9, "restarts": 10, **settings})


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("channels", [1, 3, 4])
def test_every_method_takes_any_number_of_channels(method, channels):
    stack = random_character().first
    character = one_albedo(
        Stack(np.resize(stack.neutral, (32, 32, channels)), np.resize(stack.textures, (5, 32, 32, channels)))
    )
    model = small(character, method)
    assert model.reconstruct("expr_1").shape == (32, 32, channels)


@pytest.mark.parametrize("method", METHODS)
def test_every_method_beats_the_neutral_alone(method, character):
    neutral = texture_errors(character, lambda _, key: character.stacks[key].neutral)
    assert rmse(character, small(character, method)) < 0.7 * neutral["albedo"].rmse


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("expressions", [2, 3])
def test_fewer_expressions_than_textures(method, expressions):
    character = random_character(expressions=expressions)
    model = small(character, method)
    assert len(part_of(model).differences) == expressions
    assert np.isfinite(model.reconstruct("expr_1")).all()


@pytest.mark.parametrize("method", METHODS)
def test_expressions_equal_to_the_neutral_stay_neutral(method, character):
    still = with_albedo(character, textures=np.stack(5 * [character.first.neutral]))
    np.testing.assert_array_equal(small(still, method).reconstruct("expr_3"), still.texture("neutral"))


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("size", [(20, 31), (7, 5)])
def test_sizes_need_not_divide(method, size):
    character = random_character()
    height, width = size
    cropped = with_albedo(
        character,
        neutral=character.first.neutral[:height, :width].copy(),
        textures=character.first.textures[:, :height, :width].copy(),
    )
    model = small(cropped, method)
    assert model.reconstruct("expr_0").shape == (height, width, 3)
    if method != "pca":
        assert weights_of(model).shape[1:3] == (-(-height // 8), -(-width // 8))


@pytest.mark.parametrize("method", METHODS)
def test_the_same_seed_gives_the_same_model(method, character):
    first, again = (small(character, method, seed=4) for _ in range(2))
    assert_same(first, again)


@pytest.mark.parametrize("method", METHODS)
def test_what_a_method_does_not_use_changes_nothing(method, character):
    given = {"differences": 4, "weight_scale": 8, "masks": 9, "restarts": 10, "seed": 4}
    others = {"differences": 3, "weight_scale": 16, "masks": 7, "restarts": 1, "seed": 5}
    plain = compress(character, method, **given)
    model = compress(character, **{**others, **made_with(method, given)})
    assert_same(model, plain)


def test_the_search_improves_on_no_permutation():
    character = random_character(seed=2, expressions=12, side=64, grid=15)
    errors = {method: rmse(character, small(character, method)) for method in METHODS}
    assert errors["paper"] < errors["paper-unpermuted"]
    assert errors["paper-optimised"] < errors["paper-unpermuted"]


@pytest.mark.parametrize(
    "settings",
    [
        {"differences": 0},
        {"differences": 9, "method": "pca"},
        {"differences": 3, "method": "paper"},
        {"weight_scale": 3},
        {"masks": 0},
        {"restarts": 0},
        {"seed": -1},
        {"method": "magic"},
    ],
    ids=str,
)
def test_settings_outside_their_range_are_refused(settings, character):
    with pytest.raises(FaceZipError) as refused:
        compress(character, **settings)
    assert refused.value.code is ErrorCode.BAD_VALUE


def test_a_model_carries_meshes_names_and_the_name_of_its_method(character):
    model = small(character, "pca")
    assert model.method == "pca"
    assert model.meshes is character.meshes
    assert model.expressions == character.expressions
