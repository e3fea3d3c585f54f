"""The BSDF that is written out, against Mitsuba's own."""

import numpy as np
import pytest

from render.llvm import start
from render.shading import DIFFUSE_CAVITY, SHADINGS, Finish
from scenes.materials import MATERIALS

COUNT = 4096


def directions(seed, lowest=-1.0):
    """``COUNT`` unit vectors, z from ``lowest`` to 1."""
    start()
    import mitsuba as mi

    rng = np.random.default_rng(seed)
    z, turn = rng.uniform(lowest, 1, COUNT), rng.uniform(0, 2 * np.pi, COUNT)
    flat = np.sqrt(1 - z**2)
    return mi.Vector3f(*(values.astype(np.float32) for values in (flat * np.cos(turn), flat * np.sin(turn), z)))


def theirs(bsdf, eye, light):
    import drjit as dr
    import mitsuba as mi

    surface = dr.zeros(mi.SurfaceInteraction3f, COUNT)
    surface.sh_frame, surface.wi, surface.t = mi.Frame3f(mi.Vector3f(0, 0, 1)), eye, mi.Float(1)
    return np.array(mi.load_dict(bsdf).eval(mi.BSDFContext(), surface, light))[0]


def ours(material, eye, light, finish, albedo):
    diffuse, specular = SHADINGS[material](eye, light, finish)
    return np.broadcast_to(np.array(albedo * diffuse + specular), COUNT)


def principled(albedo, roughness, specular):
    return {
        "type": "principled",
        "base_color": {"type": "rgb", "value": albedo},
        "roughness": roughness,
        "specular": specular,
    }


@pytest.mark.parametrize("material", list(MATERIALS))
@pytest.mark.parametrize("albedo", [0.0, 0.3, 1.0])
def test_without_maps_it_is_the_material(material, albedo):
    eye, light = directions(0, lowest=0.01), directions(1)
    expected = theirs(MATERIALS[material]({"type": "rgb", "value": albedo})["bsdf"], eye, light)
    assert (expected > 0).any() == (albedo > 0 or material != "diffuse")
    np.testing.assert_allclose(ours(material, eye, light, Finish(), albedo), expected, rtol=3e-4, atol=1e-6)


@pytest.mark.parametrize(("roughness", "specular"), [(0.1, 0.5), (0.3, 1.0), (0.6, 0.2), (1.0, 0.35), (0.02, 0.8)])
def test_roughness_and_specular_are_mitsubas(roughness, specular):
    eye, light = directions(2, lowest=0.01), directions(3)
    expected = theirs(principled(0.5, roughness, specular), eye, light)
    finish = Finish(roughness=roughness, specular=specular)
    np.testing.assert_allclose(ours("skin", eye, light, finish, 0.5), expected, rtol=2e-3, atol=1e-6)


@pytest.mark.parametrize("material", list(MATERIALS))
@pytest.mark.parametrize("slope", [(0.3, -0.1), (-1.5, 1.0), (4.0, 0.0)])
def test_a_normal_is_mitsubas(material, slope):
    import mitsuba as mi

    normal = np.array([*slope, 1]) / np.linalg.norm([*slope, 1])
    eye, light = directions(4, lowest=0.01), directions(5)
    texture = {"type": "bitmap", "raw": True, "format": "variant"}
    texture["data"] = mi.TensorXf((0.5 * normal + 0.5).astype(np.float32).reshape(1, 1, 3))
    inner = MATERIALS[material]({"type": "rgb", "value": 0.4})["bsdf"]
    expected = theirs({"type": "normalmap", "normalmap": texture, "bsdf": inner}, eye, light)
    found = ours(material, eye, light, Finish(mi.Vector3f(*normal.tolist())), 0.4)
    assert 0.05 < (expected > 0).mean() < 0.6
    np.testing.assert_allclose(found, expected, rtol=2e-3, atol=2e-5)


def test_specular_is_the_reflectance_at_normal_incidence():
    import mitsuba as mi

    up = mi.Vector3f(0, 0, 1)
    for specular in (0.0, 0.35, 0.5, 1.0):
        finish = Finish(roughness=1.0, specular=specular)
        highlight = float(np.array(SHADINGS["skin"](up, up, finish)[1]).item())
        # At normal incidence D = 1 / π and G = 1 for α = 1.
        assert 4 * np.pi * highlight == pytest.approx(0.08 * specular, abs=1e-6)


@pytest.mark.parametrize("cavity", [0.0, 0.4, 1.0])
def test_a_cavity_takes_the_highlight_and_less_of_the_rest(cavity):
    eye, light = directions(6, lowest=0.01), directions(7, lowest=0.01)
    open_, closed = (SHADINGS["skin"](eye, light, Finish(cavity=value)) for value in (1.0, cavity))
    np.testing.assert_allclose(np.array(closed[1]), cavity * np.array(open_[1]), rtol=1e-6)
    np.testing.assert_allclose(np.array(closed[0]), (1 - DIFFUSE_CAVITY * (1 - cavity)) * np.array(open_[0]), rtol=1e-6)


def test_a_matte_skin_has_no_use_for_roughness_and_specular():
    eye, light = directions(8, lowest=0.01), directions(9)
    found = [ours("diffuse", eye, light, Finish(roughness=r, specular=s), 0.5) for r, s in ((0.1, 1.0), (0.9, 0.0))]
    np.testing.assert_array_equal(*found)
