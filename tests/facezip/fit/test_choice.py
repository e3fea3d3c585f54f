import pytest

from facezip import ErrorCode, FaceZipError, choose, compress
from facezip.fit.choice import Choice
from facezip.fit.settings import WEIGHT_SCALES
from facezip.pack.errors import mean_rmse, model_errors
from facezip.pack.quantise import dequantise, quantise
from tests.facezip.conftest import random_character


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
            back = dequantise(quantise(model), model.expressions, model.method, None)
            table[differences, scale] = mean_rmse(model_errors(person, back)), model.footprint.bytes_on_gpu
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
    with pytest.raises(FaceZipError, match="0.02 MB") as error:
        choose(person, budget_bytes=1000)
    assert error.value.code == ErrorCode.OUT_OF_REACH


def test_a_target_within_a_budget_that_does_not_reach_it(person):
    with pytest.raises(FaceZipError, match="best within reach"):
        choose(person, target_rmse=0.7, budget_bytes=26_000)


@pytest.mark.parametrize("limits", [{}, {"target_rmse": 0.0}, {"budget_bytes": -1.0}])
def test_limits_that_are_none_are_refused(person, limits):
    with pytest.raises(FaceZipError) as error:
        choose(person, **limits)
    assert error.value.code == ErrorCode.BAD_VALUE
