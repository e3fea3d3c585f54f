"""How good each method is on the embedded character, to a part in a thousand: no change of a fit moves it unseen."""

import pytest

from facezip.fit.methods import compress
from facezip.pack.quantise import quantise
from scenes.character import make_character
from tests.facezip.conftest import rmse

# Root mean square errors on the face in units of 0..255, by method, difference textures and side of the textures.
ERRORS = {
    ("refined", 4): {128: 0.9500, 256: 0.9592},
    ("refined", 8): {128: 0.5517, 256: 0.5576},
    ("paper", 4): {128: 2.1277, 256: 2.2922},
    ("paper-optimised", 4): {128: 2.0757, 256: 2.2754},
    ("paper-unpermuted", 4): {128: 2.7480, 256: 2.8514},
    ("pca", 4): {128: 1.9257, 256: 2.2029},
    ("pca", 8): {128: 1.0033, 256: 1.1727},
}


@pytest.fixture(scope="module", params=[128, 256])
def character(request):
    return make_character(request.param, expressions=12)


@pytest.mark.parametrize(("method", "differences"), ERRORS)
def test_error_of_what_a_pack_stores(character, method, differences):
    model = compress(character, method, differences=differences, masks=24, restarts=30)
    expected = ERRORS[method, differences][character.first.resolution[0]]
    assert rmse(character, quantise(model)) == pytest.approx(expected, rel=1e-3)
