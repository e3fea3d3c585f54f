"""What more alternations are worth: less error; and what an effort is not."""

import pytest

from facezip.errors import FaceZipError
from facezip.fit.methods import compress
from facezip.fit.refine import alternations
from facezip.fit.settings import EFFORTS, Settings, made_with
from scenes.character import make_character
from tests.facezip.conftest import rmse


@pytest.fixture(scope="module")
def errors():
    character = make_character(128, expressions=8)
    return {effort: rmse(character, compress(character, effort=effort)) for effort in EFFORTS}


def test_more_effort_is_less_error(errors):
    assert errors["fast"] > errors["default"] > errors["best"]


def test_the_default_is_within_three_hundredths_of_the_best(errors):
    assert errors["default"] < 1.03 * errors["best"]


@pytest.mark.parametrize("side", [64, 512, 1024, 2048, 4096, 8192])
def test_more_effort_is_more_alternations(side):
    counts = [alternations(side * side, effort) for effort in EFFORTS]
    assert counts == sorted(set(counts))


def test_a_pack_says_what_is_not_as_ever():
    assert "effort" not in made_with("refined", {"effort": "default"})
    assert made_with("refined", {"effort": "best"})["effort"] == "best"


@pytest.mark.parametrize(("method", "effort"), [("refined", "utmost"), ("pca", "best")])
def test_others_are_refused(method, effort):
    with pytest.raises(FaceZipError, match="effort"):
        Settings(effort=effort).check(method)
