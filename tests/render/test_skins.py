from dataclasses import replace

import numpy as np
import pytest

from render.paired import TRANSPORTS, PairedRenderer
from render.skins import RENDERED, SkinMaps, upload
from scenes.cameras import VIEWS, frame_of
from scenes.materials import MATERIALS, ROUGHNESS, SPECULAR
from tests.facezip.conftest import grid_topology

FRONT = VIEWS[0]


def constant(*values, side=16):
    return np.tile(np.array(values, np.float32), (side, side, 1))


def random_maps(seed, texture, side=32):
    """All maps, each of its own size."""
    rng = np.random.default_rng(seed)
    slopes = rng.normal(0, 0.2, (side, side, 2))
    normal = np.concatenate([slopes, np.ones((side, side, 1))], axis=2)
    normal /= np.linalg.norm(normal, axis=2, keepdims=True)
    roughness, specular, cavity = (rng.uniform(0.2, 1, (side // n, side, 1)).astype(np.float32) for n in (1, 2, 4))
    return SkinMaps(texture, normal.astype(np.float32), roughness, specular, cavity)


def shade(renderer, skins, view=FRONT, rig="studio", spp=4):
    return renderer.render([upload(maps) for maps in skins], view, rig, spp, 0).linear


@pytest.mark.parametrize(("material", "transport"), [("skin", "direct"), ("diffuse", "direct"), ("skin", "full")])
def test_maps_that_say_what_the_material_says_change_nothing(head, texture, material, transport):
    vertices, topology = head
    renderer = PairedRenderer(topology, frame_of(vertices), ["studio"], material, 48, transport)
    renderer.pose(vertices)
    maps = SkinMaps(texture, constant(0, 0, 1), constant(ROUGHNESS), constant(SPECULAR), constant(1))
    plain, every = shade(renderer, [SkinMaps(texture), maps])
    np.testing.assert_allclose(every, plain, atol=2e-6)


@pytest.mark.parametrize("material", list(MATERIALS))
@pytest.mark.parametrize("transport", list(TRANSPORTS))
def test_equal_skins_give_equal_bits(head, texture, material, transport):
    vertices, topology = head
    renderer = PairedRenderer(topology, frame_of(vertices), ["side"], material, 32, transport)
    renderer.pose(vertices)
    maps = random_maps(0, texture)
    copy = SkinMaps(**{name: values.copy() for name, values in maps.present.items()})
    original, other, same = shade(renderer, [maps, random_maps(1, texture), copy], rig="side")
    np.testing.assert_array_equal(same, original)
    assert np.abs(other - original).max() > 0.01


def test_what_skins_have_in_common_is_computed_once(renderer, texture):
    """A further albedo adds a lookup to the kernel, and no BSDF."""
    import drjit as dr

    def operations(skins):
        with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
            dr.kernel_history_clear()
            shade(renderer, skins)
            return max(kernel.get("operation_count", 0) for kernel in dr.kernel_history())

    plain, every = SkinMaps(texture), random_maps(5, texture)
    two, three, bumpy = (operations(skins) for skins in ([plain] * 2, [plain] * 3, [plain, plain, every]))
    assert 0 < three - two < (bumpy - two) / 3


@pytest.mark.parametrize("missing", [name for name in RENDERED if name != "albedo"])
def test_a_skin_does_not_depend_on_those_beside_it(renderer, texture, missing):
    maps = random_maps(2, texture)
    fewer = replace(maps, **{missing: None})
    beside = shade(renderer, [SkinMaps(texture), fewer, maps])
    np.testing.assert_array_equal(shade(renderer, [fewer])[0], beside[1])
    np.testing.assert_array_equal(shade(renderer, [maps])[0], beside[2])
    assert np.abs(beside[1] - beside[2]).max() > 1e-3


def test_a_normal_looks_along_u_and_up_v():
    """A sheet that faces the viewer, lit from its right or from above, is brighter where its normals turn there."""
    import mitsuba as mi

    topology = grid_topology(5)
    vertices = np.c_[topology.uv * 20 - 10, np.zeros(25)].astype(np.float32)
    renderer = PairedRenderer(topology, frame_of(vertices), ["studio"], "diffuse", 32)
    renderer.pose(vertices)
    ray = mi.Ray3f(mi.Point3f(1.0, 2.0, 10.0), mi.Vector3f(0.0, 0.0, -1.0))
    surface = renderer._points.met(ray)

    def seen(normal, light):
        skin = upload(SkinMaps(constant(0.5, 0.5, 0.5), constant(*normal)))
        (reflected,) = renderer._points.response(
            surface, [skin], surface.to_local(mi.Vector3f(*light)), mi.Color3f(1.0)
        )
        return float(np.array(reflected).ravel()[0])

    for light, towards in (((0.6, 0.0, 0.8), (0.1, 0.0, 0.995)), ((0.0, 0.6, 0.8), (0.0, 0.1, 0.995))):
        away = [-towards[0], -towards[1], towards[2]]
        ratio = seen(towards, light) / seen(away, light)
        assert ratio == pytest.approx(np.dot(towards, light) / np.dot(away, light), rel=0.01)


def test_a_mirrored_chart_with_mirrored_maps_is_the_same_skin(head, texture):
    vertices, topology = head
    maps = random_maps(3, texture)
    flipped = SkinMaps(**{name: values[:, ::-1].copy() for name, values in maps.present.items()})
    flipped = replace(flipped, normal=flipped.normal * np.array([-1, 1, 1], np.float32))
    mirrored = replace(topology, uv=topology.uv * np.array([-1, 1], np.float32) + np.array([1, 0], np.float32))
    images = []
    for layout, skin in ((topology, maps), (mirrored, flipped)):
        renderer = PairedRenderer(layout, frame_of(vertices), ["side"], "skin", 48)
        renderer.pose(vertices)
        images.append(shade(renderer, [skin], rig="side")[0])
    np.testing.assert_allclose(images[0], images[1], atol=1e-4)


def test_faces_that_are_wound_the_other_way_are_the_same_skin(head, texture):
    vertices, topology = head
    turned = replace(topology, faces=topology.faces[:, ::-1].copy(), face_uv=topology.face_uv[:, ::-1].copy())
    images = []
    for layout in (topology, turned):
        renderer = PairedRenderer(layout, frame_of(vertices), ["studio"], "skin", 48)
        renderer.pose(vertices)
        images.append(shade(renderer, [random_maps(4, texture)])[0])
    assert images[0].max() > 0.2
    np.testing.assert_allclose(images[0], images[1], atol=1e-4)


@pytest.mark.parametrize("name", RENDERED)
def test_maps_end_at_their_borders(name):
    """What lies at the left border, or left of it, is not mixed with what lies at the right one."""
    import mitsuba as mi

    values = np.linspace(0.2, 0.8, 4, dtype=np.float32)[None, :, None] * np.ones((4, 1, 1), np.float32)
    values = values * np.array([1, 2, 0.5], np.float32) if name == "normal" else values
    skin = upload(SkinMaps(**{"albedo": constant(0.5), name: values}))
    for inside, beyond in ((0.125, (0.0, -0.3)), (0.875, (1.0, 1.3))):
        expected, *found = (np.array(skin.textures[name].eval(mi.Point2f(u, 0.5))) for u in (inside, *beyond))
        for one in found:
            np.testing.assert_array_equal(one, expected)
    assert not np.array_equal(*(np.array(skin.textures[name].eval(mi.Point2f(u, 0.5))) for u in (0, 1)))


@pytest.mark.parametrize(
    ("name", "dull", "bright"), [("roughness", 0.7, 0.25), ("specular", 0.2, 0.8), ("cavity", 0.2, 1)]
)
def test_what_makes_a_highlight_brighter(renderer, texture, name, dull, bright):
    images = shade(renderer, [SkinMaps(texture, **{name: constant(value)}) for value in (dull, bright)], spp=16)
    assert images[1].max() > 1.1 * images[0].max()
