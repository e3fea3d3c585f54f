"""GPUs that lack something: the same picture by another way, or words that say what is shown instead."""

import numpy as np
import pytest

from facezip.pack.read import read_pack
from facezip.pack.write import write_pack
from tests.browser.conftest import viewing
from tests.browser.test_pixels import BLENDS, assert_layouts, lay_flat
from tests.facezip.viewer.models import random_maps, random_scans

# What a GPU without them answers, and does.
LIMIT = """const kind = WebGL2RenderingContext.prototype, ask = kind.getParameter;
kind.getParameter = function (name) { return name === this.MAX_TEXTURE_SIZE ? LIMIT : ask.call(this, name); };
for (const name of ["texStorage2D", "texStorage3D", "texImage2D"]) {
  const make = kind[name];
  kind[name] = function (...a) { if (!(Math.max(a[3], a[4]) > LIMIT)) make.apply(this, a); };
}"""
FLOATS = """const kind = WebGL2RenderingContext.prototype, ask = kind.getExtension;
kind.getExtension = function (name) {
  return /color_buffer_(half_)?float$/.test(name) ? null : ask.call(this, name);
};"""


def words(viewer):
    return viewer.page.locator("#limits li").all_text_contents()


@pytest.fixture
def pack(tmp_path):
    model = random_maps(size=(32, 48), weights=(8, 12), expressions=6, tiles=(1001, 1002), slots=6)
    write_pack(model, tmp_path / "random.facezip")
    return tmp_path / "random.facezip"


@pytest.mark.parametrize(("weights", "masks"), [((8, 12), 0), ((1, 1), 0), ((8, 12), 9)])
def test_without_floats_to_draw_into_the_blend_is_the_same(context, tmp_path, weights, masks):
    model = random_maps(size=(32, 48), weights=weights, tiles=(1001, 1002), slots=6, masks=masks)
    write_pack(model, tmp_path / "a.facezip")
    with viewing(context, tmp_path / "a.facezip", script=FLOATS) as viewer:
        assert_layouts(viewer, read_pack(tmp_path / "a.facezip"), BLENDS)
        assert words(viewer) == []


def test_without_floats_it_is_said_that_originals_are_not_shown(context, pack):
    with viewing(context, pack, random_scans(read_pack(pack)), script=FLOATS) as viewer:
        assert words(viewer) == ["This GPU draws no floating-point numbers: the originals cannot be shown."]
        assert viewer.page.get_by_text("Original", exact=True).count() == 0


def test_weight_maps_lie_in_as_many_layers_as_the_limit_asks_for(context, pack):
    with viewing(context, pack, script=LIMIT.replace("LIMIT", "64")) as viewer:
        assert words(viewer) == ["This GPU takes textures of up to 64 texels: shadows are coarse."]
        assert_layouts(viewer, read_pack(pack), BLENDS)


def test_masks_lie_in_as_many_layers_as_the_limit_asks_for(context, tmp_path):
    write_pack(random_maps(size=(32, 48), weights=(8, 12), slots=6, masks=45), tmp_path / "a.facezip")
    with viewing(context, tmp_path / "a.facezip", script=LIMIT.replace("LIMIT", "64")) as viewer:
        assert_layouts(viewer, read_pack(tmp_path / "a.facezip"), BLENDS)


@pytest.mark.parametrize("floats", [True, False])
def test_weight_maps_larger_than_a_texture_may_be_are_refused_in_words(context, tmp_path, floats):
    write_pack(random_maps(size=(32, 48), weights=(32, 48)), tmp_path / "a.facezip")
    lacking = LIMIT.replace("LIMIT", "32") + ("" if floats else f"\n{{ {FLOATS} }}")
    with viewing(context, tmp_path / "a.facezip", script=lacking) as viewer:
        said = viewer.page.locator("#status").text_content()
        assert "this GPU takes textures of up to 32 texels, a weight map has 48 × 32" in said


def test_a_shader_that_the_driver_refuses_is_said(context, pack):
    refusing = """const kind = WebGL2RenderingContext.prototype, give = kind.shaderSource;
kind.shaderSource = function (shader, text) { give.call(this, shader, text.replace("albedo_or_clay", "#error")); };"""
    with viewing(context, pack, script=refusing) as viewer:
        viewer.page.locator("#limits li").first.wait_for()
        assert words(viewer) == ["Not everything is shown: this GPU does not take a shader of this page."]


def test_textures_that_are_too_large_are_shown_smaller_and_it_is_said(context, pack):
    model, blend = read_pack(pack), {"expr_1": 0.5}
    with viewing(context, pack, script=LIMIT.replace("LIMIT", "32")) as viewer:
        assert "they are shown at 1/2 of their size" in words(viewer)[0]
        lay_flat(viewer, model)
        viewer.slide(blend)
        shown = viewer.layout(1).astype(float)
    assert shown.shape == (16, 24, 3)
    expected = 255 * model.blend(blend, tile=1002)
    # Values are random: what is smaller has their means, within what filters differ in.
    assert np.abs(shown.mean(axis=(0, 1)) - expected.mean(axis=(0, 1))).max() < 5
