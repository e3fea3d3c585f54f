"""The head under flat light, pixel by pixel: eq. 7 and 8, a rasteriser of our own and `model.blend` on the CPU."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import facezip
from scenes.character import make_character
from tests.browser.conftest import viewing
from tests.browser.rasterise import seen_uv

CAPTURE = Path(__file__).parents[3] / "shared" / "data" / "capture_a"
SEEN = """() => {
  const { stage } = facezip, { camera } = stage.orbit;
  return {
    vertices: Array.from(stage.face.vertices),
    projection: camera.projectionMatrix.elements,
    view: camera.matrixWorldInverse.elements,
    bits: stage.renderer.getContext().getParameter(WebGLRenderingContext.SUBPIXEL_BITS),
  };
}"""


def sampled(model, uv):
    """The model whose maps are those of ``model`` as a GPU samples them at ``(P, 2)`` texture coordinates."""
    maps = (model.neutral[None], model.differences, model.weights)
    neutral, differences, weights = (np.stack([bilinear(texture, uv) for texture in some])[:, None] for some in maps)
    return replace(model, neutral=neutral[0], differences=differences, weights=weights, meshes=None)


def bilinear(texture, uv):
    """``(P, C)`` samples of a texture with clamped borders at ``(P, 2)`` texture coordinates, v up."""
    height, width, _ = texture.shape
    at = np.clip(np.c_[1 - uv[:, 1], uv[:, 0]] * [height, width] - 0.5, 0, [height - 1, width - 1])
    (top, left), (y, x) = np.floor(at).astype(int).T, (at % 1).astype(np.float32).T[..., None]
    bottom, right = np.minimum(top + 1, height - 1), np.minimum(left + 1, width - 1)
    upper = texture[top, left] * (1 - x) + texture[top, right] * x
    return upper * (1 - y) + (texture[bottom, left] * (1 - x) + texture[bottom, right] * x) * y


def unbroken(uv, reach):
    """Pixels whose neighbours show the same surface: no silhouette, fold or seam there, which antialiasing mixes."""
    inside = np.zeros(uv.shape[:2], bool)
    centre = uv[1:-1, 1:-1]
    shifts = [uv[1 + y : uv.shape[0] - 1 + y, 1 + x : uv.shape[1] - 1 + x] for y in (-1, 0, 1) for x in (-1, 0, 1)]
    inside[1:-1, 1:-1] = np.all([np.abs(shift - centre).max(2) < reach for shift in shifts], axis=0)
    return inside


def head_errors(context, pack, blend):
    """Absolute errors of 255, ``(P, 3)``, of the flat-lit head at pixels that are wholly one surface."""
    model = facezip.read_pack(pack)
    with viewing(context, pack) as viewer:
        viewer.choose("Light", "Flat")
        viewer.switch("Mip-maps", False)
        viewer.slide(blend)
        pixels = viewer.pixels()
        page = viewer.page.evaluate(SEEN)
    betas = np.array([blend.get(name, 0) for name in model.expressions])
    vertices = model.meshes.neutral + np.tensordot(betas, model.meshes.deltas, 1)
    shown = np.reshape(page["vertices"], (-1, 3))
    np.testing.assert_allclose(shown, vertices, atol=1e-4 * np.ptp(vertices))
    # As the page has them: where rounding decides on a subpixel, half a step of 16 bits can decide otherwise.
    matrices = (np.reshape(page[name], (4, 4)).T for name in ("projection", "view"))
    uv = seen_uv(shown, model.meshes.topology, *matrices, pixels.shape[:2], page["bits"])
    seen = unbroken(uv, reach=0.01)
    assert seen.sum() > 0.5 * np.isfinite(uv[..., 0]).sum()
    return np.abs(255 * sampled(model, uv[seen]).blend(blend)[0] - pixels[seen][:, :3])


@pytest.fixture(scope="module")
def pack(tmp_path_factory):
    """The embedded character."""
    path = tmp_path_factory.mktemp("head") / "embedded.facezip"
    facezip.write_pack(facezip.compress(make_character(128, 4)), path)
    return path


@pytest.mark.parametrize("blend", [{"smile": 1.0}, {"laugh": 0.5, "frown": 0.4}])
def test_the_flat_lit_head_shows_the_blend(context, pack, blend):
    assert head_errors(context, pack, blend).max() <= 2


@pytest.mark.skipif(not CAPTURE.is_dir(), reason="the real capture is not here")
def test_the_real_capture_shows_the_blend(context, tmp_path):
    facezip.write_pack(facezip.compress(facezip.load_character(CAPTURE)), tmp_path / "capture.facezip")
    first, second, *_ = facezip.read_pack(tmp_path / "capture.facezip").expressions
    assert head_errors(context, tmp_path / "capture.facezip", {first: 0.4, second: 0.7}).max() <= 2
