"""A few layers an expression: no more are used, and each that is left out costs something."""

import numpy as np
import pytest

from facezip import compress
from facezip.errors import ErrorCode, FaceZipError
from facezip.fit.settings import Settings, made_with
from facezip.pack.errors import albedo_errors, mean_rmse
from facezip.pack.quantise import quantise
from tests.facezip.conftest import random_character, weights_of
from tests.facezip.surfaces import random_surface

SCANS = random_character(side=64, expressions=6)


def fitted(**options):
    return compress(SCANS, differences=3, **options)


@pytest.mark.parametrize("nonnegative", [False, True])
@pytest.mark.parametrize("sparse", [1, 2])
def test_no_expression_uses_more_than_it_may(sparse, nonnegative):
    """What 8 bits make of a zero is far below the smallest weight that matters."""
    weights = weights_of(fitted(sparse=sparse, nonnegative=nonnegative))
    span = weights.max(axis=(0, 1, 2)) - weights.min(axis=(0, 1, 2))
    most = np.abs(weights).max(axis=(1, 2)) / span
    assert ((most > 1 / 255).sum(axis=1) <= sparse).all()
    assert ((most > 1 / 255).sum(axis=1) >= 1).all()
    if nonnegative:
        assert weights.min() >= 0


def test_each_layer_that_is_left_out_costs_something_but_less_than_for_all():
    errors = [mean_rmse(albedo_errors(SCANS, quantise(fitted(sparse=sparse)))) for sparse in (None, 2, 1)]
    assert errors == sorted(errors)
    for sparse, error in ((2, errors[1]), (1, errors[2])):
        fewer = quantise(compress(SCANS, differences=sparse))
        assert error < mean_rmse(albedo_errors(SCANS, fewer))


def test_as_many_as_there_are_changes_nothing():
    np.testing.assert_array_equal(weights_of(fitted(sparse=3)), weights_of(fitted()))


def test_it_holds_on_every_tile():
    model = compress(random_surface(expressions=5, tiles=(2, 1)), differences=3, sparse=1)
    for tile in model.tiles:
        weights = model.weights[tile]
        span = weights.max(axis=(0, 1, 2)) - weights.min(axis=(0, 1, 2))
        assert ((np.abs(weights).max(axis=(1, 2)) / np.maximum(span, 1e-12) > 1 / 255).sum(axis=1) <= 1).all()


@pytest.mark.parametrize(("method", "sparse"), [("refined", 0), ("refined", 5), ("pca", 2), ("masks", 2)])
def test_what_cannot_be_is_refused(method, sparse):
    with pytest.raises(FaceZipError, match="sparse") as caught:
        compress(SCANS, method, sparse=sparse)
    assert caught.value.code is ErrorCode.BAD_VALUE


def test_a_pack_says_so_only_where_it_is_asked_for():
    assert "sparse" not in made_with("refined", vars(Settings()))
    assert made_with("refined", vars(Settings(sparse=2)))["sparse"] == 2
