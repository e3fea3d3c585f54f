"""Laws of the fit under given masks: the projected equations, their bounds, and what the fit must not depend on."""

from dataclasses import replace

import numpy as np
import pytest

from facezip import FaceZipError, compress
from facezip.character.samples import samples_of
from facezip.fit.activations import ActivationSystem, Bounds, project, solve_activations
from facezip.fit.given import GivenMasks
from facezip.fit.sweep import solve_textures, weight_system
from facezip.pack.quantise import quantise
from facezip.pack.read import read_pack
from facezip.pack.write import write_pack
from scenes.tiles import in_tiles
from tests.facezip.conftest import part_of, principal_components, random_character, refine, rmse, with_albedo
from tests.facezip.fit.test_sweep import pixels, random_weights, upsampling
from tests.facezip.surfaces import random_surface

LOW, SLOTS, COUNT = 4, 2, 5


def random_masks(count=3, low=LOW, seed=0):
    masks = np.random.default_rng(seed).integers(0, 256, (count, low, low), np.uint8)
    masks[:, 0] = 0
    return masks


def free(count, slots=SLOTS):
    return Bounds.of(np.ones((count, slots), bool), nonnegative=False)


def system_of(character, masks):
    """The equations of masks, and the textures that they are for."""
    samples, weights = samples_of(character.first), random_weights(LOW, SLOTS, COUNT)
    return project(weight_system(samples, weights), masks), solve_textures(samples, weights)


def spots(side=64, count=6):
    """Round masks that overlap, as given ones."""
    y, x = (np.mgrid[:side, :side] + 0.5) / side
    centres = np.random.default_rng(4).random((count, 2))
    images = {
        (f"spot_{k}", 1001): np.exp(-8 * ((x - a) ** 2 + (y - b) ** 2)).astype(np.float32)
        for k, (a, b) in enumerate(centres)
    }
    return GivenMasks(tuple(f"spot_{k}" for k in range(count)), images)


def masks_fit(character, given=None, **settings):
    return compress(character, "masks", given_masks=given or spots(), **{"differences": 3, **settings})


def test_activations_are_the_least_squares_solution(character):
    """Against one dense system of all texels, under the model's own sampler."""
    masks = random_masks()
    system, textures = system_of(character, masks)
    sampled = upsampling(32, LOW) @ (masks.reshape(3, -1).T / 255)
    design = np.einsum("ipc,pk->pcki", textures.reshape(SLOTS, -1, 3), sampled).reshape(-1, 3 * SLOTS)
    expected = np.linalg.lstsq(design, pixels(character).reshape(COUNT, -1).T, rcond=None)[0].T
    found, _ = solve_activations(system, np.zeros((COUNT, 3, SLOTS)), free(3), sweeps=2000)
    np.testing.assert_allclose(found.reshape(COUNT, -1), expected, rtol=1e-3, atol=1e-3)


def test_the_projected_system_is_that_of_dense_matrices(character):
    weights, masks = random_weights(LOW, SLOTS, COUNT), random_masks()
    system = weight_system(samples_of(character.first), weights)
    ones = np.eye(LOW * LOW, dtype=np.uint8).reshape(-1, LOW, LOW) * np.uint8(255)
    whole, projected = project(system, ones), project(system, masks)
    spread = np.kron(masks.reshape(3, -1) / 255, np.eye(SLOTS))
    np.testing.assert_allclose(projected.matrix, spread @ whole.matrix @ spread.T, rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(projected.right, whole.right @ spread.T, rtol=1e-5, atol=1e-6)


def test_a_mask_for_every_weight_texel_has_the_equations_of_free_weight_maps(character):
    weights = random_weights(LOW, SLOTS, COUNT)
    system = weight_system(samples_of(character.first), weights)
    ones = np.eye(LOW * LOW, dtype=np.uint8).reshape(-1, LOW, LOW) * np.uint8(255)
    whole = project(system, ones)
    for y, x, ny, nx in ((1, 1, 1, 1), (1, 2, 2, 1), (0, 0, 0, 1), (3, 3, 2, 3), (0, 0, 2, 0)):
        block = whole.matrix.reshape(LOW, LOW, SLOTS, LOW, LOW, SLOTS)[y, x, :, ny, nx]
        near = max(abs(ny - y), abs(nx - x)) <= 1
        expected = system.matrix[y, :, :, 3 * (ny - y + 1) + nx - x + 1, x] if near else np.zeros((SLOTS, SLOTS))
        np.testing.assert_allclose(block, expected, rtol=1e-5, atol=1e-7)
    np.testing.assert_allclose(whole.right.reshape(COUNT, LOW, LOW, SLOTS).transpose(1, 3, 0, 2), system.right)


def test_a_mask_for_every_weight_texel_fits_as_well_as_free_weight_maps():
    character = random_character(side=64, expressions=9)
    names = tuple(f"texel_{k}" for k in range(64))
    images = {(name, 1001): row.reshape(8, 8) for name, row in zip(names, np.eye(64, dtype=np.float32), strict=True)}
    own = rmse(character, quantise(masks_fit(character, GivenMasks(names, images))))
    assert own == pytest.approx(rmse(character, quantise(refine(character, 3, 8))), rel=0.03)


@pytest.mark.parametrize("high", [1.0, np.inf])
def test_within_bounds_the_conditions_of_optimality_hold(character, high):
    """Karush, Kuhn and Tucker's: the gradient is 0 inside, and points out of the bounds where one is reached."""
    system, _ = system_of(character, random_masks(5))
    bounds = Bounds(np.zeros((5, SLOTS)), np.full((5, SLOTS), high))
    found, _ = solve_activations(system, np.zeros((COUNT, 5, SLOTS)), bounds, sweeps=3000)
    found = found.reshape(COUNT, -1)
    gradient = (found @ system.matrix - system.right) / np.diag(system.matrix)
    inside = (found > 0) & (found < high)
    assert np.abs(gradient[inside]).max() < 1e-6
    assert (gradient[found == 0] > -1e-6).all()
    assert (gradient[found == high] < 1e-6).all()
    assert (found == 0).any()
    assert inside.any()


def test_sweeps_never_raise_the_error(character):
    system, _ = system_of(character, random_masks(5))
    found, explained = np.zeros((COUNT, 5, SLOTS)), []
    for _ in range(6):
        found, before = solve_activations(system, found, free(5), sweeps=1)
        explained.append(before)
    assert explained == sorted(explained)


def test_a_mask_that_no_texel_sees_keeps_its_activations():
    nothing = ActivationSystem(np.zeros((2, 2)), np.zeros((1, 2)))
    start = np.array([[[0.25, -0.5]]])
    np.testing.assert_array_equal(solve_activations(nothing, start, free(1))[0], start)


def test_masks_lie_between_uniform_and_free_weights():
    character = random_character(side=64, expressions=9)
    pca, refined = (rmse(character, quantise(fit(character))) for fit in (uniform, lambda c: refine(c, 3, 8)))
    few, many = (rmse(character, quantise(masks_fit(character, spots(count=count)))) for count in (6, 24))
    assert refined < many < few < pca * 1.5


def uniform(character):
    return principal_components(character, 3)


def test_one_white_mask_is_principal_components():
    character = random_character(side=64, expressions=9)
    white = GivenMasks(("all",), {("all", 1001): np.ones((4, 4), np.float32)})
    own = rmse(character, quantise(masks_fit(character, white)))
    assert own == pytest.approx(rmse(character, quantise(uniform(character))), rel=0.02)


def test_what_a_pack_stores_is_exactly_what_was_fitted(tmp_path):
    character = random_character(side=64, expressions=6)
    model = masks_fit(character)
    write_pack(model, tmp_path / "me.facezip")
    back = read_pack(tmp_path / "me.facezip")
    np.testing.assert_array_equal(back.weights[1001], model.weights[1001])
    np.testing.assert_allclose(part_of(back).differences, part_of(model).differences, atol=1e-6)
    assert rmse(character, back) == pytest.approx(rmse(character, model), abs=0.02)


def test_the_largest_activation_of_every_layer_is_one(character):
    activations = masks_fit(character).masked.activations
    np.testing.assert_array_equal(np.abs(activations).max(axis=(0, 1)), 1)


@pytest.mark.parametrize("seed", range(3))
def test_nonnegative_activations_lie_in_0_to_1_and_cost_little(seed):
    character = random_character(seed, side=64, expressions=9)
    free_, clamped = (masks_fit(character, nonnegative=nonnegative) for nonnegative in (False, True))
    assert clamped.masked.clamped
    assert not free_.masked.clamped
    assert (
        rmse(character, quantise(free_)) < rmse(character, quantise(clamped)) < 1.5 * rmse(character, quantise(free_))
    )


def test_under_most_masks_some_expression_shows_a_clamped_layer_almost_wholly():
    """So that neutral and layer are a picture of their own, as engines have them."""
    model = masks_fit(random_character(side=64, expressions=9), nonnegative=True)
    assert np.median(model.masked.activations.max(axis=0)) > 0.8


def test_a_mask_acts_in_its_layers_alone(character):
    layers = {"spot_0": (1,), "spot_3": (0, 2)}
    activations = masks_fit(character, replace(spots(), layers=layers)).masked.activations
    assert (activations[:, 0, [0, 2]] == 0).all()
    assert (activations[:, 3, 1] == 0).all()
    assert (activations[:, 0, 1] != 0).any()


def test_the_order_of_expressions_changes_nothing():
    character = random_character(side=64, expressions=7)
    order = [3, 0, 6, 1, 5, 2, 4]
    turned = with_albedo(character, textures=character.first.textures[order])
    one, other = masks_fit(character).masked.activations, masks_fit(turned).masked.activations
    # Components, from which a fit starts, have a sign that depends on nothing but their largest entry.
    np.testing.assert_allclose(other.astype(float), one[order].astype(float), atol=5e-3)


def test_the_same_bytes_whatever_the_number_of_threads(character, monkeypatch):
    models = []
    for threads in (1, 2, 7):
        monkeypatch.setattr("facezip.machine.cores._share", threads)
        models.append(masks_fit(character))
    for model in models[1:]:
        np.testing.assert_array_equal(model.masked.activations, models[0].masked.activations)
        np.testing.assert_array_equal(part_of(model).differences, part_of(models[0]).differences)


def test_tiles_share_their_activations():
    """Cut into tiles, with its masks cut as they are, a chart is fitted as well as the whole."""
    surface, given = random_surface(side=64), spots()
    halves = {
        (name, tile): image[:, columns]
        for (name, _), image in given.images.items()
        for tile, columns in ((1001, slice(0, 32)), (1002, slice(32, 64)))
    }
    whole = masks_fit(surface, given)
    cut = masks_fit(in_tiles(surface, 2, 1), replace(given, images=halves))
    assert cut.masked.activations.shape == whole.masked.activations.shape
    joined = np.concatenate([cut.masked.masks[tile] for tile in (1001, 1002)], axis=2)
    np.testing.assert_array_equal(joined, whole.masked.masks[1001])
    errors = [rmse(one, quantise(model)) for one, model in ((surface, whole), (in_tiles(surface, 2, 1), cut))]
    assert errors[1] < 1.05 * errors[0]


def test_given_masks_are_of_their_method(character):
    with pytest.raises(FaceZipError, match="use masks"):
        compress(character, "refined", given_masks=spots())
    with pytest.raises(FaceZipError, match="nonnegative"):
        compress(character, "pca", nonnegative=True)
