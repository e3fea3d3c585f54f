"""The exported page opens from disk, asks for nothing, and shows what the served one shows."""

import numpy as np

import facezip
from facezip.export.web import export_web
from tests.browser.conftest import Viewer, viewing
from tests.facezip.conftest import random_character


def test_the_page_opens_from_disk_with_no_request_but_its_own(browser, tmp_path):
    scans = random_character()
    facezip.write_pack(facezip.compress(scans), tmp_path / "a.facezip")
    export_web(tmp_path / "a.facezip", tmp_path / "a.html", character=scans)
    address = (tmp_path / "a.html").as_uri()
    asked, faults = [], []
    with browser.new_context(viewport={"width": 960, "height": 460}, reduced_motion="reduce") as context:
        with context.new_page() as page:
            page.on("request", lambda request: asked.append(request.url))
            page.on("pageerror", lambda error: faults.append(str(error)))
            page.on("console", lambda message: faults.append(message.text) if message.type == "error" else None)
            page.goto(address)
            viewer = Viewer(page)
            viewer.slide({"expr_2": 0.8})
            viewer.choose("Side", "Wipe")
            alone = viewer.pixels()
        with viewing(context, tmp_path / "a.facezip", scans) as viewer:
            viewer.slide({"expr_2": 0.8})
            viewer.choose("Side", "Wipe")
            np.testing.assert_array_equal(viewer.pixels(), alone)
    assert [url for url in asked if not url.startswith(("data:", "blob:"))] == [address]
    assert faults == []
