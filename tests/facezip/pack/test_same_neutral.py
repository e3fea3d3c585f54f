"""A pack beside the scans of another person is shown all the same, with a word; beside its own, without one."""

import pytest

from facezip.fit.methods import compress
from facezip.pack.read import read_pack
from facezip.pack.write import write_pack
from facezip.rigging.originals import originals_of
from facezip.viewer.scene import read_scene
from render.candidates import candidate
from tests.facezip.conftest import random_character

# What compares the two: `validate`, `animate`, and the viewer with originals.
BESIDE = {
    "validate": candidate,
    "animate": lambda scans, pack: originals_of(scans, read_pack(pack), pack),
    "view": lambda scans, pack: read_scene(pack, scans),
}


@pytest.fixture(scope="module")
def pack(tmp_path_factory):
    path = tmp_path_factory.mktemp("pack") / "person.facezip"
    write_pack(compress(random_character(seed=1), "pca", differences=1), path)
    return path


@pytest.mark.parametrize("beside", BESIDE)
@pytest.mark.parametrize(("seed", "words"), [(1, []), (2, ["neutral's albedo differs by"])])
def test_another_person_is_said(pack, caplog, beside, seed, words):
    BESIDE[beside](random_character(seed=seed), pack)
    said = [record.getMessage() for record in caplog.records if "albedo differs" in record.getMessage()]
    assert len(said) == len(words)
    assert all(word in line and str(pack) in line for word, line in zip(words, said, strict=True))
