import pytest

from facezip import write_pack
from tests.facezip.conftest import random_model


@pytest.fixture
def pack(tmp_path):
    write_pack(random_model(meshes=True), tmp_path / "random.facezip", name="random")
    return tmp_path / "random.facezip"


@pytest.fixture
def bundle(tmp_path, monkeypatch):
    """Stands for the bundle where it is not built: what Python does with it is the same."""
    folder = tmp_path / "bundle"
    folder.mkdir()
    for name, content in {"viewer.js": "'use strict';", "viewer.css": "body{}", "LICENCES.txt": "MIT -- a"}.items():
        (folder / name).write_text(content)
    monkeypatch.setattr("facezip.viewer.page.BUNDLE", folder)
    return folder
