"""Pictures of the report, the page, the viewer and the three.js head of a demo, as a browser shows them.

python -m tests.browser.pictures out/demo docs
"""

import sys
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image
from playwright.sync_api import sync_playwright

from facezip.character.loading import load_character
from facezip.export import TARGETS
from tests.browser.conftest import Viewer, served
from tests.conftest import CHROMIUM, FLAGS
from tests.engines.godot import serving

POSE = {"smile": 0.8, "brows_up": 0.6}
# What the viewer shows: above with a line between original and pack, and what below.
FROWN = {"frown": 1.0}
BELOW = (("Clay", None), ("Flat", "normal"), ("Flat", "roughness"), ("Error", "normal"))
LARGE = {"width": 1440, "height": 900}
SIZE = {"width": 1200, "height": 820}
WIDTH = 900
# Of a page drawn in software.
SETTLED_MS = 3000


def save(page, path):
    """What a page shows, in the width of a text column."""
    image = Image.open(BytesIO(page.screenshot())).convert("RGB")
    image.resize((WIDTH, round(image.height * WIDTH / image.width)), Image.Resampling.LANCZOS).save(path, quality=80)


def report(page, demo):
    """The report of ``facezip demo``."""
    page.goto((demo / "report" / "index.html").resolve().as_uri())


def alone(page, demo):
    """The page of ``export --to web``, with an expression."""
    with TemporaryDirectory() as folder:
        TARGETS["web"](demo / "character.facezip", Path(folder) / "page.html")
        page.goto((Path(folder) / "page.html").as_uri())
        Viewer(page).slide(POSE)
        page.wait_for_timeout(SETTLED_MS)


def three(page, demo):
    """The example of ``export --to three``, with an expression."""
    with TemporaryDirectory() as folder:
        TARGETS["three"](demo / "character.facezip", Path(folder) / "face")
        files = {
            f"/{path.relative_to(folder)}": path.read_bytes() for path in Path(folder).rglob("*") if path.is_file()
        }
        with serving(files) as address:
            page.goto(f"{address}/face/index.html")
            for name, weight in POSE.items():
                page.get_by_label(name, exact=True).fill(str(weight))
            page.wait_for_timeout(SETTLED_MS)


def viewer(browser, demo, path):
    """``facezip view`` with the scans: all maps under light, and below the head in other views."""
    scans = load_character(demo / "character")
    with served(demo / "character.facezip", scans) as address, browser.new_page(viewport=LARGE) as page:
        page.goto(address)
        shown = Viewer(page)
        shown.slide(FROWN)
        shown.choose("Side", "Wipe")
        page.wait_for_timeout(SETTLED_MS)
        window = Image.open(BytesIO(page.screenshot())).convert("RGB")
        shown.choose("Side", "FaceZip")
        views = []
        for show, name in BELOW:
            shown.choose("Show", show)
            if name:
                shown.choose("Map", name)
            page.wait_for_timeout(SETTLED_MS)
            views.append(_middle(Image.fromarray(shown.pixels()).convert("RGB"), LARGE["width"] // len(BELOW)))
    whole = Image.new("RGB", (window.width, window.height + views[0].height))
    whole.paste(window, (0, 0))
    for n, view in enumerate(views):
        whole.paste(view, (n * view.width, window.height))
    whole.save(path, quality=80)


def _middle(image, width):
    """The middle of a picture, higher than wide, in this width."""
    height = width * 5 // 4
    across = image.height * width // height
    left = (image.width - across) // 2
    return image.crop((left, 0, left + across, image.height)).resize((width, height), Image.Resampling.LANCZOS)


def main():
    """Take all of them."""
    demo, target = map(Path, sys.argv[1:3])
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        for name, opened in {"report": report, "page": alone, "three": three}.items():
            with browser.new_page(viewport=SIZE) as page:
                opened(page, demo)
                save(page, target / f"{name}.webp")
        viewer(browser, demo, target / "viewer.webp")
        browser.close()


if __name__ == "__main__":
    main()
