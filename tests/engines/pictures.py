"""The picture of the tutorial's exports: a demo's head with one expression in Blender, in Godot and in three.js.

    python -m tests.engines.pictures out/demo docs/editors.webp

Blender is the Python package of ``make engines``, Godot the engine's build for browsers; both they and three.js draw in
software. The versions are printed.
"""

import sys
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from PIL import Image
from playwright.sync_api import sync_playwright

from facezip.character.loading import load_character
from facezip.export import TARGETS
from render.metrics import display
from scenes.cameras import View, frame_of
from tests.browser.pictures import POSE, three
from tests.conftest import CHROMIUM, FLAGS
from tests.engines import cycles, godot
from tests.engines.editor import imported
from tests.engines.judge import camera, lights
from tests.engines.test_godot import RUNTIME

SIDE, SAMPLES, QUALITY = 512, 32, 85
# Of the picture that is kept: the head is in the middle.
WIDTH = 400
VIEW = View("portrait", azimuth=6, elevation=3, extent=1.08)
# Of a window of which the example's head fills the same.
LARGE = {"width": 1500, "height": 900}
# Where Godot's sun stands, and its light from everywhere: about the key and the fill of Blender's studio.
SUN, AMBIENT = [-0.9, 0.9, 1.5], 0.25
SUNLIT = {"albedo": {"lit": True, "plain": False, "replace": {}, "behind": "", "ambient": AMBIENT}}


def in_blender(demo, folder):
    """Cycles in the studio's lights ``(SIDE, SIDE, 3)``, and Blender's version."""
    scans = load_character(demo / "character")
    frame = frame_of(scans.meshes.neutral)
    TARGETS["blender"](demo / "character.facezip", folder / "blender")
    request = {
        "folder": str(folder / "blender"),
        "names": scans.expressions,
        "resolution": SIDE,
        "samples": SAMPLES,
        "camera": camera(VIEW, frame),
        "lights": lights("studio", frame),
        "weights": POSE,
        "picture": str(folder / "blender.exr"),
    }
    version = cycles.run("portrait.py", folder, request, timeout=None)["version"]
    return np.rint(255 * display(cycles.picture(folder / "blender.exr")[..., :3])).astype(np.uint8), version


def in_godot(browser, demo, folder):
    """The Compatibility renderer under a sun, ``(SIDE, SIDE, 3)``."""
    frame = frame_of(load_character(demo / "character").meshes.neutral)
    TARGETS["godot"](demo / "character.facezip", folder / "face")
    case = {
        "name": "face", "size": [SIDE, SIDE], "zoom": 1, "folder": "res://face", "head": "res://face/head.glb",
        "poses": {"smile": POSE}, "views": SUNLIT, "gains": {}, "camera": camera(VIEW, frame), "light": SUN,
    }  # fmt: skip
    shown = godot.run(browser, RUNTIME, imported(folder / "face", "face"), [case])
    for error in dict.fromkeys(shown.errors):
        print(error, file=sys.stderr)
    return shown.pictures["face", "albedo", "smile"]


def in_three(browser, demo):
    """The example of the export, ``(SIDE, SIDE, 3)``."""
    with browser.new_page(viewport=LARGE) as page:
        three(page, demo)
        pixels = np.asarray(Image.open(BytesIO(page.screenshot())).convert("RGB"))
    top, left = ((length - SIDE) // 2 for length in pixels.shape[:2])
    return pixels[top : top + SIDE, left : left + SIDE]


def main():
    demo, target = map(Path, sys.argv[1:3])
    with TemporaryDirectory() as place, sync_playwright() as playwright:
        folder = Path(place)
        rendered, version = in_blender(demo, folder)
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        pictures = [rendered, in_godot(browser, demo, folder), in_three(browser, demo)]
        browser.close()
    edge = (SIDE - WIDTH) // 2
    image = np.concatenate([picture[:, edge : edge + WIDTH] for picture in pictures], axis=1)
    Image.fromarray(image).save(target, quality=QUALITY, method=6)
    print(f"Blender {version}, Cycles, {SAMPLES} samples")


if __name__ == "__main__":
    main()
