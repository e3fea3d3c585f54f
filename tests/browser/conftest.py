"""The viewer in headless Chromium; skipped, and said so, where the browser, its driver or the bundle is missing."""

import base64
from contextlib import contextmanager
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from facezip.viewer.build import BUNDLE
from facezip.viewer.scene import read_scene
from facezip.viewer.server import ADDRESS, files_of, serve
from tests.serving import running

READY_MS = 120_000

# Draws once more and reads what was drawn, in the same task: the drawing buffer is gone after it.
DRAWN = """() => new Promise((done) => {
  const canvas = document.querySelector("#canvas");
  const look = () => canvas.dataset.complete === "true"
    ? done(canvas.toDataURL().split(",")[1]) : canvas.addEventListener("drawn", look, { once: true });
  canvas.addEventListener("drawn", look, { once: true });
  facezip.stage.draw();
})"""

# Where several surfaces share a pixel, antialiasing shades each of them outside of itself.
HARD_EDGES = """const getContext = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (kind, options) {
  return getContext.call(this, kind, { ...options, antialias: false });
};"""
SLIDE = """(weights) => {
  for (const label of document.querySelectorAll(".slider label")) {
    const slider = document.getElementById(label.htmlFor);
    slider.value = weights[label.textContent] ?? 0;
    slider.dispatchEvent(new Event("input"));
  }
}"""


class Viewer:
    """A page with the viewer, used as a person would: by its controls."""

    def __init__(self, page):
        self.page = page
        page.locator("body.ready, body.failed").wait_for(timeout=READY_MS)

    def slide(self, weights):
        """Move every slider: to the weight of the name beside it, or to zero."""
        self.page.evaluate(SLIDE, weights)

    def choose(self, group, option):
        """Press one of a group of buttons."""
        self.page.locator(f".choice:has(legend:text-is('{group}')) label").filter(has_text=option).click()

    def switch(self, name, on):
        """Set a check box."""
        self.page.get_by_label(name, exact=True).set_checked(on)

    def pixels(self):
        """What the canvas shows, ``(H, W, 4)`` uint8."""
        content = base64.b64decode(self.page.evaluate(DRAWN))
        return np.asarray(Image.open(BytesIO(content)).convert("RGBA"))

    def layout(self, tile=0):
        """The texture of a tile as it is shown at one texel a pixel, ``(H, W, 3)`` uint8."""
        pixels = self.pixels()
        cell = self.page.evaluate(f"facezip.stage.sheet.cells[{tile}]")
        # WebGL counts rows from below.
        top, left = pixels.shape[0] - cell["bottom"] - cell["height"], cell["left"]
        return pixels[top : top + cell["height"], left : left + cell["width"], :3]


@pytest.fixture(scope="session")
def browser(chromium):
    if not (BUNDLE / "viewer.js").is_file():
        pytest.skip("the viewer is not built; run 'make viewer'")
    return chromium


@pytest.fixture(scope="session")
def context(browser):
    """Small, and without motion: poses are reached at once."""
    with browser.new_context(viewport={"width": 960, "height": 460}, reduced_motion="reduce") as context:
        context.add_init_script(HARD_EDGES)
        yield context


@contextmanager
def served(pack, character=None):
    """The address of a pack's page while the block runs."""
    with running(serve(files_of(read_scene(pack, character)))) as server:
        yield f"http://{ADDRESS}:{server.server_port}/"


@contextmanager
def viewing(context, pack, character=None, script=""):
    """A viewer of a pack, whose page raised no error and logged none; a script may run before its own."""
    faults = []
    with served(pack, character) as address, context.new_page() as page:
        page.add_init_script(script)
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.on("console", lambda message: faults.append(message.text) if message.type == "error" else None)
        page.goto(address)
        yield Viewer(page)
    assert faults == []
