"""Weight maps that may not be negative: the best that there are, and what the bound costs."""

import numpy as np
import pytest
from scipy.optimize import nnls

from facezip import compress
from facezip.character.samples import samples_of
from facezip.fit.nonnegative import Limits, improve_bounded, solve_bounded
from facezip.fit.pca import larger_sides
from facezip.fit.sweep import solve_textures, weight_system
from facezip.fit.weights import Moves
from facezip.pack.quantise import quantise
from tests.facezip.conftest import part_of, principal_components, random_character, refine, rmse, weights_of
from tests.facezip.fit.test_sweep import pixels, random_weights, upsampling
from tests.facezip.fit.test_weights import product


def explained_by(system, weights):
    """How much lower the squared error is than with all weights zero."""
    return float((weights * (2 * system.right - product(system.matrix, weights))).sum())


def added(character, differences=3, **options):
    return compress(character, differences=differences, nonnegative=True, **options)


def test_weights_are_those_of_nonnegative_least_squares(character):
    """Against an active set method on one dense system of all texels, under the model's own sampler."""
    samples, start = samples_of(character.first), random_weights(4, 2, 5)
    textures = solve_textures(samples, start).reshape(2, -1, 3)
    design = np.einsum("ipc,pa->pcai", textures, upsampling(32, 4)).reshape(-1, 32)
    system = weight_system(samples, start)
    found = solve_bounded(system, np.zeros_like(start), Limits.nonnegative(start), sweeps=400)
    for n, target in enumerate(pixels(character).reshape(5, -1)):
        expected = nnls(design, target)[0].reshape(4, 4, 2).transpose(0, 2, 1)
        np.testing.assert_allclose(found[:, :, n], expected, rtol=5e-3, atol=5e-3)
    assert (found == 0).any()


def test_sweeps_never_raise_the_error(character):
    system = weight_system(samples_of(character.first), random_weights(4, 2, 5))
    weights, explained = np.abs(random_weights(4, 2, 5, seed=1)), []
    for _ in range(5):
        weights = solve_bounded(system, weights, Limits.nonnegative(weights), sweeps=1)
        explained.append(explained_by(system, weights))
    assert explained == sorted(explained)


def test_only_what_moves_changes(character):
    system = weight_system(samples_of(character.first), random_weights(4, 2, 5))
    start, moving = np.abs(random_weights(4, 2, 5, seed=1)), np.zeros((4, 4), bool)
    moving[1, 2:] = True
    weights = start.copy()
    improve_bounded(system, weights, Moves.of(moving, start), Limits.nonnegative(start))
    assert ((weights != start).any(axis=(1, 2)) == moving).all()


@pytest.mark.parametrize("seed", range(3))
def test_weights_lie_in_0_to_1_and_cost_little(seed):
    character = random_character(seed, side=64, expressions=9)
    model = quantise(added(character)).dequantised()
    weights = weights_of(model)
    assert weights.min() >= 0
    np.testing.assert_allclose(weights.max(axis=(0, 1, 2)), 1, atol=1e-5)
    free = rmse(character, quantise(refine(character, 3, 8)))
    assert free < rmse(character, model) < 1.3 * free
    assert rmse(character, model) < rmse(character, quantise(principal_components(character, 3)))


def test_what_a_pack_stores_is_exactly_what_was_fitted():
    model = added(random_character(side=64, expressions=6))
    back = quantise(model).dequantised()
    np.testing.assert_allclose(part_of(back).differences, part_of(model).differences, atol=1e-6)
    np.testing.assert_allclose(weights_of(back), weights_of(model), atol=1e-6)


def test_the_start_keeps_the_larger_side_of_each_component():
    components = np.array([[0.8, -0.9], [-0.6, 0.2], [0.0, 0.3]], np.float32)
    np.testing.assert_allclose(larger_sides(components), [[0.8, 0.9], [0, 0], [0, 0]])


def test_same_bytes_whatever_the_number_of_threads(monkeypatch):
    character = random_character(side=272, expressions=3)
    models = []
    for threads in (1, 3):
        monkeypatch.setattr("facezip.machine.cores._share", threads)
        models.append(added(character, 2, weight_scale=4))
    np.testing.assert_array_equal(weights_of(models[1]), weights_of(models[0]))
    np.testing.assert_array_equal(part_of(models[1]).differences, part_of(models[0]).differences)
