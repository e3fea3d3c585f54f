"""Generated shapes against the truth: what the benchmark of rigging measures."""

import numpy as np
import pytest

from facezip.files.images import to_float
from reports.paper.generated import PACKS, generate, geometry_errors, mean_errors, texture_errors
from tests.facezip.rigging.case import SHAPES, make_case


@pytest.fixture(scope="module")
def case():
    return make_case()


@pytest.fixture(scope="module")
def generated(case):
    return generate(case.scans, case.template, 0)


def test_every_method_is_measured_on_every_shape(generated):
    errors = texture_errors(generated, lambda shape: to_float(generated.scans.first.neutral))
    assert set(errors) == {"naive", *PACKS} == set(mean_errors(errors))
    assert all(tuple(one) == SHAPES for one in errors.values())


def test_a_method_has_no_error_to_itself(generated):
    errors = texture_errors(generated, generated.textures["ours"])
    assert max(errors["ours"].values()) == 0
    assert max(errors["naive"].values()) > 0


def test_naive_differences_give_the_scans_back(generated):
    """Equation (9) for textures: weighted sums of the naive shapes are the scans, where nothing is clipped."""
    neutral = to_float(generated.scans.first.neutral)
    shapes = np.stack([generated.textures["naive"](name) - neutral for name in SHAPES])
    free = ((shapes + neutral > 0) & (shapes + neutral < 1)).all(axis=0)
    again = neutral + np.tensordot(generated.rig.weights, shapes, 1)
    gap = np.abs(again - to_float(generated.scans.first.textures))[:, free]
    assert free.mean() > 0.2
    assert gap.max() < 1e-4


def test_geometry_is_measured_against_the_truth(generated, case):
    errors = geometry_errors(generated.rig, case.deltas)
    assert 0 < errors["ours"] < errors["transferred"]
    assert geometry_errors(generated.rig, generated.rig.deltas)["ours"] == 0
