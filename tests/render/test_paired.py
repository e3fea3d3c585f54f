import hashlib
import os
import subprocess
import sys

import numpy as np
import pytest

from facezip.character.gltf import vertex_normals
from facezip.files.srgb import decode_srgb
from render.paired import TRANSPORTS, PairedRenderer, stratified
from render.skins import SkinMaps, upload
from scenes.cameras import VIEWS, camera, frame_of
from scenes.lights import RIGS
from scenes.materials import MATERIALS
from scenes.stage import stage

FRONT = VIEWS[0]


def shade(renderer, textures, *arguments):
    return renderer.render([upload(SkinMaps(texture)) for texture in textures], *arguments)


@pytest.mark.parametrize("rig", list(RIGS))
def test_equal_textures_give_equal_bits(renderer, texture, rig):
    images = shade(renderer, [texture, texture.copy()], FRONT, rig, 4, 0).linear
    np.testing.assert_array_equal(images[0], images[1])


def test_other_textures_do_not_change_an_image(renderer, texture):
    alone = shade(renderer, [texture], FRONT, "studio", 4, 0).linear[0]
    together = shade(renderer, [texture[::-1].copy(), texture, texture * 0.5], FRONT, "studio", 4, 0).linear[1]
    np.testing.assert_array_equal(alone, together)


def test_a_seed_repeats_and_another_differs(renderer, texture):
    first, again, other = (shade(renderer, [texture], FRONT, "studio", 4, seed).linear for seed in (3, 3, 4))
    np.testing.assert_array_equal(first, again)
    assert (first != other).any()


DIGEST = """
import hashlib, sys
from render.llvm import start
start()
import drjit as dr
dr.set_thread_count(int(sys.argv[1]))
import numpy as np
from tests.render.conftest import lumpy_head
from render.paired import TRANSPORTS, PairedRenderer, stratified
from render.skins import SkinMaps, upload
from scenes.cameras import VIEWS, frame_of
vertices, topology = lumpy_head()
texture = np.random.default_rng(0).random((32, 32, 3), dtype=np.float32)
digest = hashlib.sha256()
for transport in ("direct", "full"):
    renderer = PairedRenderer(topology, frame_of(vertices), ["studio"], "skin", 48, transport)
    renderer.pose(vertices)
    digest.update(renderer.render([upload(SkinMaps(texture))], VIEWS[1], "studio", 4, 0).linear.tobytes())
print(digest.hexdigest())
"""


def test_the_number_of_threads_changes_no_bit():
    digests = [
        subprocess.run(
            [sys.executable, "-c", DIGEST, threads],
            capture_output=True,
            text=True,
            timeout=200,
            check=True,
            cwd=os.getcwd(),
        ).stdout
        for threads in ("1", "2", "5")
    ]
    assert len({*digests}) == 1
    assert len(digests[0].strip()) == len(hashlib.sha256().hexdigest())


def test_an_image_is_affine_in_its_linear_texture(renderer):
    black, grey_, white = (np.full((8, 8, 3), value, np.float32) for value in (0, 0.5, 1))
    images = shade(renderer, [black, grey_, white], FRONT, "studio", 4, 0).linear
    share = decode_srgb(grey_[:1, :1])[0, 0]
    np.testing.assert_allclose(images[1], images[0] + share * (images[2] - images[0]), atol=1e-5)


def test_the_top_of_the_texture_is_the_top_of_the_head(renderer):
    texture = np.zeros((16, 16, 3), np.float32)
    texture[:8] = [1, 0, 0]
    texture[8:] = [0, 1, 0]
    image = shade(renderer, [texture], FRONT, "daylight", 4, 0).linear[0]
    red, green = image[..., 0] - image[..., 1] > 0.05, image[..., 1] - image[..., 0] > 0.05
    assert np.argwhere(red)[:, 0].mean() < np.argwhere(green)[:, 0].mean() - 10


def test_the_right_of_the_texture_is_the_left_of_the_character(renderer):
    """The ball's u grows with x, and the character's left (+x) is right in the picture."""
    texture = np.zeros((16, 16, 3), np.float32)
    texture[:, 8:] = [1, 0, 0]
    texture[:, :8] = [0, 1, 0]
    image = shade(renderer, [texture], FRONT, "daylight", 4, 0).linear[0]
    red, green = image[..., 0] - image[..., 1] > 0.05, image[..., 1] - image[..., 0] > 0.05
    assert np.argwhere(red)[:, 1].mean() > np.argwhere(green)[:, 1].mean() + 10


@pytest.fixture(scope="module")
def coarse(head):
    """A renderer of a ball of radius 1, whose 23 sectors lie up to a hundredth inside of it."""
    vertices = head[0] / np.linalg.norm(head[0], axis=1, keepdims=True)
    renderer = PairedRenderer(head[1], frame_of(vertices), ["daylight"], "diffuse", 64)
    renderer.pose(vertices)
    return renderer


# Rows of a picture of the ball without its poles, where many triangles meet.
MIDDLE = slice(16, 48)


def test_points_lie_about_the_smooth_surface_and_not_on_its_triangles(coarse):
    """Shadows of triangles would show as teeth where light grazes the surface: shadow rays start above them."""
    import drjit as dr
    import mitsuba as mi

    pixel = dr.arange(mi.UInt32, 64 * 64)
    surface = coarse._points.met(coarse._rays(coarse._camera(FRONT), mi.Point2f(0.5), (0, 0, 64, 64), pixel))
    radius = np.where(np.array(surface.is_valid()), np.array(dr.norm(surface.p)), np.nan).reshape(64, 64)[MIDDLE]
    assert np.nanmin(radius) > 1 - 1e-3
    assert np.nanmax(radius) < 1.03


def test_outlines_are_not_black(coarse):
    """There a normal turns away from the eye before its triangle does; light comes from everywhere."""
    images = shade(coarse, [np.full((8, 8, 3), 0.7, np.float32)], FRONT, "daylight", 64, 0)
    light, coverage = images.linear[0].mean(axis=2)[MIDDLE], images.coverage[MIDDLE]
    lit = light[coverage > 0] / coverage[coverage > 0]
    assert lit.min() > 0.01


def bowl(vertices):
    """The ball with its front pushed in: a bowl in which light goes to and fro."""
    x, y, z = vertices.T
    return np.stack([x, y, np.where(z > 4, 8 - z, z)], axis=1).astype(np.float32)


LOOKS = [(material, rig, "direct") for material in MATERIALS for rig in RIGS]
LOOKS += [("skin", "studio", "full"), ("diffuse", "daylight", "full")]


@pytest.mark.parametrize(("material", "rig", "transport"), LOOKS)
def test_it_agrees_with_mitsubas_own_integrator(head, texture, material, rig, transport):
    import mitsuba as mi

    vertices, topology = head
    frame = frame_of(vertices)
    if transport == "full":
        vertices = bowl(vertices)
    paired = PairedRenderer(topology, frame, [rig], material, 32, transport)
    paired.pose(vertices)
    ours = shade(paired, [texture], FRONT, rig, 256, 0)
    bitmap = {"type": "bitmap", "data": mi.TensorXf(decode_srgb(texture)), "raw": True, "wrap_mode": "clamp"}
    depth = 2 if transport == "direct" else -1
    scene = stage(_textured((vertices, topology), MATERIALS[material](bitmap)), frame, rig, depth)
    scene = mi.load_dict(scene | {"sensor": camera(FRONT, frame, 32)})
    theirs = np.array(mi.render(scene, spp=256, seed=7))[..., :3]
    inside = ours.coverage == 1
    assert inside.sum() > 300
    assert np.mean(ours.linear[0][inside]) == pytest.approx(np.mean(theirs[inside]), rel=0.01)
    assert np.abs(ours.linear[0][inside] - theirs[inside]).mean() < 0.06 * theirs[inside].mean()


def _textured(head, bsdf):
    """The head as Mitsuba's own mesh with a textured material, rendered by nothing of ours."""
    import mitsuba as mi

    vertices, topology = head
    properties = mi.Properties()
    properties["bsdf"] = mi.load_dict(bsdf)
    mesh = mi.Mesh(
        "head", len(vertices), len(topology.faces), properties, has_vertex_normals=True, has_vertex_texcoords=True
    )
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = vertices.ravel()
    parameters["vertex_normals"] = vertex_normals(vertices, topology.faces).ravel()
    parameters["vertex_texcoords"] = (topology.uv * [1, -1] + [0, 1]).astype(np.float32).ravel()
    parameters["faces"] = topology.faces.astype(np.uint32).ravel()
    parameters.update()
    return mesh


def test_light_between_parts_of_the_skin_only_adds(head, texture):
    vertices, topology = head
    images = []
    for transport in TRANSPORTS:
        renderer = PairedRenderer(topology, frame_of(vertices), ["studio"], "diffuse", 32, transport)
        renderer.pose(bowl(vertices))
        images.append(shade(renderer, [texture, texture.copy(), texture * 0.5], FRONT, "studio", 16, 0).linear)
    direct, full = images
    assert (full[0].sum(axis=2) >= direct[0].sum(axis=2) - 1e-3).mean() > 0.9
    assert full[0].mean() > 1.03 * direct[0].mean()
    np.testing.assert_array_equal(full[0], full[1])


def test_every_pixel_of_the_head_knows_its_triangle(head, renderer, texture):
    vertices, topology = head
    triangles = renderer.triangles(FRONT)
    coverage = shade(renderer, [texture], FRONT, "studio", 4, 0).coverage
    assert (triangles >= 0)[coverage == 1].all()
    assert (triangles < 0)[coverage == 0].all()
    rows = np.argwhere(triangles >= 0)[:, 0]
    heights = vertices[topology.faces[triangles[triangles >= 0]]].mean(axis=1)[:, 1]
    assert np.corrcoef(rows, heights)[0, 1] < -0.99


@pytest.mark.parametrize("spp", [1, 2, 3, 4, 5, 7, 8, 11, 13, 16, 32, 64, 100])
def test_the_number_of_strata_is_that_of_the_sampler(renderer, spp):
    import mitsuba as mi

    sampler = mi.load_dict({"type": "multijitter", "sample_count": spp})
    assert sampler.sample_count() == stratified(spp)


def test_no_light_stands_before_a_camera(head, texture):
    vertices, topology = head
    renderer = PairedRenderer(topology, frame_of(vertices), list(RIGS), "skin", 32)
    renderer.pose(vertices)
    for view in VIEWS:
        covered = [shade(renderer, [texture], view, rig, 4, 0).coverage for rig in RIGS]
        np.testing.assert_array_equal(covered[0], covered[1])
        np.testing.assert_array_equal(covered[0], covered[2])
        assert covered[0].mean() > 0.3
