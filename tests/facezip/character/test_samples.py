import numpy as np
import pytest

from facezip.character.samples import samples_of, thinned
from facezip.errors import ErrorCode, FaceZipError


def test_importance_multiplies_the_mask(character):
    importance = np.random.default_rng(0).random(character.first.resolution).astype(np.float32)
    np.testing.assert_array_equal(samples_of(character.first, importance).importance, importance)


def test_thinning_by_one_keeps_every_texel(character):
    samples = samples_of(character.first)
    np.testing.assert_array_equal(thinned(samples, 1).textures, samples.textures)


def test_thinned_texels_are_texels_of_the_texture(character):
    samples = samples_of(character.first)
    few = thinned(samples, 4)
    np.testing.assert_array_equal(few.textures, samples.textures[:, 2::4, 2::4])


@pytest.mark.parametrize(
    ("value", "code"), [(-1.0, ErrorCode.BAD_TEXELS), (0.0, ErrorCode.BAD_TEXELS), (np.nan, ErrorCode.BAD_TEXELS)]
)
def test_an_importance_that_is_none_is_refused(character, value, code):
    with pytest.raises(FaceZipError) as error:
        samples_of(character.first, np.full(character.first.resolution, value, np.float32))
    assert error.value.code == code


def test_an_importance_of_another_size_is_refused(character):
    with pytest.raises(FaceZipError) as error:
        samples_of(character.first, np.ones((3, 4), np.float32))
    assert error.value.code == ErrorCode.SIZE_MISMATCH
