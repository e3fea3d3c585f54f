"""Whose a pack is, and whether it is finished."""

import json

import pytest

from facezip.batch import finished
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.packs import MANIFEST
from facezip.fit.documents import CompressDocument
from facezip.pack.errors import MapErrors
from facezip.pack.write import write_pack
from tests.documents.checked import check
from tests.facezip.conftest import random_model
from tests.facezip.surfaces import random_surface

DOCUMENT = CompressDocument(
    name="anna", method="pca", resolution=(8, 8), channels=3, differences=4, weight_scale=None, expressions=["smile"],
    masks=None, maps=[], tiles=[], bytes_on_gpu=1, bytes_on_disk=2, bytes_raw=3, bytes_bc7=4, bytes_raw_bc7=5,
    bytes_geometry=6, bits_per_texel_channel=0.5, fetches=5, vertices=7, made_with={"seed": 0}, rmse=1.5,
    rmse_per_expression={"smile": 1.5}, errors={"albedo": MapErrors(rmse=1.5)}, region="mask", misregistered={},
    unknown=[], pack="anna.facezip", seconds=1.0,
)  # fmt: skip


@pytest.fixture
def pack(tmp_path):
    return tmp_path / "packs" / "anna.facezip"


@pytest.fixture
def anna(tmp_path):
    return tmp_path / "scans" / "anna"


def make(pack, seed=0):
    write_pack(random_model(seed), pack, overwrite=True)


def finish(pack, character, digest="d"):
    make(pack)
    finished.keep(pack, character, digest, DOCUMENT)


def claim(pack, character, digest="other", overwrite=False, work=lambda: None):
    with finished.claimed(pack, character, digest, overwrite):
        work()


def test_a_run_that_is_killed_leaves_a_pack_that_the_next_may_replace(pack, anna):
    pack.parent.mkdir()
    with pytest.raises(KeyboardInterrupt):
        claim(pack, anna, work=lambda: (make(pack), (_ for _ in ()).throw(KeyboardInterrupt)))
    assert finished.find(pack, "other") is None
    assert finished.earlier(pack.parent, ()) == {}
    claim(pack, anna)


def test_a_run_that_fails_leaves_the_record_as_it_was(pack, anna):
    pack.parent.mkdir()

    def fail():
        raise FaceZipError(ErrorCode.BAD_TEXELS, "not a number")

    with pytest.raises(FaceZipError, match="not a number"):
        claim(pack, anna, work=fail)
    assert not any(pack.parent.iterdir())
    finish(pack, anna)
    with pytest.raises(FaceZipError, match="not a number"):
        claim(pack, anna, work=fail)
    assert finished.find(pack, "d") == DOCUMENT


def test_who_may_replace_a_pack(pack, anna, tmp_path):
    make(pack)
    with pytest.raises(FaceZipError, match="not made by a batch"):
        claim(pack, anna)
    finish(pack, anna)
    bert = tmp_path / "scans" / "bert"
    with pytest.raises(FaceZipError, match="is of .*anna"):
        claim(pack, bert)
    # The same bytes with the same settings, moved.
    claim(pack, bert, digest="d")
    finish(pack, anna)
    make(pack, seed=1)
    with pytest.raises(FaceZipError, match="not made by a batch"):
        claim(pack, anna)
    (pack / MANIFEST).write_bytes((pack / MANIFEST).read_bytes()[:-9])
    claim(pack, anna)
    make(pack, seed=1)
    claim(pack, bert, overwrite=True)


@pytest.mark.parametrize(
    "content",
    [
        *(b"", b"[]", b"{}", b'{"character": "anna", "document": 3}', b"\xff"),
        pytest.param(b"[" * 99999, id="nested without end"),
    ],
)
def test_a_spoilt_record_is_none(pack, anna, content):
    finish(pack, anna)
    pack.with_name("anna.facezip.json").write_bytes(content)
    assert finished.find(pack, "d") is None
    assert finished.earlier(pack.parent, ()) == {}


def test_a_record_is_as_published_and_those_before_said_no_format(pack, anna):
    finish(pack, anna)
    path = pack.with_name("anna.facezip.json")
    record = json.loads(path.read_text())
    assert check(record) == "record"
    del record["format"]
    path.write_text(json.dumps(record))
    assert finished.find(pack, "d") is not None
    path.write_text(json.dumps({**record, "format": "facezip-record/2"}))
    assert finished.find(pack, "d") is None


def test_packs_of_several_maps_are_found_again(pack, anna):
    from facezip.fit.methods import compress

    write_pack(compress(random_surface(expressions=3), method="pca"), pack)
    finished.keep(pack, anna, "d", DOCUMENT)
    assert finished.find(pack, "d") == DOCUMENT
    assert finished.earlier(pack.parent, ()) == {"anna": (str(anna), DOCUMENT)}


def test_a_record_of_other_documents_says_whose_a_pack_is_and_no_more(pack, anna, tmp_path):
    finish(pack, anna)
    path = pack.with_name("anna.facezip.json")
    record = json.loads(path.read_text())
    path.write_text(json.dumps(record | {"document": {"rmse": 1.5}}))
    assert finished.find(pack, "d") is None
    claim(pack, anna)
    with pytest.raises(FaceZipError, match="is of .*anna"):
        claim(pack, tmp_path / "scans" / "bert")
