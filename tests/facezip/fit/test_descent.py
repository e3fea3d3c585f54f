"""Alternations of what moves: which tiles are taken, how they move, and what is gained by it."""

import numpy as np
import pytest

from facezip.character.samples import samples_of
from facezip.fit import descent as rules
from facezip.fit.descent import Descent
from facezip.fit.refine import fit_weights
from facezip.fit.sweep import weight_system
from tests.facezip.conftest import random_character, with_albedo

TILE = rules.tile_of((40, 2, 3, 36))


def start_of(h=40, w=36, seed=0):
    return np.random.default_rng(seed).normal(size=(h, 2, 3, w)).astype(np.float32)


def settled(descent, gains, along=1.0):
    """An alternation after which every texel has gained so much, ``(h, w)``."""
    moves = descent.ahead()
    moves.gains[:] = gains
    moves.along[:] = along
    descent.settle(moves)
    return moves.moving


def test_all_move_at_first_and_then_those_that_gained_most():
    descent, (rows, columns) = Descent(start_of()), np.mgrid[:40, :36] // TILE
    gains = 1.0 + 9 * columns + rows
    assert all(settled(descent, gains).all() for _ in range(rules.WHOLE))
    moving = settled(descent, gains)
    count = int(rules.SHARE * 90) * TILE**2
    np.testing.assert_array_equal(moving, gains > np.sort(gains.ravel())[-count - 1])


def test_every_tile_has_its_turn_while_it_has_something_to_gain():
    descent, seen = Descent(start_of()), np.zeros((40, 36), int)
    for step in range(60):
        moving = settled(descent, np.full((40, 36), 0.8**step))
        seen += moving
    assert seen.min() > rules.WHOLE


def test_tiles_that_are_few_move_together():
    descent = Descent(start_of(20, 20))
    assert all(settled(descent, np.arange(400.0).reshape(20, 20)).all() for _ in range(9))
    assert descent.steps(24) == 24


def test_all_move_where_nothing_is_to_be_chosen():
    descent = Descent(start_of(), choosing=False)
    assert all(settled(descent, np.arange(1440.0).reshape(40, 36)).all() for _ in range(9))
    assert descent.steps(24) == 24 < Descent(start_of()).steps(24)


def test_a_fit_around_a_locked_texture_takes_all_texels(monkeypatch):
    """They are solved whole, so that choosing some would lose what the others gain."""
    samples = samples_of(random_character(side=256, expressions=4).first)
    moved, ahead = [], Descent.ahead

    def noticed(descent):
        moves = ahead(descent)
        moved.append(moves.moving.mean())
        return moves

    monkeypatch.setattr(Descent, "ahead", noticed)
    monkeypatch.setattr("facezip.fit.refine.alternations", lambda *_: 6)
    layer = np.full(samples.neutral.shape, 0.1, np.float32)
    fit_weights([samples], 2, 8, locked=[{0: layer}])
    # The fit without that slot chooses; the one around it does not.
    assert moved[-6:] == [1] * 6
    assert min(moved) < 1


def test_momentum_is_nesterovs_and_forgotten_where_it_led_past_the_goal():
    descent = Descent(start_of())
    weights, before = descent.weights.copy(), descent.weights.copy()
    along = np.ones((40, 36))
    along[:8] = -1
    for age in range(rules.WHOLE):
        moves = descent.ahead()
        momentum = np.where(np.arange(40) < 8, 0, age / (age + 2)).astype(np.float32)[:, None, None, None]
        expected = weights + momentum * (weights - before)
        np.testing.assert_allclose(descent.weights, expected, rtol=1e-5, atol=1e-5)
        # What a solver would do, as far as this is concerned.
        descent.weights += 1
        before, weights = weights, expected + 1
        moves.along[:], moves.gains[:] = along, 1
        descent.settle(moves)


def explained(samples, weights):
    """How much lower the squared error is than with all weights zero, under the best textures."""
    return float(np.vdot(weights.astype(float), weight_system(samples, weights).right))


def test_where_little_is_left_to_gain_in_most_places_it_gains_more_than_whole_alternations_of_the_same_cost(
    monkeypatch,
):
    character = random_character(side=256, expressions=9)
    textures = character.first.textures.copy()
    # All but a patch is one picture, times a number: the first alternation finds that.
    same = character.first.neutral.astype(float)
    for n, texture in enumerate(textures):
        patch = texture[96:160, 64:128].copy()
        texture[:] = np.clip(same * (1 + 0.02 * n), 0, 255)
        texture[96:160, 64:128] = patch
    samples = samples_of(with_albedo(character, textures=textures).first)
    chosen = explained(samples, fit_weights([samples], 3, 8))
    monkeypatch.setattr(rules, "MANY", 10**9)
    assert chosen > explained(samples, fit_weights([samples], 3, 8))


@pytest.mark.parametrize("seed", range(3))
def test_it_goes_on_gaining(seed, monkeypatch):
    samples = samples_of(random_character(seed, side=256, expressions=6).first)
    errors = []
    for alternations in (3, 5, 9, 17):
        monkeypatch.setattr("facezip.fit.refine.alternations", lambda *_, count=alternations: count)
        errors.append(-explained(samples, fit_weights([samples], 3, 8)))
    assert errors == sorted(errors, reverse=True)
