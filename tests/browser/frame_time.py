"""Frame time of the viewer's blend beside that of fetching every texture, on this machine's software GL.

python -m tests.browser.frame_time [--resolution 1024] [--expressions 20] [--json]
"""

import argparse
import json
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from playwright.sync_api import sync_playwright

from facezip.machine.conditions import conditions
from facezip.pack.write import write_pack
from tests.browser.conftest import Viewer, served
from tests.conftest import CHROMIUM, FLAGS
from tests.facezip.conftest import random_model


def measure(resolution, expressions):
    """The viewer's own measurement, of a pack of random maps: their values do not change the time."""
    low = resolution // 8
    model = random_model(size=(resolution, resolution), weights=(low, low), expressions=expressions)
    with TemporaryDirectory() as folder, sync_playwright() as playwright:
        write_pack(model, Path(folder) / "random.facezip")
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        with served(Path(folder) / "random.facezip") as address, browser.new_page() as page:
            page.goto(address)
            Viewer(page)
            found = page.evaluate("facezip.measureFrames()")
        browser.close()
    return {**found, "conditions": vars(conditions(("facezip", "playwright")))}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--resolution", type=int, default=1024)
    parser.add_argument("--expressions", type=int, default=20)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    if CHROMIUM is None:
        sys.exit("frame_time: Chromium is not installed")
    found = measure(options.resolution, options.expressions)
    if options.json:
        print(json.dumps(found, indent=1))
        return
    print(f"{found['size']}^2 pixels, {found['expressions']} expressions at once, {found['device']}")
    print(f"  pre-pass and {found['fetches']} fetches   {found['facezip_ms']:8.1f} ms")
    print(f"  every texture            {found['all_ms']:8.1f} ms")
    print(f"  ratio                    {found['ratio']:8.2f}    median of {found['rounds']} rounds in turn")


if __name__ == "__main__":
    main()
