"""The page with everything in it: names are data there, whatever they are."""

import base64
import hashlib
import json
import re
from dataclasses import replace

import pytest

from facezip import FaceZipError
from facezip.export.documents.export import WebDocument
from facezip.export.web import export_web
from facezip.pack.write import write_pack
from tests.facezip.conftest import random_model

HOSTILE = ("<!--<script>", "\"'><img src=x onerror=alert(1)>", "$(touch owned); `id` & {{ 7*7 }}")


def block(page, name):
    return re.search(rf'<script type="[^"]*" data-name="{re.escape(name)}">(.*?)</script>', page, re.DOTALL).group(1)


@pytest.fixture
def hostile(tmp_path):
    write_pack(replace(random_model(meshes=True), expressions=HOSTILE), tmp_path / "h.facezip", name="</script>" * 3)
    return tmp_path / "h.facezip"


def test_names_come_through_as_they_are_and_end_no_element(hostile, bundle, tmp_path):
    export_web(hostile, tmp_path / "a.html")
    page = (tmp_path / "a.html").read_text()
    document = json.loads(block(page, "scene.json"))
    assert document["expressions"] == list(HOSTILE)
    assert document["name"] == "</script>" * 3
    assert not any(name in page for name in HOSTILE)
    assert page.count("</script>") == page.count("<script")


def test_assets_come_through(hostile, bundle, tmp_path):
    export_web(hostile, tmp_path / "a.html")
    page = (tmp_path / "a.html").read_text()
    content = base64.b64decode(block(page, "tile_0.map_0.difference_1.png"))
    assert content == (hostile / "albedo.1001.difference_1.png").read_bytes()


def test_the_policy_allows_its_own_script_and_nothing_from_outside(hostile, bundle, tmp_path):
    export_web(hostile, tmp_path / "a.html")
    page = (tmp_path / "a.html").read_text()
    policy = re.search(r'Content-Security-Policy" content="([^"]*)"', page).group(1).replace("&#39;", "'")
    digest = base64.b64encode(hashlib.sha256(b"'use strict';").digest()).decode()
    assert f"default-src 'none'; script-src 'sha256-{digest}';" in policy
    assert not re.search(r"https?:|connect-src|unsafe", policy)
    assert not re.search(r'(?:src|href)="(?!data:,|#|LICENCES)', page)


@pytest.mark.parametrize(("output", "file"), [("folder", "folder/index.html"), ("page.html", "page.html")])
def test_the_output_is_a_file_or_a_folder(hostile, bundle, tmp_path, output, file):
    document = export_web(hostile, tmp_path / output)
    size = (tmp_path / file).stat().st_size
    assert document == WebDocument(output=str(tmp_path / file), bytes=size, originals=False)


def test_only_what_facezip_made_is_replaced_and_only_when_asked(hostile, bundle, tmp_path):
    (tmp_path / "mine.html").write_text("<p>mine</p>")
    export_web(hostile, tmp_path / "ours.html")
    with pytest.raises(FaceZipError, match="exists already"):
        export_web(hostile, tmp_path / "ours.html")
    export_web(hostile, tmp_path / "ours.html", overwrite=True)
    with pytest.raises(FaceZipError, match="not made by facezip"):
        export_web(hostile, tmp_path / "mine.html", overwrite=True)
    assert (tmp_path / "mine.html").read_text() == "<p>mine</p>"
