"""What ``bench shader`` draws is what it says: both ways of a blend, on as many fetches, timed part by part."""

import numpy as np
import pytest

from facezip import FaceZipError
from facezip.errors import ErrorCode
from facezip.export.opengl import devices, opened
from facezip.export.shading import Shading
from facezip.export.timing import Clock, bench_shader
from facezip.files.srgb import decode_srgb
from tests.facezip.export.gpu import software

SIDE, COUNT = 64, 5


@pytest.fixture(scope="module")
def context():
    with software() as context:
        yield context


@pytest.fixture
def shading(context):
    made = Shading(context, COUNT, SIDE)
    yield made
    made.release()


def texels(texture, shape, dtype=np.uint8):
    return np.frombuffer(texture.read(), dtype).reshape(*shape, 4)


def drawn(shading, name, weights):
    shading.show(np.array(weights, np.float32))
    one = shading.passes()[name]
    one.draw(0, one.rows)


def test_all_textures_are_blended(shading):
    weights = (0.5, 0.0, -0.25, 0.125, 0.0)
    drawn(shading, "textures", weights)
    every = texels(shading.every, (COUNT + 1, SIDE, SIDE))[..., :3] / 255
    blend = every[0] + np.tensordot(weights, every[1:] - every[0], 1)
    found = texels(shading.picture, (SIDE, SIDE))[..., :3]
    assert np.abs(found - 255 * decode_srgb(np.clip(blend, 0, 1).astype(np.float32))).max() <= 1


def test_the_pre_pass_is_the_combination_of_the_weight_maps(shading):
    weights = (0.5, 0.0, -0.25, 1.0, 0.0)
    drawn(shading, "prepass", weights)
    side = SIDE // 8
    atlas = 2.0 * texels(shading.atlas, (2 * side, 3 * side)) / 255 - 1
    corners = [(side * (n // 3), side * (n % 3)) for n in range(COUNT)]
    maps = [atlas[top : top + side, left : left + side] for top, left in corners]
    found = texels(shading.weights, (side, side), np.float16)
    np.testing.assert_allclose(found, np.tensordot(weights, maps, 1), atol=2e-3)


def test_no_weight_leaves_the_neutral(shading):
    for name in ("prepass", "blend"):
        drawn(shading, name, np.zeros(COUNT))
    neutral = decode_srgb((texels(shading.maps[0], (SIDE, SIDE))[..., :3] / 255).astype(np.float32))
    assert np.abs(texels(shading.picture, (SIDE, SIDE))[..., :3] - 255 * neutral).max() <= 1


def test_parts_of_a_picture_are_the_picture(shading):
    drawn(shading, "textures", np.full(COUNT, 0.2))
    whole = shading.picture.read()
    one = shading.passes()["textures"]
    shading.picture.write(bytes(4 * SIDE * SIDE))
    for first in range(0, SIDE, 16):
        one.draw(first, first + 16)
    assert shading.picture.read() == whole


def test_a_picture_in_parts_takes_all_of_their_time(context, shading):
    assert Clock(context, shading.passes()["textures"], queried=False).seconds() > 0
    clock = Clock(context, shading.passes()["textures"], queried=True)
    clock._parts, clock._frames = SIDE, 1
    asked = []
    clock._part = lambda first, last: asked.append((first, last)) or 1.0
    assert clock.seconds() == SIDE
    assert asked == [(row, row + 1) for row in range(SIDE)]


def test_the_answer_is_of_the_device_that_drew(context):
    document = bench_shader(SIDE, (3, 9), repeats=2)
    assert document.device.renderer == context.info["GL_RENDERER"]
    assert document.device.software == devices()[document.device.index].is_software
    assert [row.expressions for row in document.rows] == [3, 9]
    for row in document.rows:
        assert row.facezip_ms == row.prepass_ms + row.blend_ms > 0
        assert row.ratio == row.facezip_ms / row.textures_ms
        assert row.ratio_few == row.facezip_ms / row.textures_few_ms
        assert row.bytes_textures == 4 * SIDE**2 * (1 + row.expressions)


def test_another_device_is_refused(context):
    with pytest.raises(FaceZipError, match=f"no device 1000, EGL lists {len(devices())}") as caught, opened(1000):
        pass
    assert caught.value.code is ErrorCode.NO_GPU
