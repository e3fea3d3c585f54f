"""How good each method is on the embedded character, to a part in a thousand: no change of a fit moves it unseen."""

import pytest

from facezip.fit.methods import compress
from facezip.pack.measure import mean_rmse, model_errors
from facezip.pack.quantise import dequantise, quantise
from scenes.character import make_character

# Root mean square errors on the face in units of 0..255, by method, difference textures and side of the textures.
ERRORS = {
    ("refined", 4): {128: 0.9333, 256: 0.9435},
    ("refined", 8): {128: 0.5442, 256: 0.5593},
    ("paper", 4): {128: 2.0678, 256: 2.2754},
    ("paper-optimised", 4): {128: 2.0583, 256: 2.2119},
    ("paper-unpermuted", 4): {128: 2.6081, 256: 2.7201},
    ("pca", 4): {128: 1.8680, 256: 2.1726},
    ("pca", 8): {128: 1.0040, 256: 1.1830},
}


@pytest.fixture(scope="module", params=[128, 256])
def character(request):
    return make_character(request.param, expressions=12)


@pytest.mark.parametrize(("method", "differences"), ERRORS)
def test_error_of_what_a_pack_stores(character, method, differences):
    model = compress(character, method, differences=differences, masks=24, restarts=30)
    stored = dequantise(quantise(model), model.expressions, model.method, None)
    expected = ERRORS[method, differences][len(character.neutral)]
    assert mean_rmse(model_errors(character, stored)) == pytest.approx(expected, rel=1e-3)


def test_momentum_that_went_past_the_goal_is_forgotten():
    """The embedded character with one difference texture, where an alternation loses what the one before had gained."""
    character = make_character(192, expressions=12)
    assert mean_rmse(model_errors(character, compress(character, differences=1))) == pytest.approx(2.3954, rel=1e-3)
