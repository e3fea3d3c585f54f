"""Documents read from files: of the version that is known, and refused with a code otherwise."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as some

from facezip.documents.document import plain, to_json
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.documents import parsed, read_document
from render.plugin.results import ImagesDocument, StaleReference

_text = some.text(max_size=8)
STALE = some.builds(StaleReference, reference=_text, test=_text)
DOCUMENTS = some.builds(
    ImagesDocument, results=some.just([]), stale=some.lists(STALE, max_size=3), idle=some.integers(0, 9)
)
EMPTY = plain(ImagesDocument(results=[], stale=[], idle=0))


def refused(content, path):
    with pytest.raises(FaceZipError) as caught:
        parsed(content, ImagesDocument, path)
    assert str(path) in str(caught.value)
    return caught.value.code


@given(DOCUMENTS, some.dictionaries(some.sampled_from(["more", "later"]), some.integers()))
def test_a_document_reads_back_whatever_fields_its_version_gained(document, gained):
    text = json.dumps({**plain(document), **gained})
    assert parsed(text.encode(), ImagesDocument, "a.json") == document


@given(_text.filter(lambda stated: stated != EMPTY["format"]))
def test_another_version_is_refused(stated):
    assert refused(json.dumps({**EMPTY, "format": stated}).encode(), "a.json") is ErrorCode.OTHER_FORMAT


@pytest.mark.parametrize("name", ["format", "results", "stale", "idle"])
@pytest.mark.parametrize("value", [None, 1.5, {}])
def test_a_field_of_another_type_is_refused(name, value):
    assert refused(json.dumps({**EMPTY, name: value}).encode(), "a.json") is ErrorCode.BAD_VALUE


@pytest.mark.parametrize("content", [b"", b"[]", b"{", b"\xff", b"[" * 100_000, to_json(EMPTY).encode()[:-1]])
def test_what_is_no_document_is_refused(content):
    assert refused(content, "a.json") is ErrorCode.BAD_VALUE


def test_a_file_that_is_not_there_is_refused(tmp_path):
    with pytest.raises(FaceZipError) as caught:
        read_document(tmp_path / "a.json", ImagesDocument)
    assert caught.value.code is ErrorCode.CANNOT_READ
