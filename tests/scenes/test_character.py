import numpy as np
import pytest

from facezip import FaceZipError
from facezip.character.loading import load_character, save_character
from facezip.errors import ErrorCode
from scenes.character import Person, make_character
from scenes.face.expressions import EXPRESSIONS, expression_weights
from scenes.face.shapes import ARKIT_SHAPES


@pytest.fixture(scope="module")
def character():
    return make_character(resolution=128, expressions=3)


def test_it_is_a_character_that_saves_and_loads(character, tmp_path):
    save_character(character, tmp_path / "character")
    back = load_character(tmp_path / "character")
    assert {*back.expressions} == {*character.expressions}
    for name in character.expressions:
        np.testing.assert_array_equal(back.texture(name), character.texture(name))


def test_a_seed_makes_the_same_bytes_and_another_another_person(character):
    again, other = make_character(128, 3), make_character(128, 3, seed=1)
    np.testing.assert_array_equal(again.first.textures, character.first.textures)
    np.testing.assert_array_equal(again.meshes.vertices, character.meshes.vertices)
    assert np.abs(other.first.neutral.astype(int) - character.first.neutral).mean() > 3


def test_without_nuisances_the_scans_are_the_truth():
    character = make_character(128, 2, nuisances=0)
    person = Person.make(128)
    for name in character.expressions:
        truth = person.texture(EXPRESSIONS[name])
        np.testing.assert_array_equal(character.first.textures[character.index(name)], np.rint(truth * 255))


def test_twenty_expressions_have_names_and_use_known_shapes():
    assert len(EXPRESSIONS) == 20
    for weights in expression_weights(30, 0).values():
        assert {*weights} <= {*ARKIT_SHAPES}
    assert list(expression_weights(30, 0))[:20] == list(EXPRESSIONS)
    assert len(expression_weights(30, 0)) == 30


def test_the_mask_holds_the_face_and_what_expressions_change():
    character = make_character(256, 4, nuisances=0)
    assert 0.3 < character.first.mask.mean() < 0.7
    changed = np.abs(character.first.textures.astype(int) - character.first.neutral).max(axis=(0, 3)) > 2
    assert changed[character.first.mask > 0].mean() > 0.05
    assert changed[character.first.mask == 0].mean() < 0.01


@pytest.mark.parametrize(("resolution", "expressions"), [(32, 5), (10000, 5), (128, 1)])
def test_sizes_out_of_range_are_refused(resolution, expressions):
    with pytest.raises(FaceZipError, match="embedded character"):
        make_character(resolution, expressions)


@pytest.mark.parametrize("tiles", [(3, 1), (1, 3), (11, 1), (16, 1), (0, 1), (1, 0), (-2, 1)])
def test_tiles_are_equal_parts_with_numbers_of_their_own(tiles):
    """A tile's number has one digit for its column."""
    with pytest.raises(FaceZipError, match="columns and") as refusal:
        make_character(64, 2, tiles=tiles)
    assert refusal.value.code is ErrorCode.BAD_VALUE
