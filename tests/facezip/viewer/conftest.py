import pytest

from facezip.pack.write import write_pack
from tests.facezip.conftest import random_model


@pytest.fixture(scope="module")
def pack(tmp_path_factory):
    path = tmp_path_factory.mktemp("pack") / "random.facezip"
    write_pack(random_model(meshes=True), path)
    return path


@pytest.fixture(scope="module")
def bundle(tmp_path_factory):
    """Stands for the bundle where it is not built: what Python does with it is the same."""
    folder = tmp_path_factory.mktemp("bundle")
    for name, content in {"viewer.js": "'use strict';", "viewer.css": "body{}", "LICENCES.txt": "MIT -- a"}.items():
        (folder / name).write_text(content)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("facezip.viewer.page.BUNDLE", folder)
        yield folder
