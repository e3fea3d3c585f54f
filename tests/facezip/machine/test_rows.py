import numpy as np
import pytest

from facezip import compress
from facezip.fit.methods import METHODS
from facezip.machine.rows import map_rows, sum_rows
from tests.facezip.conftest import part_of, random_character, weights_of


@pytest.mark.parametrize("height", [1, 31, 32, 33, 100])
def test_every_row_is_worked_once_and_in_order(height):
    seen = [y for block in map_rows(lambda top, bottom: list(range(top, bottom)), height) for y in block]
    assert seen == list(range(height))


def test_a_sum_over_rows_is_the_sum_of_its_blocks():
    values = np.random.default_rng(0).random((100, 3))
    total = sum_rows(lambda top, bottom: values[top:bottom].sum(axis=0), 100)
    np.testing.assert_allclose(total, values.sum(axis=0))


def test_a_failure_in_a_block_reaches_the_caller():
    with pytest.raises(ZeroDivisionError):
        map_rows(lambda top, bottom: 1 // (top - 32), 100)


@pytest.mark.parametrize("method", METHODS)
def test_results_do_not_depend_on_the_number_of_cores(method, monkeypatch):
    character = random_character(side=70)
    models = []
    for cores in (1, 5):
        monkeypatch.setattr("facezip.machine.cores._share", cores)
        models.append(compress(character, method, masks=9, restarts=3))
    np.testing.assert_array_equal(*(part_of(model).differences for model in models))
    np.testing.assert_array_equal(*map(weights_of, models))
