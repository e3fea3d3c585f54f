"""Exports to three.js, opened by a server as GUIDE.md says: their pixels in a scene are those of ``blend``."""

import base64
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest

from facezip import FaceZipError
from facezip.character.maps import Map
from facezip.export import TARGETS
from facezip.files.srgb import decode_srgb
from facezip.pack.read import read_pack
from facezip.pack.write import write_pack
from tests.browser.conftest import HARD_EDGES
from tests.browser.test_small_gpu import FLOATS
from tests.engines.godot import ZOOM, serving
from tests.engines.heads import HEADS, expected, faces_on, gains_of, head, poses, seen_under
from tests.facezip.export.conftest import KINDS, layered_model
from tests.facezip.export.gains import regions_in
from tests.facezip.viewer.models import random_maps

READY_MS = 60_000


def of_16_bits(surface):
    parts = {key: replace(part, bits=16) for key, part in surface.parts.items()}
    return replace(surface, parts=parts)


# A mirrored one has the relief of another only under light, which is the viewer's own skin.
FLAT = {name: surface for name, surface in HEADS.items() if "in blocks" not in name and name != "mirrored"} | {
    "neutrals of 16 bits": of_16_bits(head(layered_model(kinds=KINDS))),
    "two channels": head(random_maps(maps=("albedo", Map("flow", "data")), channels={"flow": 2})),
    "five slots": head(layered_model(kinds=KINDS[:3], slots=5)),
}
GAINS = ("several maps", "tiles, one without faces", "odd names", "five slots", "masks")
ALBEDO_ALONE = ("one map", "grey", "odd names", "uniform weights")

# Draws the sheet, and reads what was drawn, the first row first.
DRAW = """async ([columns, rows, weights, map, gains, plain]) => {
  renderer.setAnimationLoop(null);
  renderer.setPixelRatio(1);
  renderer.setSize(columns, rows, false);
  head.position.set(0, 0, 0);
  head.scale.setScalar(1);
  const sheet = new THREE.Mesh(new THREE.PlaneGeometry(columns / rows, 1).translate(0.5 * columns / rows, 0.5, 0));
  if (plain) {
    const [texels, width, height] = plain;
    const texture = new THREE.DataTexture(new Float32Array(texels), width, height, THREE.RGBAFormat, THREE.FloatType);
    texture.needsUpdate = true;
    const { roughness, specularIntensity } = head.materials[0];
    sheet.material = new THREE.MeshPhysicalMaterial({ roughness, specularIntensity, map: texture });
    scene.add(sheet);
  }
  head.visible = !plain;
  const camera = new THREE.OrthographicCamera(0, columns / rows, 1, 0, -1000, 1000);
  head.set({ ...Object.fromEntries(head.expressions.map((name) => [name, 0])), ...weights });
  for (const [kind, values] of Object.entries(gains)) Object.assign(head.gains[kind], values);
  head.show(map);
  renderer.render(scene, camera);
  scene.remove(sheet);
  const gl = renderer.getContext(), pixels = new Uint8Array(4 * columns * rows);
  gl.readPixels(0, 0, columns, rows, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  return btoa(Array.from(pixels, (byte) => String.fromCharCode(byte)).join(""));
}"""


class Page:
    """The example page of an export."""

    def __init__(self, page, size):
        self.page, self.size = page, size

    def draw(self, weights=None, map=None, gains=None, plain=None):
        """``(H, W, 3)`` of 255; ``plain`` are linear colours that an ordinary material shows in the head's place."""
        rows, columns = (side * ZOOM for side in self.size)
        if plain is not None:
            height, width, _ = plain.shape
            plain = [np.pad(plain[::-1], ((0, 0), (0, 0), (0, 1))).ravel().tolist(), width, height]
        content = self.page.evaluate(DRAW, [columns, rows, weights or {}, map, gains or {}, plain])
        texels = np.frombuffer(base64.b64decode(content), np.uint8).reshape(rows, columns, 4)[::-1, :, :3]
        middle = slice(ZOOM // 2, None, ZOOM)
        return texels[middle, middle].astype(int)


# What the driver says of reading pixels, and three of what a test has taken away.
MEANT = ("GPU stall due to ReadPixels", "EXT_color_buffer_float extension not supported")


def is_fault(message):
    return message.type in ("error", "warning") and not any(words in message.text for words in MEANT)


@contextmanager
def opened(browser, folder, surface=None, script=""):
    """The page, which asked for nothing but the folder's files, and logged and raised nothing."""
    paths = [path for path in folder.rglob("*") if path.is_file()]
    files = {f"/{path.relative_to(folder).as_posix()}": path.read_bytes() for path in paths}
    faults, size = [], (8, 8)
    if surface is not None:
        rows, columns = surface.parts["albedo", surface.tiles[0]].neutral.shape[:2]
        size = rows, columns * (max(faces_on(surface)) - 1000)
    with serving(files) as address, browser.new_context() as context, context.new_page() as page:
        page.add_init_script(HARD_EDGES + script)
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.on("console", lambda message: faults.append(message.text) if is_fault(message) else None)
        page.on("request", lambda request: faults.append(request.url) if not request.url.startswith(allowed) else None)
        allowed = (address, "data:", "blob:")
        page.goto(f"{address}/index.html")
        page.wait_for_function("globalThis.head", timeout=READY_MS)
        yield Page(page, size)
    assert faults == []


def exported(surface, folder, **options):
    write_pack(surface, folder / "me.facezip")
    TARGETS["three"](folder / "me.facezip", folder / "face", **options)
    return read_pack(folder / "me.facezip"), folder / "face"


def share(surface, kind, weights):
    """A map from 0 to 255 over its range."""
    return 255 * (expected(surface, kind, weights) - kind.low) / (kind.high - kind.low)


def assert_shown(page, surface, gains=None):
    for kind in surface.maps:
        faces = expected(surface, kind, {}).any(axis=2)
        for pose, weights in poses(surface.expressions).items():
            error = np.abs(page.draw(weights, kind.name, gains) - share(surface, kind, weights))[faces]
            assert error.max() <= 1, (kind.name, pose)


@pytest.mark.parametrize("name", FLAT)
def test_every_map_is_the_blend(browser, tmp_path, name):
    surface, folder = exported(FLAT[name], tmp_path)
    with opened(browser, folder, surface) as page:
        assert_shown(page, surface)


@pytest.mark.parametrize("name", GAINS)
def test_gains_turn_maps_expressions_and_regions(browser, tmp_path, name):
    surface, folder = exported(FLAT[name], tmp_path, region=regions_in(tmp_path, FLAT[name].tiles))
    gains = gains_of(surface)
    with opened(browser, folder, surface) as page:
        assert_shown(page, surface)
        assert_shown(page, seen_under(surface, gains, folder), gains)


@pytest.mark.parametrize("name", ["five slots", "uniform weights", "masks"])
def test_without_floats_to_draw_into_the_blend_is_the_same(browser, tmp_path, name):
    regions = {} if name == "uniform weights" else regions_in(tmp_path)
    surface, folder = exported(FLAT[name], tmp_path, region=regions)
    gains = gains_of(surface) if regions else {}
    with opened(browser, folder, surface, FLOATS) as page:
        assert_shown(page, seen_under(surface, gains, folder) if regions else surface, gains)


@pytest.mark.parametrize("name", ALBEDO_ALONE)
def test_light_meets_what_it_would_meet_of_an_ordinary_material(browser, tmp_path, name):
    """Whose texture is the blend, as linear colours; by three's own light, and its own encoding of what it draws."""
    surface, folder = exported(FLAT[name], tmp_path)
    with opened(browser, folder, surface) as page:
        for weights in poses(surface.expressions).values():
            plain = page.draw(plain=decode_srgb(expected(surface, surface.maps[0], weights)))
            assert plain.mean() > 50
            assert np.abs(page.draw(weights) - plain).max() <= 1


def test_light_shows_the_relief_of_normals(browser, tmp_path):
    surface, folder = exported(FLAT["several maps"], tmp_path)
    weights = {surface.expressions[0]: 1.0}
    with opened(browser, folder, surface) as page:
        whole = page.draw(weights)
        flat = page.draw(weights, gains={"maps": {"normal": 0}})
        assert np.abs(whole - flat).mean() > 2
        np.testing.assert_array_equal(page.draw(weights, gains={"maps": {"normal": 1}}), whole)


def test_shapes_move_the_mesh_by_their_names(browser, tmp_path):
    surface, folder = exported(HEADS["odd names"], tmp_path)
    weights = poses(surface.expressions)["blend"]
    with opened(browser, folder, surface) as page:
        assert page.page.evaluate("head.expressions") == list(surface.expressions)
        page.draw(weights)
        depths = page.page.evaluate(
            "(() => { let mesh; head.traverse((one) => { if (one.isMesh) mesh = one; });"
            "return mesh.getVertexPosition(0, new THREE.Vector3()).z; })()"
        )
        shown = page.page.evaluate("head.weights")
    assert depths == pytest.approx(sum(weights[name] * (n + 1) for n, name in enumerate(surface.expressions)), abs=1e-4)
    assert shown == pytest.approx(weights, abs=1e-6)


WRONG = {
    "head.set({ nobody: 1 })": "no expression 'nobody'",
    "head.set({ expr_0: NaN })": "'expr_0' is NaN",
    "head.show('nothing')": "no map 'nothing'",
    "head.gains.regions.forehaed = 0": "not extensible",
    "new THREE.WebGLRenderer().render(scene, camera)": "belongs to the renderer",
}


def test_what_cannot_be_is_said(browser, tmp_path):
    surface, folder = exported(head(layered_model(kinds=KINDS[:1])), tmp_path)
    with opened(browser, folder, surface) as page:
        page.draw()
        for call, words in WRONG.items():
            said = page.page.evaluate(
                f"(async () => {{ 'use strict'; const {{ loadFaceZip }} = await import('./facezip.js');"
                f"try {{ await ({call}); }} catch (error) {{ return error.message; }} }})()"
            )
            assert words in (said or ""), call


TOO_LARGE = """async () => {
  renderer.setAnimationLoop(null);
  renderer.capabilities.maxTextureSize = 32;
  const { loadFaceZip } = await import("./facezip.js"), other = await loadFaceZip(".");
  try {
    other.traverse((one) => one.onBeforeRender(renderer));
  } catch (error) {
    return error.message;
  }
}"""


def test_a_head_too_large_for_a_gpu_is_refused_with_the_remedy(browser, tmp_path):
    surface, folder = exported(HEADS["maps in blocks"], tmp_path)
    with opened(browser, folder, surface) as page:
        said = page.page.evaluate(TOO_LARGE)
    assert said == "this GPU takes textures of up to 32 texels, the head has 64; load it with { scale: 0.5 }"


def test_smaller_textures_are_near_the_blend(browser, tmp_path):
    surface, folder = exported(HEADS["maps in blocks"], tmp_path)
    with opened(browser, folder, surface) as page:
        page.page.evaluate(
            "(async () => { const { loadFaceZip } = await import('./facezip.js'); scene.remove(head); head.dispose();"
            "globalThis.head = await loadFaceZip('.', { scale: 0.5 }); scene.add(head); })()"
        )
        weights = poses(surface.expressions)["blend"]
        error = np.abs(page.draw(weights, "albedo") - share(surface, surface.maps[0], weights))
    assert 0.5 < error.mean() < 4


def test_maps_do_not_share_textures_there(tmp_path):
    write_pack(FLAT["one map"], tmp_path / "me.facezip")
    with pytest.raises(FaceZipError, match="--maps together: three takes apart"):
        TARGETS["three"](tmp_path / "me.facezip", tmp_path / "out", maps="together")
