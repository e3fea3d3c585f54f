"""Laws of the joint fit: what it must not depend on, and what it must be equal to."""

from dataclasses import replace

import numpy as np
import pytest

from facezip import FaceZipError
from facezip.character.maps import KNOWN, Map
from facezip.character.samples import samples_of
from facezip.character.scans import Stack
from facezip.character.tiles import FIRST_TILE
from facezip.fit.methods import METHODS, compress
from facezip.fit.sweep import joint_system, solve_textures, weight_system
from facezip.pack.errors import model_errors
from facezip.pack.quantise import quantise
from scenes.tiles import in_tiles
from tests.facezip.conftest import random_character, weights_of
from tests.facezip.surfaces import random_surface

FEW = {"masks": 6, "restarts": 5}


def with_copy(character, change=lambda texels: texels):
    """The albedo, and the same texels, or changed ones, as another map."""
    copy = Stack(change(character.first.neutral), change(character.first.textures))
    stacks = {**character.stacks, ("copy", FIRST_TILE): copy}
    return replace(character, maps=(KNOWN["albedo"], Map("copy", "data")), stacks=stacks)


@pytest.mark.parametrize("method", METHODS)
def test_a_map_twice_is_fitted_as_once(method):
    character = random_character(side=64)
    both = compress(with_copy(character), method, **FEW)
    alone = compress(character, method, **FEW)
    np.testing.assert_allclose(weights_of(both), weights_of(alone), atol=2e-3)
    for name in ("albedo", "copy"):
        np.testing.assert_allclose(both.reconstruct("expr_1", name), alone.reconstruct("expr_1"), atol=4e-3)


def test_the_unit_of_a_map_changes_nothing():
    character = random_character(side=64, dtype=np.float32)
    one, half = (compress(with_copy(character, lambda t, s=s: t * np.float32(s))) for s in (1, 0.5))
    for name in half.expressions:
        assert np.abs(half.reconstruct(name) - one.reconstruct(name)).mean() < 5e-4


def test_joint_equations_are_the_sum_of_each_maps():
    maps = [samples_of(random_character(seed).first) for seed in (0, 1)]
    weights = np.random.default_rng(2).normal(size=(4, 2, 5, 4)).astype(np.float32)
    textures = [solve_textures(samples, weights) for samples in maps]
    joint, parts = joint_system(maps, weights, textures), [weight_system(samples, weights) for samples in maps]
    np.testing.assert_allclose(joint.matrix, parts[0].matrix + parts[1].matrix, rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(joint.right, parts[0].right + parts[1].right, rtol=1e-5, atol=1e-6)


def test_the_more_a_map_counts_the_better_it_is_fitted():
    surface = random_surface(expressions=8)
    found = []
    for weight in (0.05, 1, 20):
        model = compress(surface, differences=2, map_weights={"roughness": weight})
        errors = model_errors(surface, quantise(model))
        found.append((errors["roughness"].rmse, -errors["albedo"].rmse))
    assert found == sorted(found, reverse=True)


def test_no_shared_fit_of_a_map_beats_its_own(surface):
    shared = model_errors(surface, quantise(compress(surface, differences=2)))
    for kind in surface.maps:
        alone = surface.only(kind.name)
        own = model_errors(alone, quantise(compress(alone, differences=2)))
        assert own[kind.name].mean <= shared[kind.name].mean * 1.001


@pytest.mark.parametrize("method", ["paper", "pca"])
def test_cutting_the_chart_into_tiles_changes_no_texture_that_lives_on_the_mesh(surface, method):
    whole, cut = compress(surface, method, **FEW), compress(in_tiles(surface, 2, 2), method, **FEW)
    for kind in surface.maps:
        expected = whole.parts[kind.name, FIRST_TILE].differences
        for tile, rows, columns in ((1001, 1, 0), (1002, 1, 1), (1011, 0, 0), (1012, 0, 1)):
            part = expected[:, 32 * rows : 32 * rows + 32, 32 * columns : 32 * columns + 32]
            np.testing.assert_allclose(cut.parts[kind.name, tile].differences, part, atol=1e-4)


def test_refined_tiles_are_as_good_as_the_whole():
    surface = random_surface(side=128)
    errors = [
        model_errors(one, quantise(compress(one, differences=3)))["albedo"].rmse
        for one in (surface, in_tiles(surface, 2, 1))
    ]
    assert errors[1] < 1.05 * errors[0]


def test_maps_may_have_other_sizes_than_the_albedo(surface):
    finer = random_surface(side=128).stacks["roughness", FIRST_TILE]
    mixed = replace(surface, stacks={**surface.stacks, ("roughness", FIRST_TILE): finer})
    model = compress(mixed)
    assert model.parts["roughness", FIRST_TILE].neutral.shape == (128, 128, 1)
    assert weights_of(model).shape[1:3] == (8, 8)
    assert model_errors(mixed, quantise(model))["roughness"].rmse < 4


@pytest.mark.parametrize("weights", [{"gloss": 1}, {"normal": 0}, {"normal": float("nan")}])
def test_weights_that_make_no_sense_are_refused(surface, weights):
    with pytest.raises(FaceZipError, match=next(iter(weights))):
        compress(surface, map_weights=weights)
