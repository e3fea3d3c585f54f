import numpy as np
import pytest

from scenes.character import Person
from scenes.face.capture import Nuisances, captured
from scenes.face.head import build_head
from scenes.face.skin.albedo import neutral_albedo
from scenes.face.skin.hairs import grown
from scenes.face.skin.noise import cells, fractal, hashed, value_noise
from scenes.face.skin.sampling import TexelGrid, closed
from scenes.face.skin.strain import frames_of, strain
from scenes.face.traits import traits


@pytest.fixture(scope="module")
def person():
    return Person.make(256)


def test_without_weights_the_texture_is_the_neutral(person):
    still = person.texture({"browInnerUp": 0.0})
    np.testing.assert_array_equal(still, person.albedo)


def test_an_expression_changes_the_skin_where_it_moves_and_nowhere_else(person):
    change = np.abs(person.texture({"browInnerUp": 1.0}) - person.albedo).max(axis=2)
    assert change.max() > 0.05
    assert change[140:].max() == 0


def test_detail_is_evaluated_at_the_texel_and_not_upscaled():
    small, large = (bare_albedo(side)[:, :, 1] for side in (256, 512))
    halved = large.reshape(256, 2, 256, 2).mean(axis=(1, 3))
    assert np.abs(halved - small).mean() < 0.02
    upscaled = np.kron(small, np.ones((2, 2)))
    fine = np.abs(np.diff(large, axis=1)).mean() - np.abs(np.diff(upscaled, axis=1)).mean()
    assert fine > 0


def bare_albedo(side):
    head, who = build_head(), traits(0)
    texels = TexelGrid.of(head, side)
    return neutral_albedo(head.rows, texels, who, grown(head, texels, who))


def stretches(result, direction):
    """How much the skin is stretched along a direction of space, as far as it lies in the skin: a factor."""
    grid = closed(build_head(), build_head().vertices)
    along = np.einsum("rcki,i->rck", frames_of(grid), direction)
    along /= np.linalg.norm(along, axis=2, keepdims=True)
    u, v = along[..., 0], along[..., 1]
    return np.sqrt(
        1 + u * u * result.excess[..., 0] + 2 * u * v * result.excess[..., 1] + v * v * result.excess[..., 2]
    )


def test_raised_brows_press_the_forehead_from_below():
    person = Person.make(64)
    result = strain(person.head, person.vertices({"browInnerUp": 1.0}))
    grid = closed(person.head, person.head.vertices)
    forehead = (grid[..., 2] > 6) & (grid[..., 1] > 4.2) & (grid[..., 1] < 6.5) & (np.abs(grid[..., 0]) < 2)
    up, across = (stretches(result, np.array(direction))[forehead] for direction in ([0, 1, 0], [1, 0, 0]))
    assert up.max() < 1
    assert up.mean() < 0.92
    assert np.abs(across - 1).max() < 0.03


def test_a_rigid_motion_strains_nothing():
    head = build_head()
    turned = head.vertices @ np.array([[0.8, 0.6, 0], [-0.6, 0.8, 0], [0, 0, 1]], np.float32) + np.float32(3)
    result = strain(head, turned)
    assert np.abs(result.fields).max() < 2e-3


def test_a_stretch_is_measured_as_such():
    head = build_head()
    result = strain(head, head.vertices * np.float32(0.9))
    for direction in np.eye(3)[:2]:
        np.testing.assert_allclose(stretches(result, direction)[100:120, 80:110], 0.9, atol=5e-3)
    np.testing.assert_allclose(result.area[100:120, 80:110], 0.81 - 1, atol=5e-3)


def test_noise_is_bounded_smooth_and_the_same_everywhere():
    values = [value_noise(0.1 * n, 0.3, -7.7, 5) for n in range(-200, 200)]
    assert max(np.abs(values)) <= 1
    assert np.abs(np.diff(values)).max() < 0.35
    assert 0 <= hashed(-5, 3, 99, 1) < 1
    assert hashed(1, 2, 3, 4) == pytest.approx(hashed(1, 2, 3, 4), abs=0)
    near, number = cells(0.3, -2.0, 1.0, 0.5, 9)
    assert 0 <= near < 1.8
    assert 0 <= number < 1


def test_noise_finer_than_texels_fades_out():
    rng = np.random.default_rng(0)
    points = rng.uniform(-5, 5, (400, 3))
    spread = [np.std([fractal(x, y, z, 0.2, 3, texel, 1) for x, y, z in points]) for texel in (0.001, 0.05, 0.2)]
    assert spread[0] > spread[1] > spread[2] == 0


@pytest.mark.parametrize("field", ["misregistration", "noise", "drift"])
def test_a_nuisance_of_strength_zero_is_off_exactly(field):
    texture = np.random.default_rng(0).random((64, 64, 3)).astype(np.float32)
    off = Nuisances(0, 0, 0)
    np.testing.assert_array_equal(captured(texture, off, np.random.default_rng(1)), texture)
    on = Nuisances(**{"misregistration": 0, "noise": 0, "drift": 0, field: 1.0})
    assert np.abs(captured(texture, on, np.random.default_rng(1)) - texture).max() > 0


def test_misregistration_has_the_strength_it_states():
    ramp = np.tile(np.linspace(0, 1, 512, dtype=np.float32)[None, :, None], (512, 1, 1))
    warped = captured(ramp, Nuisances(2.0, 0, 0), np.random.default_rng(0))
    moved = (warped - ramp)[50:-50, 50:-50, 0] * 511
    assert 1.0 < moved.std() < 3.0
