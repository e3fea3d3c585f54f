import numpy as np
import pytest

from facezip.files.srgb import decode_srgb
from render.operator import image_operator
from render.paired import PairedRenderer
from render.skins import SkinMaps, upload
from scenes.cameras import VIEWS, frame_of

SPP = 4


@pytest.fixture(scope="module", params=["diffuse", "skin"])
def paired(head, request):
    vertices, topology = head
    renderer = PairedRenderer(topology, frame_of(vertices), ["studio", "daylight"], request.param, 48)
    renderer.pose(vertices)
    return request.param, renderer


@pytest.fixture(scope="module")
def operator(paired, texture):
    return image_operator(paired[1], upload(SkinMaps(texture)), VIEWS[1], "studio", SPP, 5)


def random(*shape, seed=0):
    return np.random.default_rng(seed).random(shape, dtype=np.float32)


@pytest.mark.parametrize("rig", ["studio", "daylight"])
@pytest.mark.parametrize("size", [(64, 64), (33, 80)])
def test_it_gives_the_image_of_the_renderer(paired, rig, size):
    _, renderer = paired
    encoded = random(*size, 3)
    image = renderer.render([upload(SkinMaps(encoded))], VIEWS[0], rig, SPP, 3)
    operator = image_operator(renderer, upload(SkinMaps(encoded)), VIEWS[0], rig, SPP, 3)
    assert image.linear.max() > 0.3
    np.testing.assert_allclose(operator.image(decode_srgb(encoded)), image.linear[0], atol=2e-6)
    np.testing.assert_array_equal(operator.coverage, image.coverage)


def test_it_holds_what_the_other_maps_do(paired):
    _, renderer = paired
    slopes = 0.3 * random(16, 16, 2, seed=6) - np.float32(0.15)
    normal = np.concatenate([slopes, np.ones((16, 16, 1), np.float32)], axis=2)
    normal /= np.linalg.norm(normal, axis=2, keepdims=True)
    encoded = random(32, 32, 3, seed=7)
    maps = SkinMaps(encoded, normal, *(random(8, 8, 1, seed=seed) for seed in (8, 9, 10)))
    image = renderer.render([upload(maps)], VIEWS[0], "studio", SPP, 3).linear[0]
    operator = image_operator(renderer, upload(maps), VIEWS[0], "studio", SPP, 3)
    np.testing.assert_allclose(operator.image(decode_srgb(encoded)), image, atol=2e-6)


def test_its_transpose_is_the_adjoint(operator):
    x, y = random(*operator.texture_size, 3, seed=1), random(*operator.specular.shape, seed=2)
    forward = np.vdot(operator.apply(x).astype(np.float64), y)
    assert forward > 0
    assert np.vdot(x.astype(np.float64), operator.transposed(y)) == pytest.approx(forward, rel=1e-6)


def test_it_is_linear(operator):
    a, b = (random(*operator.texture_size, 3, seed=seed) for seed in (3, 4))
    np.testing.assert_allclose(
        operator.apply(a + 2 * b), operator.apply(a) + 2 * operator.apply(b), rtol=1e-5, atol=1e-6
    )


def test_only_a_sheen_shines_without_albedo(paired, operator):
    assert (operator.specular.max() > 0) == (paired[0] == "skin")


def test_every_pixel_looks_up_a_texel_once(operator):
    red = operator.channels[0]
    for matrix in operator.channels:
        np.testing.assert_array_equal(matrix.indices, red.indices)
    rows = np.split(red.indices, red.indptr[1:-1])
    assert all((np.diff(row) > 0).all() for row in rows)
    assert [len(row) > 0 for row in rows] == (operator.coverage > 0).ravel().tolist()


def test_equal_seeds_give_equal_bits(paired, operator, texture):
    again = image_operator(paired[1], upload(SkinMaps(texture)), VIEWS[1], "studio", SPP, 5)
    for one, other in zip(operator.channels, again.channels, strict=True):
        np.testing.assert_array_equal(one.data, other.data)
        np.testing.assert_array_equal(one.indices, other.indices)
