"""The picture of the tutorial's exports: a demo's head with one expression in Blender, in Godot and in three.js.

    python -m tests.engines.pictures out/demo docs/editors.webp

Camera and suns are the same in all three. Blender is the Python package of ``make engines``, Godot the engine's build
for browsers; they and three.js draw in software.
"""

import base64
import sys
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from matplotlib.font_manager import findfont
from PIL import Image, ImageColor, ImageDraw, ImageFont
from playwright.sync_api import sync_playwright

from facezip.character.loading import load_character
from facezip.character.units import in_metres
from facezip.export import TARGETS
from facezip.files.srgb import decode_srgb
from render.metrics import display
from scenes.cameras import View, frame_of
from tests.browser.pictures import POSE, three
from tests.conftest import CHROMIUM, FLAGS
from tests.engines import cycles, godot
from tests.engines.editor import imported
from tests.engines.judge import camera
from tests.engines.test_godot import RUNTIME

# Pixels of a render and of a column, which is higher than wide.
RENDERED, SIDE, MARGIN = 1200, 600, 50
SAMPLES, QUALITY = 16, 88
VIEW = View("portrait", azimuth=14, elevation=3, extent=0.92, aim=(0.0, 0.07))
BACKDROP, INK = "#1d1d1d", "#d8d8d8"
CAPTION, LETTERS = 56, 22
# Energy is what white reflects, face on: one part in pi of the irradiance. There are no shadows: Godot's Compatibility
# renderer adds lights that cast them to encoded colours, which comes out too bright.
SUNS = [
    {"from": [-0.9, 0.9, 1.5], "energy": 0.95, "colour": [1.0, 0.95, 0.89]},
    {"from": [1.6, 0.1, 1.2], "energy": 0.3, "colour": [0.89, 0.94, 1.0]},
    {"from": [1.2, 0.9, -1.3], "energy": 0.6, "colour": [0.86, 0.92, 1.0]},
]

# Lets the example draw the portrait once, as a PNG.
DRAW = """({ camera: { origin, target, field_of_view }, distance, backdrop, lights, side }) => {
  renderer.setAnimationLoop(null);
  renderer.setPixelRatio(1);
  renderer.setSize(side, side, false);
  head.position.set(0, 0, 0);
  head.scale.setScalar(1);
  for (const light of scene.children.filter((thing) => thing.isLight)) scene.remove(light);
  for (const { from, energy, colour } of lights) {
    const sun = new THREE.DirectionalLight(new THREE.Color(...colour), energy * Math.PI);
    sun.position.fromArray(from);
    scene.add(sun);
  }
  scene.background = new THREE.Color(backdrop);
  const camera = new THREE.PerspectiveCamera(field_of_view, 1, 0.1 * distance, 10 * distance);
  camera.position.fromArray(origin);
  camera.lookAt(...target);
  renderer.render(scene, camera);
  return [renderer.domElement.toDataURL().split(",")[1], THREE.REVISION];
}"""


def portrait(vertices):
    """Camera, suns and backdrop for neutral vertices ``(V, 3)`` in the exports' unit."""
    seen = camera(VIEW, frame_of(vertices))
    distance = float(np.linalg.norm(np.subtract(seen["origin"], seen["target"])))
    return {"camera": seen, "distance": distance, "lights": SUNS, "backdrop": BACKDROP}


def in_blender(pack, folder, names, asked):
    """Its caption and its render ``(RENDERED, RENDERED, 3)`` uint8, as those below."""
    TARGETS["blender"](pack, folder / "blender")
    request = asked | {
        "folder": str(folder / "blender"), "names": names, "weights": POSE, "resolution": RENDERED, "samples": SAMPLES,
        "picture": str(folder / "blender.exr"),
    }  # fmt: skip
    version = cycles.run("portrait.py", folder, request, timeout=None)["version"]
    linear = cycles.picture(folder / "blender.exr")
    behind = (1 - linear[..., 3:]) * decode_srgb(np.float32(ImageColor.getrgb(BACKDROP)) / 255)
    return f"Blender {version}, Cycles", np.rint(255 * display(linear[..., :3] + behind)).astype(np.uint8)


def in_godot(pack, folder, browser, asked):
    TARGETS["godot"](pack, folder / "face")
    case = {
        "name": "face", "size": [RENDERED, RENDERED], "zoom": 1, "folder": "res://face", "head": "res://face/head.glb",
        "poses": {"smile": POSE}, "views": {"lit": {"lit": True, "plain": False, "replace": {}, "behind": ""}},
        "gains": {}, "portrait": asked,
    }  # fmt: skip
    shown = godot.run(browser, RUNTIME, imported(folder / "face", "face"), [case])
    if shown.errors:
        raise SystemExit("\n".join(shown.errors))
    return f"Godot {shown.version.split('-')[0]}, Compatibility", shown.pictures["face", "lit", "smile"]


def in_three(demo, browser, asked):
    with browser.new_page() as page:
        three(page, demo)
        png, version = page.evaluate(DRAW, asked | {"side": RENDERED})
    return f"three.js r{version}", np.asarray(Image.open(BytesIO(base64.b64decode(png))).convert("RGB"))


def column(words, pixels):
    """A render with its caption below."""
    scaled = Image.fromarray(pixels).resize((SIDE, SIDE), Image.Resampling.BOX)
    image = Image.new("RGB", (SIDE - 2 * MARGIN, SIDE + CAPTION), BACKDROP)
    image.paste(scaled, (-MARGIN, 0))
    font = ImageFont.truetype(findfont("DejaVu Sans"), LETTERS)
    ImageDraw.Draw(image).text((image.width / 2, SIDE + CAPTION / 2), words, INK, font, anchor="mm")
    return image


def main():
    demo, target = map(Path, sys.argv[1:3])
    pack, scans = demo / "character.facezip", load_character(demo / "character")
    asked = portrait(in_metres(scans.meshes).neutral)
    with TemporaryDirectory() as place, sync_playwright() as playwright:
        folder = Path(place)
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        shown = [
            in_blender(pack, folder, scans.expressions, asked),
            in_godot(pack, folder, browser, asked),
            in_three(demo, browser, asked),
        ]
        browser.close()
    image = np.concatenate([column(*one) for one in shown], axis=1)
    Image.fromarray(image).save(target, quality=QUALITY, method=6)


if __name__ == "__main__":
    main()
