"""The flat head, pixel by pixel and map by map: eq. 7 and 8, a rasteriser of our own and `model.blend` on the CPU."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import facezip
from facezip.character.neutrals import packed_neutral, unpacked_neutral
from facezip.character.tiles import place_of, tiles_of_faces
from facezip.pack.model import Part
from scenes.character import make_character
from scenes.face.capture import MAPS
from scenes.tiles import in_tiles
from tests.browser.conftest import viewing
from tests.browser.rasterise import seen_uv

CAPTURE = Path(__file__).parents[3] / "shared" / "data" / "capture_a"
SEEN = """() => {
  const { stage } = facezip, { camera } = stage.orbit;
  return {
    vertices: Array.from(stage.head.face.vertices),
    projection: camera.projectionMatrix.elements,
    view: camera.matrixWorldInverse.elements,
    bits: stage.renderer.getContext().getParameter(WebGLRenderingContext.SUBPIXEL_BITS),
  };
}"""


def sampled(model, kind, tile, uv):
    """The model whose maps on a tile are those of ``model`` as a GPU samples them at ``(P, 2)`` texture coordinates."""
    part = model.parts[kind.name, tile]
    # Normals are sampled as they are stored, (n + 1) / 2, and become slopes after.
    stored = packed_neutral(part.neutral, kind, part.bits) / np.float32(2**part.bits - 1)
    neutral, *differences = (bilinear(texture, uv)[:, None] for texture in (stored, *part.differences))
    weights = np.stack([bilinear(weight_map, uv)[:, None] for weight_map in model.weights[tile]])
    at = Part(unpacked_neutral(neutral.astype(np.float32), kind), np.stack(differences), part.bits)
    return replace(model, parts={(kind.name, tile): at}, weights={tile: weights}, meshes=None)


def bilinear(texture, uv):
    """``(P, C)`` samples of a texture with clamped borders at ``(P, 2)`` texture coordinates, v up."""
    height, width, _ = texture.shape
    at = np.clip(np.c_[1 - uv[:, 1], uv[:, 0]] * [height, width] - 0.5, 0, [height - 1, width - 1])
    (top, left), (y, x) = np.floor(at).astype(int).T, (at % 1).astype(np.float32).T[..., None]
    bottom, right = np.minimum(top + 1, height - 1), np.minimum(left + 1, width - 1)
    upper = texture[top, left] * (1 - x) + texture[top, right] * x
    return upper * (1 - y) + (texture[bottom, left] * (1 - x) + texture[bottom, right] * x) * y


def unbroken(uv, tile, reach):
    """Pixels whose neighbours show the same surface and tile: not on silhouettes, folds and seams, of either side."""
    inside = np.zeros(tile.shape, bool)
    surface = np.dstack([uv, tile])
    centre, (height, width) = surface[1:-1, 1:-1], tile.shape
    shifts = [surface[1 + y : height - 1 + y, 1 + x : width - 1 + x] for y in (-1, 0, 1) for x in (-1, 0, 1)]
    inside[1:-1, 1:-1] = np.all([np.abs(shift - centre).max(2) < reach for shift in shifts], axis=0)
    return inside


def head_errors(context, pack, blend):
    """By map, absolute errors of 255, ``(P, 3)``, of the flat head at pixels that are wholly one surface."""
    model = facezip.read_pack(pack)
    pixels = {}
    with viewing(context, pack) as viewer:
        viewer.choose("Show", "Flat")
        viewer.switch("Mip-maps", False)
        viewer.slide(blend)
        for kind in model.maps:
            if len(model.maps) > 1:
                viewer.choose("Map", kind.name)
            pixels[kind] = viewer.pixels()[..., :3]
        page = viewer.page.evaluate(SEEN)
    betas = np.array([blend.get(name, 0) for name in model.expressions])
    vertices = model.meshes.neutral + np.tensordot(betas, model.meshes.deltas, 1)
    shown = np.reshape(page["vertices"], (-1, 3))
    np.testing.assert_allclose(shown, vertices, atol=1e-5 * np.ptp(vertices))
    # As the page has them: where rounding decides on a subpixel, half a step of 16 bits can decide otherwise.
    matrices = (np.reshape(page[name], (4, 4)).T for name in ("projection", "view"))
    size = pixels[model.maps[0]].shape[:2]
    face, uv = seen_uv(shown, model.meshes.topology, *matrices, size, page["bits"])
    place = np.where(face < 0, -1, tiles_of_faces(model.meshes.topology, model.tiles)[face])
    seen = unbroken(uv, place, reach=0.01 * len(model.tiles))
    assert seen.sum() > 0.5 * np.isfinite(uv[..., 0]).sum()
    return {
        kind.name: np.concatenate([
            errors_of(model, kind, tile, blend, uv[seen & (place == t)], pixels[kind][seen & (place == t)])
            for t, tile in enumerate(model.tiles)
        ])
        for kind in model.maps
    }  # fmt: skip


def errors_of(model, kind, tile, blend, uv, pixels):
    values = sampled(model, kind, tile, uv - place_of(tile)).blend(blend, map=kind.name, tile=tile)[:, 0]
    return np.abs(255 * (values - kind.low) / (kind.high - kind.low) - pixels)


@pytest.fixture(scope="module")
def surface():
    """The embedded character."""
    return make_character(128, 4, maps=MAPS[:2])


@pytest.mark.parametrize(("tiles", "blend"), [((1, 1), {"smile": 1.0}), ((2, 1), {"laugh": 0.5, "frown": 0.4})])
def test_the_flat_head_shows_the_blend_of_every_map(context, surface, tmp_path, tiles, blend):
    facezip.write_pack(facezip.compress(in_tiles(surface, *tiles)), tmp_path / "embedded.facezip")
    errors = head_errors(context, tmp_path / "embedded.facezip", blend)
    assert {name: found.max() <= 1 for name, found in errors.items()} == dict.fromkeys(errors, True)


@pytest.mark.skipif(not CAPTURE.is_dir(), reason="the real capture is not here")
def test_the_real_capture_shows_the_blend(context, tmp_path):
    facezip.write_pack(facezip.compress(facezip.load_character(CAPTURE)), tmp_path / "capture.facezip")
    first, second, *_ = facezip.read_pack(tmp_path / "capture.facezip").expressions
    errors = head_errors(context, tmp_path / "capture.facezip", {first: 0.4, second: 0.7})
    assert errors["albedo"].max() <= 1
