"""The page of image tests in a real browser: its filter, its wipe. Skipped without Chromium."""

import json
import re

import numpy as np

from facezip.files.images import write_texture
from render.plugin.results import Compared, ImagesDocument, Place, Result, StaleReference
from reports.regression import PICTURES, write_regression_report
from tests.reports.test_browser import POLICY, dom_of, pytestmark

__all__ = ["pytestmark"]
PROBE = """<pre id="probe"></pre><script>addEventListener("load", () => {
  const seen = {}, filter = document.querySelector(".filter");
  const shown = () => [...document.querySelectorAll(".card:not([hidden]) h3")].map((title) => title.textContent);
  const act = (css, change) => {
    change(filter.querySelector(css));
    filter.querySelector(css).dispatchEvent(new Event("input", { bubbles: true }));
    return shown();
  };
  seen.all = shown();
  seen.named = act("[type=search]", (text) => { text.value = "SKIN"; });
  seen.passed = act("[value=failed]", (box) => { box.checked = false; });
  seen.count = filter.querySelector("output").textContent;
  const card = document.querySelector(".card"), source = (css) => card.querySelector(css).src;
  seen.borrowed = source(".over img") === source("img.original") && source(".under img") === source("img.compressed");
  seen.spoken = card.querySelector("input[type=range]").getAttribute("aria-valuetext");
  seen.overflow = document.documentElement.scrollWidth > innerWidth;
  document.querySelector("#probe").textContent = JSON.stringify(seen);
});</script></body>"""


def result(folder, name, outcome):
    (folder / name).mkdir()
    for value, picture in enumerate(PICTURES):
        write_texture(folder / name / f"{picture}.png", np.full((8, 8, 3), 60 * value, np.uint8))
    place = Place(row=0, column=0, side=1, image=0.5, reference=0.5, deviations=1.0)
    compared = Compared(probability=0.1, statistic="largest_1", renders=8, accepted=1, place=place)
    told = {"must_differ": False, "level": 0.001, "comparison": compared, "evidence": str(folder / name)}
    return Result(name=name, test=f"t.py::{name}", outcome=outcome, **told)


def test_images_are_filtered_and_wiped(tmp_path):
    results = [result(tmp_path, name, outcome) for name, outcome in
               (("skin.a", "passed"), ("skin.b", "failed"), ("eye", "passed"))]  # fmt: skip
    document = ImagesDocument(results=results, stale=[StaleReference(reference="<b>x", test="")], idle=0)
    page = write_regression_report(document, tmp_path / "index.html")
    text = page.read_text(encoding="utf-8")
    assert "&lt;b&gt;x" in text
    page.write_text(POLICY.sub("", text).replace("</body>", PROBE), encoding="utf-8")
    assert json.loads(re.search(r'<pre id="probe">(.*?)</pre>', dom_of(page, tmp_path)).group(1)) == {
        "all": ["skin.b", "eye", "skin.a"],
        "named": ["skin.b", "skin.a"],
        "passed": ["skin.a"],
        "count": "1 of 3 shown",
        "borrowed": True,
        "spoken": "50 % reference",
        "overflow": False,
    }
