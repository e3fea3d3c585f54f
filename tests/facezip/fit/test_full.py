"""The fit of all beside an extension uses no mask and no layer that the pack leaves unused."""

from dataclasses import replace
from pathlib import Path

import pytest

from facezip import compress
from facezip.fit.full import full_fit_errors
from facezip.pack.masked import MaskedWeights
from tests.facezip.conftest import random_character
from tests.test_extend_command import some


@pytest.fixture(scope="module")
def scans():
    return random_character(side=36, expressions=6)


@pytest.fixture(scope="module")
def model(scans):
    return compress(some(scans, 0, 1, 2, 3), "masks", masks=6, differences=3)


def without(model, masks=(), layers=()):
    masked = model.masked
    activations = masked.activations.copy()
    activations[:, [*masks]] = 0
    activations[..., [*layers]] = 0
    return replace(model, weights=MaskedWeights(masked.names, masked.masks, activations))


def errors(model, scans):
    return full_fit_errors(Path("a.facezip"), model, scans, some(scans, 4, 5), False, {})


def test_a_mask_that_is_not_used_changes_nothing(model, scans):
    unused = without(model, masks=[1, 4])
    masked = unused.masked
    rest = [0, 2, 3, 5]
    names = tuple(masked.names[k] for k in rest)
    fewer = MaskedWeights(
        names, {tile: masks[rest] for tile, masks in masked.masks.items()}, masked.activations[:, rest]
    )
    assert errors(unused, scans) == errors(replace(unused, weights=fewer), scans)


@pytest.mark.parametrize("layer", [0, 2])
def test_a_layer_that_is_not_used_leaves_the_others(model, scans, layer):
    assert errors(without(model, layers=[layer]), scans)["albedo"].rmse > errors(model, scans)["albedo"].rmse
