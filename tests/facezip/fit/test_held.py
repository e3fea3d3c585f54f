"""Weights that stay: the others are what least squares make of them."""

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from facezip.character.samples import samples_of
from facezip.fit.descent import Descent
from facezip.fit.held import Held
from facezip.fit.nonnegative import Limits, solve_bounded
from facezip.fit.sweep import solve_textures, weight_system
from tests.facezip.fit.test_sweep import pixels, random_weights, upsampling
from tests.facezip.fit.test_weights import flat, random_system


@pytest.mark.parametrize("seed", range(3))
def test_the_others_solve_what_is_left_of_the_dense_system(seed):
    """Any weights may be held: those of one expression and slot, or of some texels of all."""
    system, dense = random_system(seed=seed)
    rng = np.random.default_rng(seed)
    start = rng.normal(size=system.right.shape).astype(np.float32)
    held = rng.random(start.shape) < 0.4
    held[:, 1, 0] = True
    held[2, :, :, 1:3] = True
    free = np.full(start.shape[1:3], np.inf, np.float32)
    found = solve_bounded(system, start, Limits(-free, free, held), sweeps=300)
    np.testing.assert_array_equal(found[held], start[held])
    for n in range(start.shape[2]):
        stays = flat(held)[:, n].astype(bool)
        known, right = flat(start)[stays, n], flat(system.right)[:, n]
        rest = right[~stays] - dense[np.ix_(~stays, stays)] @ known
        expected = np.linalg.solve(dense[np.ix_(~stays, ~stays)], rest)
        np.testing.assert_allclose(flat(found)[~stays, n], expected, atol=1e-4)


def test_around_a_painted_map_weights_are_those_of_bounded_least_squares_on_all_texels(character):
    """Against SciPy's on the pixels themselves, under the model's own sampler."""
    samples, start = samples_of(character.first), random_weights(4, 2, 5)
    textures = solve_textures(samples, start).reshape(2, -1, 3)
    design = np.einsum("ipc,pa->pcai", textures, upsampling(32, 4)).reshape(-1, 32)
    held = np.zeros(start.shape, bool)
    held[:, 1, 3] = True
    bounds = np.full((2, 5), 0.4, np.float32)
    found = solve_bounded(weight_system(samples, start), start, Limits(-bounds, bounds, held), sweeps=400)
    np.testing.assert_array_equal(found[:, 1, 3], start[:, 1, 3])
    painted = start[:, 1, 3].reshape(16)
    target = pixels(character).reshape(5, -1)[3] - design[:, 1::2] @ painted
    expected = lsq_linear(design[:, ::2], target, (-0.4, 0.4), tol=1e-12).x
    np.testing.assert_allclose(found[:, 0, 3].reshape(16), expected, atol=5e-3)
    assert (np.abs(expected) > 0.399).any()


def test_nothing_held_is_as_if_nobody_had_asked():
    system, _ = random_system()
    bounds = np.full(system.right.shape[1:3], 0.1, np.float32)
    start = np.zeros_like(system.right)
    plain = solve_bounded(system, start, Limits(-bounds, bounds))
    told = solve_bounded(system, start, Limits(-bounds, bounds, np.zeros(start.shape, bool)))
    np.testing.assert_array_equal(told, plain)


def test_momentum_moves_no_weight_that_stays_and_none_beyond_its_bounds():
    rng = np.random.default_rng(0)
    weights, values = rng.normal(size=(2, 4, 2, 3, 5)).astype(np.float32)
    where = rng.random(weights.shape) < 0.5
    low, high = np.full((2, 3), -0.5, np.float32), np.full((2, 3), 0.7, np.float32)
    held = Held(where, values, low, high)
    descent = Descent(held.put(weights), Limits(low, high, where))
    for _ in range(6):
        descent.settle(descent.ahead())
        np.testing.assert_array_equal(descent.weights[where], values[where])
        assert descent.weights[~where].min() >= np.float32(-0.5)
        assert descent.weights[~where].max() <= np.float32(0.7)
        descent.weights[~where] += np.float32(0.1) * rng.normal(size=(~where).sum()).astype(np.float32)
        descent.weights[~where] = np.clip(descent.weights[~where], -0.5, 0.7)
