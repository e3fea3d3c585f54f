from math import radians, sqrt

import numpy as np
import pytest

from facezip import ErrorCode, FaceZipError, choose, compress
from facezip.character.loading import save_character
from facezip.character.maps import KNOWN
from facezip.fit.choice import Choice, whole_error
from facezip.fit.pipeline import Request, compress_into
from facezip.pack.errors import MapErrors, albedo_errors, mean_rmse, model_errors, texture_errors
from facezip.pack.footprint import WEIGHT_SCALES
from facezip.pack.quantise import quantise
from tests.facezip.conftest import random_character
from tests.facezip.surfaces import random_surface


@pytest.fixture(scope="module")
def person():
    return random_character(side=64, expressions=6)


@pytest.fixture(scope="module")
def every(person):
    """Error and memory of every combination there is."""
    table = {}
    for differences in range(1, 7):
        for scale in WEIGHT_SCALES:
            model = compress(person, differences=differences, weight_scale=scale)
            error = mean_rmse(albedo_errors(person, quantise(model)))
            table[differences, scale] = error, model.footprint.bytes_on_gpu
    return table


def settings(choice: Choice):
    return choice.trial.differences, choice.trial.weight_scale


@pytest.mark.parametrize("quantile", [0.2, 0.5, 0.8])
def test_a_target_is_met_with_the_least_memory_of_all(person, every, quantile):
    errors = sorted(error for error, _ in every.values())
    target = errors[int(quantile * len(errors))]
    choice = choose(person, target_rmse=target)
    assert choice.trial.rmse <= target
    assert choice.trial.bytes_on_gpu == min(cost for error, cost in every.values() if error <= target)
    assert choice.trial.rmse == pytest.approx(every[settings(choice)][0])
    assert len(choice.tried) <= 6 + len(WEIGHT_SCALES)


@pytest.mark.parametrize("quantile", [0.1, 0.5, 0.9])
def test_a_budget_gets_the_least_error_of_all(person, every, quantile):
    costs = sorted(cost for _, cost in every.values())
    budget = costs[int(quantile * len(costs))]
    choice = choose(person, budget_bytes=budget)
    assert choice.trial.bytes_on_gpu <= budget
    assert choice.trial.rmse == pytest.approx(min(error for error, cost in every.values() if cost <= budget))


def test_the_model_is_the_one_that_the_choice_describes(person, every):
    choice = choose(person, budget_bytes=60_000)
    assert choice.model.footprint.bytes_on_gpu == choice.trial.bytes_on_gpu
    assert every[settings(choice)][0] == pytest.approx(choice.trial.rmse)
    assert str(choice.trial.differences) in choice.reason


def test_a_target_out_of_reach_names_the_best_there_is(person, every):
    with pytest.raises(FaceZipError, match=f"{every[6, 4][0]:.3f}") as error:
        choose(person, target_rmse=1e-3)
    assert error.value.code == ErrorCode.OUT_OF_REACH


def test_a_budget_below_the_least_names_the_least(person, every):
    least = min(cost for _, cost in every.values())
    with pytest.raises(FaceZipError) as error:
        choose(person, budget_bytes=1000)
    assert error.value.code == ErrorCode.OUT_OF_REACH
    assert f"budget of 0.001 MB: the least is {least / 1e6:.3g} MB" in str(error.value)


def test_a_target_within_a_budget_that_does_not_reach_it(person):
    with pytest.raises(FaceZipError, match="best within reach"):
        choose(person, target_rmse=0.7, budget_bytes=26_000)


@pytest.mark.parametrize(
    ("limits", "words"),
    [
        ({}, "neither a target nor a budget"),
        ({"target_rmse": 0.0}, "target RMSE 0: "),
        ({"target_rmse": 1.0, "budget_bytes": -1.0}, "budget -1: "),
        ({"target_rmse": 1.0, "budget_bytes": float("nan")}, "budget nan: "),
    ],
)
def test_limits_that_are_none_are_refused_by_name(person, limits, words):
    with pytest.raises(FaceZipError, match=words) as error:
        choose(person, **limits)
    assert error.value.code == ErrorCode.BAD_VALUE


@pytest.fixture(scope="module")
def surface():
    """Albedo, normals and roughness on two tiles."""
    return random_surface(side=64, expressions=4, tiles=(2, 1))


WEIGHTS = {"normal": 3.0, "roughness": 0.5}


@pytest.fixture(scope="module")
def all_of_it(surface):
    """Error over all maps and memory of every combination there is, where normals count most."""
    table = {}
    for differences in range(1, 5):
        for scale in WEIGHT_SCALES:
            model = compress(surface, differences=differences, weight_scale=scale, map_weights=WEIGHTS)
            error = whole_error(model_errors(surface, quantise(model)), WEIGHTS)
            table[differences, scale] = error, model.footprint.bytes_on_gpu
    return table


@pytest.mark.parametrize("quantile", [0.2, 0.6])
def test_a_target_is_one_of_all_maps_and_tiles(surface, all_of_it, quantile):
    target = sorted(error for error, _ in all_of_it.values())[int(quantile * len(all_of_it))]
    choice = choose(surface, target_rmse=target, map_weights=WEIGHTS)
    assert choice.trial.rmse <= target
    assert choice.trial.bytes_on_gpu == min(cost for error, cost in all_of_it.values() if error <= target)
    assert choice.trial.bytes_on_gpu == choice.model.footprint.bytes_on_gpu


@pytest.mark.parametrize("quantile", [0.3, 0.7])
def test_a_budget_is_one_of_all_maps_and_tiles(surface, all_of_it, quantile):
    budget = sorted(cost for _, cost in all_of_it.values())[int(quantile * len(all_of_it))]
    choice = choose(surface, budget_bytes=budget, map_weights=WEIGHTS)
    least = min(error for error, cost in all_of_it.values() if cost <= budget)
    assert choice.trial.rmse == pytest.approx(least)
    assert choice.model.footprint.bytes_on_gpu == choice.trial.bytes_on_gpu <= budget


def test_what_counts_more_has_less_of_the_error(surface):
    """Of the same memory: where normals count for nearly nothing, theirs is larger."""
    budget = compress(surface, differences=2).footprint.bytes_on_gpu
    errors = []
    for weight in (1e-3, 1e3):
        model = choose(surface, budget_bytes=budget, map_weights={"normal": weight}).model
        errors.append(model_errors(surface, model)["normal"].angular_error_rms)
    assert errors[1] < 0.9 * errors[0]


def test_the_error_of_one_map_is_its_own_whatever_its_weight(person):
    errors = model_errors(person, compress(person, differences=2))
    assert whole_error(errors, {"albedo": 7.0}) == pytest.approx(errors["albedo"].rmse)


def test_the_error_of_all_maps_is_their_weighted_mean_square():
    errors = {
        "albedo": MapErrors(rmse=1.0),
        "roughness": MapErrors(rmse=3.0),
        "normal": MapErrors(angular_error=0.9, angular_error_rms=1.0),
    }
    normal = radians(1) * 255 / (2 * sqrt(3))
    assert whole_error(errors, {}) == pytest.approx(sqrt((1 + 9 + normal**2) / 3))
    assert whole_error(errors, {"roughness": 2.0}) == pytest.approx(sqrt((1 + 2 * 9 + normal**2) / 4))


def test_small_angles_count_as_the_bytes_of_a_normal_map(surface):
    """An image (n + 1) / 2 that is off by an angle is off by so much, in the root mean square of its channels."""
    kind, rng = KNOWN["normal"], np.random.default_rng(0)
    slopes = surface.only("normal")

    def moved(name, key):
        texels = slopes.texels(name, key)
        return (texels + rng.normal(0, 60, texels.shape)).astype(np.uint16)

    texels = {(name, key): moved(name, key) for name in slopes.expressions for key in slopes.stacks}
    errors = texture_errors(slopes, lambda name, key: texels[name, key])
    squares = [
        np.mean((kind.decode(some) - kind.decode(slopes.texels(*place))) ** 2) * (255 / 2) ** 2
        for place, some in texels.items()
    ]
    assert whole_error(errors, {}) == pytest.approx(sqrt(np.mean(squares)), rel=1e-3)


def test_a_pack_says_what_was_chosen_and_keeps_to_the_target(surface, tmp_path):
    save_character(surface, tmp_path / "scans")
    request = Request(target_rmse=6.0, map_weights=WEIGHTS)
    document = compress_into(tmp_path / "scans", tmp_path / "a.facezip", request)
    chosen = document.differences, document.weight_scale, document.bytes_on_gpu
    assert whole_error(document.errors, WEIGHTS) <= 6.0
    tried = document.choice.tried
    assert chosen in [(trial.differences, trial.weight_scale, trial.bytes_on_gpu) for trial in tried]
    assert document.made_with["target_rmse"] == 6.0
    assert document.made_with["map_weights"] == WEIGHTS
