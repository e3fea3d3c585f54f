"""Soft skin: two highlights, and diffuse light that follows blurred normals."""

from dataclasses import replace

import numpy as np
import pytest

import render.shading as shading
from facezip.files.obj import Topology
from render.llvm import start
from render.paired import PairedRenderer
from render.scattering import WIDTHS, blurred_slopes, spread
from render.shading import Finish
from render.skins import SkinMaps, upload
from scenes.cameras import VIEWS, frame_of
from tests.render.conftest import lumpy_head
from tests.render.test_shading import directions

SLOPE = (0.4, -0.2)


def tilted(x, y):
    import mitsuba as mi

    return mi.Vector3f(*(np.array([x, y, 1.0]) / np.sqrt(1 + x * x + y * y)).tolist())


def of(found):
    return np.array(found, np.float64)


def test_with_one_lobe_and_no_scatter_it_is_the_plain_skin(monkeypatch):
    eye, light = directions(0, lowest=0.01), directions(1)
    monkeypatch.setattr(shading, "NARROW_SHARE", 0.0)
    monkeypatch.setattr(shading, "BROAD", 1.0)
    for normal in (None, tilted(*SLOPE)):
        for ours, plain in zip(
            shading.soft(eye, light, Finish(normal)), shading.principled(eye, light, Finish(normal)), strict=True
        ):
            np.testing.assert_allclose(of(ours), of(plain), rtol=1e-6, atol=1e-9)


def test_normals_that_are_not_blurred_scatter_nothing():
    eye, light = directions(2, lowest=0.01), directions(3)
    finish = Finish(tilted(*SLOPE))
    alone, specular = shading.soft(eye, light, finish)
    found, same = shading.soft(eye, light, replace(finish, scattering=(finish.normal,) * 3))
    np.testing.assert_allclose(of(found), np.broadcast_to(of(alone), of(found).shape), rtol=1e-6)
    np.testing.assert_array_equal(of(specular), of(same))


def test_highlights_do_not_scatter():
    eye, light = directions(4, lowest=0.01), directions(5)
    finish = Finish(tilted(*SLOPE))
    blurred = replace(finish, scattering=(tilted(0, 0), tilted(0.2, -0.1), finish.normal))
    np.testing.assert_array_equal(of(shading.soft(eye, light, finish)[1]), of(shading.soft(eye, light, blurred)[1]))


@pytest.mark.parametrize("name", ["skin", "soft"])
def test_without_a_normal_map_light_goes_both_ways_alike(name):
    eye, light = directions(6, lowest=0.05), directions(7, lowest=0.05)
    there, back = (shading.SHADINGS[name](a, b, Finish()) for a, b in ((eye, light), (light, eye)))
    for one, other in zip(there, back, strict=True):
        np.testing.assert_allclose(of(one) / of(light.z), of(other) / of(eye.z), rtol=1e-3)


@pytest.mark.parametrize("scattering", [False, True])
@pytest.mark.parametrize("height", [1.0, 0.7, 0.4])
def test_a_white_furnace_gives_no_more_light_than_it_sends(height, scattering):
    """Over an albedo of 0.8, lighter than any skin is; Disney's diffuse lobe alone sends a few hundredths too much."""
    start()
    import mitsuba as mi

    eye = mi.Vector3f(float(np.sqrt(1 - height**2)), 0.0, height)
    light = directions(8, lowest=0.0)
    finish = (
        Finish(tilted(*SLOPE), scattering=(tilted(0.1, 0), tilted(0.2, -0.1), tilted(*SLOPE)))
        if scattering
        else Finish()
    )
    diffuse, specular = shading.soft(eye, light, finish)
    whole = np.atleast_2d(of(0.8 * diffuse + specular)).mean(axis=1) * 2 * np.pi
    assert whole.max() <= 1


def test_flat_and_even_slopes_stay_as_they_are():
    for slope in ((0.0, 0.0), SLOPE):
        normal = np.broadcast_to(
            np.array([*slope, 1.0], np.float32) / np.float32(np.sqrt(1 + np.square(slope).sum())), (64, 64, 3)
        )
        for axis, found in enumerate(blurred_slopes(normal, 1.2)):
            np.testing.assert_allclose(found, slope[axis], atol=1e-5)


def test_red_scatters_farthest_and_no_light_is_lost():
    slopes = np.random.default_rng(0).normal(0, 0.2, (256, 256, 2)).astype(np.float32)
    normal = np.concatenate([slopes, np.ones((256, 256, 1), np.float32)], axis=2)
    normal /= np.linalg.norm(normal, axis=2, keepdims=True)
    for axis, found in enumerate(blurred_slopes(normal, 1.2)):
        red, green, blue = found.std(axis=(0, 1))
        assert red < green < blue < slopes[..., axis].std()
        np.testing.assert_allclose(found.mean(axis=(0, 1)), slopes[..., axis].mean(), atol=2e-3)


def test_large_maps_are_blurred_as_small_ones_are(monkeypatch):
    rows = np.linspace(0, 6 * np.pi, 512)
    slopes = np.stack(np.broadcast_arrays(0.3 * np.sin(rows)[:, None], 0.2 * np.cos(rows)[None]), axis=2)
    normal = np.concatenate([slopes, np.ones((512, 512, 1))], axis=2).astype(np.float32)
    normal /= np.linalg.norm(normal, axis=2, keepdims=True)
    whole = blurred_slopes(normal, 1.2)
    monkeypatch.setattr("render.scattering.MOST", 256)
    for large, small in zip(whole, blurred_slopes(normal, 1.2), strict=True):
        assert small.shape == (256, 256, 3)
        np.testing.assert_allclose(small, large.reshape(256, 2, 256, 2, 3).mean(axis=(1, 3)), atol=0.01)


@pytest.fixture(scope="module")
def ball():
    return lumpy_head()


def test_spread_does_not_depend_on_the_unit_and_follows_the_chart(ball):
    vertices, topology = ball
    here = spread(topology, vertices)
    assert spread(topology, 100 * vertices) == pytest.approx(here)
    half = Topology(topology.faces, topology.uv / 2, topology.face_uv)
    assert spread(half, vertices) == pytest.approx(here / 2)
    assert 0 < here * max(WIDTHS) < 0.05


def test_paired_renders_are_the_separate_ones(ball):
    """To the bit, with light that scatters."""
    vertices, topology = ball
    rng = np.random.default_rng(1)
    renderer = PairedRenderer(topology, frame_of(vertices), ["side"], "soft", 32)
    renderer.pose(vertices)
    skins = [upload(maps(rng), spread(topology, vertices)) for _ in range(2)]
    together = renderer.render(skins, VIEWS[0], "side", 16, 3).linear
    for k, skin in enumerate(skins):
        np.testing.assert_array_equal(renderer.render([skin], VIEWS[0], "side", 16, 3).linear[0], together[k])
    assert np.abs(together[0] - together[1]).max() > 0


def maps(rng):
    normal = np.concatenate([rng.normal(0, 0.3, (32, 32, 2)), np.ones((32, 32, 1))], axis=2)
    normal = (normal / np.linalg.norm(normal, axis=2, keepdims=True)).astype(np.float32)
    return SkinMaps(np.full((8, 8, 3), 0.6, np.float32), normal)
