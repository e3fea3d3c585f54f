from dataclasses import replace

import numpy as np
import pytest

from facezip.character.samples import samples_of
from facezip.character.scans import Stack
from facezip.fit.sweep import RIDGE, solve_texture, solve_textures, weight_system
from facezip.fit.weights import solve_weights
from facezip.pack.model import Part, blended_rows
from tests.facezip.conftest import random_character
from tests.facezip.fit.test_weights import product


def upsampling(side, low):
    """Bilinear upsampling of a flat ``low`` x ``low`` map as a matrix, from the model's own sampler."""
    columns = []
    for texel in range(low * low):
        weights = np.zeros((low * low, 1), np.float32)
        weights[texel] = 1
        ones = np.ones((1, side, side, 1), np.float32)
        part = Part(np.zeros((side, side, 1), np.float32), ones)
        columns.append(blended_rows(part, weights.reshape(low, low, 1))(slice(0, side)))
    return np.stack([column.ravel() for column in columns], axis=1).astype(float)


def pixels(character):
    return np.stack([character.texture(name) - character.texture("neutral") for name in character.expressions])


def random_weights(low, slots, count, seed=0):
    return np.random.default_rng(seed).normal(size=(low, slots, count, low)).astype(np.float32)


def test_textures_are_the_least_squares_solution_of_every_texel(character):
    weights = random_weights(4, 2, 5)
    textures = solve_textures(samples_of(character.first), weights).reshape(2, -1, 3)
    sampled = (upsampling(32, 4) @ weights.transpose(0, 3, 1, 2).reshape(16, 10)).reshape(32 * 32, 2, 5)
    for texel in (0, 345, 1023):
        target = pixels(character).reshape(5, -1, 3)[:, texel]
        expected = np.linalg.lstsq(sampled[texel].T, target, rcond=None)[0]
        residual, best = (np.linalg.norm(sampled[texel].T @ t - target) for t in (textures[:, texel], expected))
        assert residual == pytest.approx(best, rel=1e-3)


def test_the_system_is_that_of_least_squares_under_the_sampler(character):
    mask = np.random.default_rng(3).random(character.first.resolution).astype(np.float32)
    samples = samples_of(replace(character.first, mask=mask))
    start = random_weights(4, 2, 5)
    textures = solve_textures(samples, start).reshape(2, -1, 3)
    design = np.einsum("p,ipc,pa->pcai", np.sqrt(mask.ravel()), textures, upsampling(32, 4)).reshape(-1, 32)
    target = (np.sqrt(mask.ravel())[:, None] * pixels(character).reshape(5, -1, 3)).reshape(5, -1)
    expected = np.linalg.lstsq(design, target.T, rcond=None)[0].reshape(4, 4, 2, 5).transpose(0, 2, 3, 1)
    weights = start
    for _ in range(40):
        weights = solve_weights(weight_system(samples, start), weights)
    np.testing.assert_allclose(weights, expected, rtol=2e-3, atol=2e-3)


@pytest.mark.parametrize("slots", [1, 2])
def test_given_textures_make_the_same_system_as_solved_ones(character, slots):
    samples, weights = samples_of(character.first), random_weights(4, slots, 5)
    solved = weight_system(samples, weights)
    given = weight_system(samples, weights, solve_textures(samples, weights))
    np.testing.assert_array_equal(solved.matrix, given.matrix)
    np.testing.assert_array_equal(solved.right, given.right)


@pytest.mark.parametrize("slots", [1, 2])
def test_what_couples_weights_under_given_textures_does_not_depend_on_the_scans(character, slots):
    """Not even where no expression differs from the neutral."""
    weights, stack = random_weights(4, slots, 5), character.first
    textures = np.random.default_rng(0).normal(size=(slots, 32, 32, 3)).astype(np.float32)
    still = replace(stack, textures=np.repeat(stack.neutral[None], len(stack.textures), axis=0))
    once, without = (weight_system(samples_of(one), weights, textures) for one in (stack, still))
    np.testing.assert_array_equal(without.matrix, once.matrix)
    assert once.matrix.any()
    assert not without.right.any()


@pytest.mark.parametrize("scale", [4, 8])
@pytest.mark.parametrize("resolution", [100, 256])
def test_equations_of_what_moves_are_those_of_all_texels(resolution, scale):
    character = random_character(side=resolution, expressions=4)
    samples, low = samples_of(character.first), -(-resolution // scale)
    weights = random_weights(low, 2, 4)
    moving = np.zeros((low, low), bool)
    moving[3:7, 5:9] = moving[low - 1, 0] = moving[low // 2, low - 1] = True
    whole, part = weight_system(samples, weights), weight_system(samples, weights, moving=moving)
    for all_, some in zip(whole, part, strict=True):
        np.testing.assert_array_equal(np.moveaxis(some, -1, 1)[moving], np.moveaxis(all_, -1, 1)[moving])
    assert not part.right.any(axis=(1, 2)).all()


def test_the_system_of_several_blocks_of_rows_is_that_of_all_texels():
    """Right sides, and what couples a weight texel with itself, as the module's equations say them."""
    character, weights = random_character(side=96), random_weights(14, 2, 5)
    mask = np.random.default_rng(3).uniform(0.1, 1, (96, 96)).astype(np.float32)
    textures = np.random.default_rng(4).normal(size=(2, 96, 96, 3)).astype(np.float32)
    system = weight_system(samples_of(replace(character.first, mask=mask)), weights, textures)
    shares, layers = upsampling(96, 14), textures.reshape(2, -1, 3)
    right = np.einsum(
        "p,pq,ipc,npc->qin", mask.ravel(), shares, layers, pixels(character).reshape(5, -1, 3), optimize=True
    )
    own = np.einsum("p,pq,ipc,jpc->qij", mask.ravel(), shares**2, layers, layers, optimize=True)
    found = system.right.transpose(0, 3, 1, 2), system.matrix[:, :, :, 4].transpose(0, 3, 1, 2)
    for one, expected in zip(found, (right, own), strict=True):
        np.testing.assert_allclose(one.reshape(expected.shape), expected, rtol=1e-4, atol=1e-4 * np.abs(expected).max())


@pytest.mark.parametrize("slots", [1, 2])
def test_textures_twice_as_strong_are_half_as_much_of_a_weight(character, slots):
    """Powers of two are exact."""
    samples, weights = samples_of(character.first), random_weights(4, slots, 5)
    textures = np.random.default_rng(0).normal(size=(slots, 32, 32, 3)).astype(np.float32)
    once, twice = (weight_system(samples, weights, factor * textures) for factor in (np.float32(1), np.float32(2)))
    np.testing.assert_array_equal(twice.matrix, 4 * once.matrix)
    np.testing.assert_array_equal(twice.right, 2 * once.right)


def test_only_the_ratio_of_what_texels_count_matters(character):
    """Also of which count so little that some stand for all."""
    mask = np.random.default_rng(3).random((32, 32)).astype(np.float32)
    mask[8:24] *= 0.02
    once, more = (
        weight_system(samples_of(replace(character.first, mask=factor * mask)), random_weights(4, 2, 5))
        for factor in (np.float32(1), np.float32(4))
    )
    np.testing.assert_array_equal(more.matrix, 4 * once.matrix)
    np.testing.assert_array_equal(more.right, 4 * once.right)


@pytest.mark.parametrize("resolution", [31, 130, 200])
def test_any_size_and_any_number_of_channels(resolution):
    character = random_character(side=resolution, expressions=4)
    gray = Stack(character.first.neutral[..., :1], character.first.textures[..., :1].copy())
    weights = random_weights(7, 2, 4)
    colour = solve_textures(samples_of(character.first), weights)
    np.testing.assert_allclose(solve_textures(samples_of(gray), weights)[..., 0], colour[..., 0], atol=1e-5)


@pytest.mark.parametrize(
    ("slots", "channels", "low"),
    [(1, 3, 9), (2, 1, 9), (3, 4, 9), (4, 2, 9), (4, 3, 9), (5, 1, 9), (6, 4, 9), (8, 3, 9), (2, 3, 5)],
)
def test_any_number_of_slots_and_channels_makes_the_plain_equations(slots, channels, low):
    """On a texture of whole tiles and a part of one, of which a band does not count, against sums over all texels."""
    side, count = 70, 5
    stack = random_character(side=side, expressions=count).first
    some = [0, 1, 2, 0][:channels]
    importance = np.random.default_rng(1).random((side, side)).astype(np.float32)
    importance[35:49] = 0
    samples = samples_of(Stack(stack.neutral[..., some].copy(), stack.textures[..., some].copy()), importance)
    weights, sampler = random_weights(low, slots, count), upsampling(side, low)

    def sampled(maps):
        return (sampler @ maps.transpose(0, 3, 1, 2).reshape(low * low, -1)).reshape(-1, slots, count)

    def gathered(terms):
        return (sampler.T @ terms.reshape(side * side, -1)).reshape(low, low, slots, count).transpose(0, 2, 3, 1)

    shown = sampled(weights.astype(float))
    differences = (samples.textures.astype(float) - samples.neutral) * samples.scale
    differences = differences.reshape(count, -1, channels).transpose(1, 0, 2)
    ridge = RIDGE * np.square(weights).sum() / low**2
    textures = np.linalg.solve(shown @ shown.transpose(0, 2, 1) + ridge * np.eye(slots), shown @ differences)
    counted = samples.importance.reshape(-1, 1, 1) * textures
    system, other = weight_system(samples, weights), random_weights(low, slots, count, seed=2)

    def assert_close(found, expected):
        np.testing.assert_allclose(found, expected, atol=1e-4 * np.abs(expected).max())

    solved = solve_textures(samples, weights).reshape(slots, -1, channels).transpose(1, 0, 2)
    assert_close(solved, textures)
    assert_close(system.right, gathered(counted @ differences.transpose(0, 2, 1)))
    assert_close(product(system.matrix, other), gathered(counted @ textures.transpose(0, 2, 1) @ sampled(other)))


def test_rows_that_hardly_count_and_texels_that_never_change_are_left_out():
    """Of four rows that count little one stands for all, in the middle; others are as if they were not there."""
    stack = random_character(side=40, expressions=4).first
    stack.textures[:, 16:24] = stack.neutral[16:24]
    weights, importance = random_weights(5, 2, 4), np.ones((40, 40), np.float32)
    importance[8:16] = 0.02
    alone = np.where(np.arange(40) % 4 == 2, np.float32(0.08), np.float32(0))
    alone = np.where((np.arange(40) < 8) | (np.arange(40) >= 16), importance[:, 0], alone)
    found = weight_system(samples_of(stack, importance), weights)
    expected = weight_system(samples_of(stack, np.repeat(alone[:, None], 40, axis=1)), weights)
    np.testing.assert_allclose(found.right, expected.right, rtol=1e-4, atol=1e-4)
    np.testing.assert_allclose(found.matrix, expected.matrix, rtol=1e-4, atol=1e-4)


def test_rounded_textures_are_on_their_grid_and_nearly_as_good(character):
    samples, weights = samples_of(character.first), random_weights(4, 2, 5)
    free = solve_textures(samples, weights)
    steps = (np.abs(free).max(axis=(1, 2)) / 127).astype(np.float32)
    rounded = solve_textures(samples, weights, steps) / steps[:, None, None]
    np.testing.assert_allclose(rounded, np.rint(rounded), atol=1e-4)
    assert np.abs(rounded).max() <= 127.001


def test_rounding_one_after_the_other_beats_rounding_all_at_once():
    """Two textures that nearly repeat each other: the second makes up for the rounding of the first."""
    character = random_character(side=64, expressions=6)
    samples = samples_of(character.first)
    weights = random_weights(8, 2, 6)
    weights[:, 1] = weights[:, 0] + 0.3 * weights[:, 1]
    free = solve_textures(samples, weights)
    steps = np.full((2, 3), np.abs(free).max() / 20, np.float32)
    sampled = (upsampling(64, 8) @ weights.transpose(0, 3, 1, 2).reshape(64, 12)).reshape(64 * 64, 2, 6)

    def error(textures):
        return np.square(np.einsum("pin,ipc->npc", sampled, textures.reshape(2, -1, 3)) - target).sum()

    target = pixels(character).reshape(6, -1, 3)
    assert error(solve_textures(samples, weights, steps)) < error(
        np.rint(free / steps[:, None, None]) * steps[:, None, None]
    )


def test_textures_solved_one_after_the_other_are_those_solved_together(character):
    samples, weights = samples_of(character.first), random_weights(4, 3, 5)
    together = solve_textures(samples, weights)
    apart = np.zeros_like(together)
    for slot in (2, 1, 0):
        apart[slot] = solve_texture(samples, weights, apart, slot)
    np.testing.assert_allclose(apart, together, rtol=1e-4, atol=1e-5)


def test_a_texture_makes_up_for_what_a_later_one_lost(character):
    samples, weights = samples_of(character.first), random_weights(4, 2, 5)
    textures = solve_textures(samples, weights)
    textures[1] += np.random.default_rng(0).normal(0, 0.05, textures[1].shape).astype(np.float32)
    sampled = (upsampling(32, 4) @ weights.transpose(0, 3, 1, 2).reshape(16, 10)).reshape(32 * 32, 2, 5)
    rest = pixels(character).reshape(5, -1, 3) - sampled[:, 1].T[:, :, None] * textures[1].reshape(-1, 3)
    ridge = RIDGE * np.square(weights).sum() / 16
    best = np.einsum("pn,npc->pc", sampled[:, 0], rest) / (np.square(sampled[:, 0]).sum(axis=1) + ridge)[:, None]
    np.testing.assert_allclose(solve_texture(samples, weights, textures, 0).reshape(-1, 3), best, rtol=1e-4, atol=1e-5)


def test_a_locked_texture_stays_in_whatever_slot_it_is():
    """Over several blocks of rows; the others change with the slots of their weights."""
    samples, weights = samples_of(random_character(side=70).first), random_weights(4, 3, 5)
    locked = np.random.default_rng(1).normal(0, 0.1, samples.neutral.shape).astype(np.float32)
    first = solve_textures(samples, weights, locked={0: locked})
    second = solve_textures(samples, np.roll(weights, 1, axis=1), locked={1: locked})
    np.testing.assert_array_equal(first[0], locked)
    np.testing.assert_allclose(second, np.roll(first, 1, axis=0), rtol=1e-4, atol=1e-5)
