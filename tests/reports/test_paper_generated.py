"""Generated shapes against the truth: what the benchmark of rigging measures."""

from dataclasses import replace

import numpy as np
import pytest

from facezip.files.images import to_float
from reports.paper.generated import (
    PACKS,
    _intervals,
    _mean,
    figure_8,
    generate,
    geometry_errors,
    mean_errors,
    naive,
    neutral_of,
    texture_errors,
)
from reports.paper.strips import strips
from scenes.tiles import in_tiles
from tests.facezip.rigging.case import SHAPES, make_case


@pytest.fixture(scope="module")
def case():
    return make_case()


@pytest.fixture(scope="module")
def generated(case):
    return generate(case.scans, case.template, 0)


def test_every_method_is_measured_on_every_shape(generated):
    errors = texture_errors(generated, neutral_of(generated.scans))
    assert set(errors) == {"naive", *PACKS} == set(mean_errors(errors))
    assert all(tuple(one) == SHAPES for one in errors.values())


def test_a_method_has_no_error_to_itself(generated):
    errors = texture_errors(generated, generated.textures["ours"])
    assert max(errors["ours"].values()) == 0
    assert max(errors["naive"].values()) > 0


def test_naive_differences_give_the_scans_back(generated):
    """Equation (9) for textures: weighted sums of the naive shapes are the scans, where nothing is clipped."""
    neutral = to_float(generated.scans.first.neutral)
    shapes = np.stack([generated.textures["naive"](name, 1001) - neutral for name in SHAPES])
    free = ((shapes + neutral > 0) & (shapes + neutral < 1)).all(axis=0)
    again = neutral + np.tensordot(generated.rig.weights, shapes, 1)
    gap = np.abs(again - to_float(generated.scans.first.textures))[:, free]
    assert free.mean() > 0.2
    assert gap.max() < 1e-4


def test_geometry_is_measured_against_the_truth(generated, case):
    errors = geometry_errors(generated.rig, case.deltas)
    assert 0 < errors.ours < errors.transferred
    assert geometry_errors(generated.rig, generated.rig.deltas).ours == 0


def test_errors_are_over_all_tiles(generated):
    """Of a chart that is cut they are those of the whole: the naive sum knows of no tiles."""
    scans, rig = generated.scans, generated.rig
    cut = in_tiles(scans, 2, 1)
    whole, parts = (
        texture_errors(replace(generated, scans=one, textures={"naive": naive(one, SHAPES, rig)}), neutral_of(one))
        for one in (scans, cut)
    )
    assert parts["naive"] == pytest.approx(whole["naive"], rel=1e-6)


def test_a_strip_shows_the_tile_that_changes_most(generated):
    scans = in_tiles(generated.scans, 2, 1)
    neutral = neutral_of(scans)

    def changed(tile):
        return lambda shape, other: np.clip(neutral(shape, other) + np.float32(0.3 * (other == tile)), 0, 1)

    left, right = (strips(scans, {"one": changed(tile)}, ["a"])["a"] for tile in (1001, 1002))
    assert left != right


def test_figure_8_is_made_on_tiles(case):
    scans = in_tiles(case.scans, 2, 1)
    figure = figure_8(scans, case.template, 0, None)
    assert set(figure.pictures) <= set(SHAPES)
    assert figure.columns == ["naive", *PACKS]
    assert all(uri.startswith("data:image/webp") for uri in figure.pictures.values())


def test_several_persons_are_one_document_of_means_with_student_s_intervals():
    found = [{"ours": value, "clean": {"ours": 1.0, "rmse_per_shape": {"a": value}}} for value in (1.0, 2.0, 3.0)]
    assert _mean(found) == {"ours": 2.0, "clean": {"ours": 1.0, "rmse_per_shape": {"a": 2.0}}}
    # t for two degrees of freedom is 4.3027, the standard error 1 / √3.
    assert _intervals(found) == {"ours": pytest.approx(4.3027 / 3**0.5, rel=1e-4), "clean": {"ours": 0.0}}


def test_the_mean_of_an_infinite_condition_is_infinite():
    """Which a document says as null."""
    found = [{"ours": 1.0, "condition": None}, {"ours": 3.0, "condition": 2.0}]
    assert _mean(found) == {"ours": 2.0, "condition": None}
    assert _intervals(found)["condition"] is None
