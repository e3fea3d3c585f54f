"""The site builds without a warning, opens from disk, and asks no server for anything."""

import re
import subprocess
import sys
from urllib.parse import unquote

import pytest

from reports.docstrings import google
from reports.site import ROOT, SITE, command_line

ASKED = re.compile(r"<(?:script|img|iframe|link)\b[^>]*?\b(?:src|href)=\"([^\"]+)\"")


@pytest.fixture(scope="module")
def site():
    """The folder of the site, built strictly: a dead link, anchor or name of the API reference is an error."""
    pytest.importorskip("zensical", reason="Zensical is not installed")
    done = subprocess.run(
        [sys.executable, "-m", "reports.site"], cwd=ROOT, capture_output=True, text=True, timeout=280, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return SITE


def test_pages_load_nothing_from_a_server(site):
    pages = sorted(site.glob("*.html"))
    assert len(pages) > 20
    for page in pages:
        for target in ASKED.findall(page.read_text(encoding="utf-8")):
            assert not re.match(r"(\w+:)?//", target), f"{page.name}: {target}"


def test_links_and_pictures_lead_to_files_and_places_that_are_there(site):
    # The page of a server for what is not there links to the server's root.
    pages = [page for page in site.glob("*.html") if page.name != "404.html"]
    texts = {page.name: page.read_text(encoding="utf-8") for page in pages}
    places = {name: set(re.findall(r"\bid=\"([^\"]+)\"", text)) for name, text in texts.items()}
    for name, text in texts.items():
        for file, place in re.findall(r"<(?:a|img)\b[^>]*?\b(?:href|src)=\"([^\":#]*)(?:#([^\"]*))?\"", text):
            assert (site / unquote(file or name)).is_file(), f"{name}: {file}"
            assert not place or unquote(place) in places[unquote(file or name)], f"{name}: {file}#{place}"


def test_search_finds_a_page_from_disk(site, chromium):
    asked, faults = [], []
    with chromium.new_page() as page:
        page.on("request", lambda request: asked.append(request.url))
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.goto((site / "index.html").as_uri())
        page.locator("button", has_text="Search").click()
        page.get_by_role("combobox", name="Search").press_sequentially("glossary")
        page.get_by_role("option", name="Glossary").first.wait_for()
    assert [url for url in asked if not url.startswith(("file:", "data:", "blob:"))] == []
    assert faults == []


def test_the_page_of_commands_has_every_option_of_a_verb():
    words = command_line()
    assert "## facezip compress\n" in words
    assert "## facezip bench render\n" in words
    assert "--target-rmse" in words


def test_docstrings_become_those_that_the_reference_reads():
    text = "Does it (:func:`a.b`).\n\nParameters\n----------\nx, y : where,\n    in texels.\n\n"
    text += "Returns\n-------\nA sum\nof both.\n\nRaises\n------\nFaceZipError\n    Always."
    assert google(text) == (
        "Does it (`b`).\n\nArgs:\n    x: where, in texels.\n    y: where, in texels.\n\n"
        "Returns:\n    A sum of both.\n\nRaises:\n    FaceZipError: Always."
    )
