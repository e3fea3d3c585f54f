"""The page in a real browser: its controls work, names run nothing, nothing overflows. Skipped without Chromium."""

import json
import re
import shutil
import subprocess

import pytest

from reports.validation import write_validation_report
from tests.reports.conftest import make_document

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
FLAGS = [
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync",
    "--disable-background-networking", "--disable-component-update", "--virtual-time-budget=3000", "--dump-dom",
]  # fmt: skip
POLICY = re.compile(r'<meta http-equiv="Content-Security-Policy"[^>]*>')
PROBE = """<pre id="probe"></pre><script>addEventListener("load", () => {
  const card = document.querySelector("article.card"), seen = {};
  const source = (css) => card.querySelector(css).src;
  const state = () => ["img.original", "img.compressed", "img.difference"].map(source).join() + card.innerText;
  const set = (css, value, event) => {
    const element = card.querySelector(css);
    element.value = value;
    element.dispatchEvent(new Event(event));
  };
  seen.borrowed = source(".over img") === source("img.original") && source(".under img") === source("img.compressed");
  set("input", "20", "input");
  seen.wipe = card.querySelector(".wipe .frame").style.getPropertyValue("--x");
  seen.spoken = card.querySelector("input").getAttribute("aria-valuetext");
  const first = state();
  set(".choose-view", "1", "change");
  seen.view = card.querySelector(".place").textContent;
  seen.numbers = [...card.querySelectorAll("tr.chosen td")].map((cell) => cell.textContent);
  set(".choose-view", "0", "change");
  seen.restored = state() === first;
  set(".choose-pack", "1", "change");
  seen.pack = card.querySelector(".chosen-pack").textContent;
  seen.follows = source(".under img") === source("img.compressed") && source("img.compressed") !== "";
  seen.overflow = document.documentElement.scrollWidth > innerWidth;
  document.querySelector("#probe").textContent = JSON.stringify(seen);
});</script></body>"""

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed")


def dom_of(page, tmp_path, width=1200):
    command = [CHROMIUM, *FLAGS, f"--user-data-dir={tmp_path / 'profile'}", f"--window-size={width},900", page.as_uri()]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=True).stdout


@pytest.mark.parametrize("width", [1200, 500])
def test_wipe_and_choosers_work(tmp_path, width):
    document = make_document(tmp_path, packs=("refined", "paper"))
    page = write_validation_report(document, tmp_path)
    page.write_text(POLICY.sub("", page.read_text(encoding="utf-8")).replace("</body>", PROBE), encoding="utf-8")
    seen = json.loads(re.search(r'<pre id="probe">(.*?)</pre>', dom_of(page, tmp_path, width)).group(1))
    other = document["renders"][2]
    assert seen.pop("numbers")[0] == f"{other['packs'][0]['image_rmse']:.2f}"
    assert seen == {
        "borrowed": True, "wipe": "20%", "spoken": "20 % original", "view": "front · studio", "restored": True,
        "pack": "paper", "follows": True, "overflow": False,
    }  # fmt: skip


@pytest.mark.parametrize("protected", [True, False])
def test_names_run_nothing_with_the_policy_and_without(tmp_path, protected):
    hostile = "<script>document.title='owned'</script><img src=x onerror=\"document.title='owned'\">'\"</script>"
    document = make_document(tmp_path, packs=(hostile,), expressions=(hostile, "b"), name=hostile)
    page = write_validation_report(document | {"command": hostile}, tmp_path)
    if not protected:
        page.write_text(POLICY.sub("", page.read_text(encoding="utf-8")), encoding="utf-8")
    dom = dom_of(page, tmp_path)
    assert re.search(r"<title>(.*?)</title>", dom, re.DOTALL).group(1).endswith("FaceZip validation")
    assert "--x: 50%" in dom
