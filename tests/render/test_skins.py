import numpy as np
import pytest

from render.paired import PairedRenderer, upload
from render.skins import SkinMaps, upload_skin
from scenes.cameras import VIEWS, frame_of
from tests.facezip.conftest import grid_topology

FLAT = np.broadcast_to(np.array([0, 0, 1], np.float32), (16, 16, 3))


@pytest.mark.parametrize(("material", "transport"), [("skin", "direct"), ("diffuse", "direct"), ("skin", "full")])
def test_flat_normals_and_the_materials_roughness_give_the_image_of_the_albedo(head, texture, material, transport):
    vertices, topology = head
    renderer = PairedRenderer(topology, frame_of(vertices), ["studio"], material, 48, transport)
    renderer.pose(vertices)
    fast = renderer.render([upload(texture)], VIEWS[0], "studio", 4, 0).linear[0]
    rough = np.full((16, 16, 1), 0.48, np.float32)
    skins = [upload_skin(one, material) for one in (SkinMaps(texture), SkinMaps(texture, FLAT, rough))]
    for image in renderer.render(skins, VIEWS[0], "studio", 4, 0).linear:
        np.testing.assert_allclose(image, fast, atol=2e-6)


def test_a_skin_does_not_depend_on_those_beside_it(renderer, texture):
    tilted = np.tile(np.array([0.3, 0.1, 0.95], np.float32), (16, 16, 1))
    one, other = (upload_skin(SkinMaps(texture, normal), "skin") for normal in (FLAT, tilted))
    alone = renderer.render([other], VIEWS[0], "studio", 4, 0).linear[0]
    beside = renderer.render([one, other], VIEWS[0], "studio", 4, 0).linear
    np.testing.assert_array_equal(beside[1], alone)
    assert np.abs(beside[0] - beside[1]).max() > 0.01


def test_a_normal_looks_along_u_and_up_v():
    """A sheet that faces the viewer, lit from its right or from above, is brighter where its normals turn there."""
    import mitsuba as mi

    topology = grid_topology(5)
    vertices = np.c_[topology.uv * 20 - 10, np.zeros(25)].astype(np.float32)
    renderer = PairedRenderer(topology, frame_of(vertices), ["studio"], "diffuse", 32)
    renderer.pose(vertices)
    ray = mi.Ray3f(mi.Point3f(1.0, 2.0, 10.0), mi.Vector3f(0.0, 0.0, -1.0))
    surface = renderer._scene.ray_intersect(ray, int(mi.RayFlags.All), True, True)

    def seen(normal, light):
        maps = SkinMaps(np.full((8, 8, 3), 0.5, np.float32), np.tile(np.array(normal, np.float32), (8, 8, 1)))
        skin = upload_skin(maps, "diffuse")
        direction = surface.to_local(mi.Vector3f(*light))
        return float(np.array(skin.eval(mi.BSDFContext(), surface, direction, True)).ravel()[0])

    for light, towards in (((0.6, 0.0, 0.8), (0.3, 0.0, 0.954)), ((0.0, 0.6, 0.8), (0.0, 0.3, 0.954))):
        away = [-towards[0], -towards[1], towards[2]]
        ratio = seen(towards, light) / seen(away, light)
        assert ratio == pytest.approx(np.dot(towards, light) / np.dot(away, light), rel=0.01)


def test_a_smoother_skin_has_the_brighter_highlight(renderer, texture):
    rough, smooth = (
        upload_skin(SkinMaps(texture, None, np.full((16, 16, 1), value, np.float32)), "skin") for value in (0.7, 0.25)
    )
    images = renderer.render([rough, smooth], VIEWS[0], "studio", 16, 0).linear
    assert images[1].max() > 1.2 * images[0].max()
