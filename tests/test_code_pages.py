"""Names have letters that a code page lacks: they are escaped, and everything else is as it would be."""

import io
import sys
from dataclasses import replace

import pytest

from facezip import cli
from facezip.pack.write import write_pack
from tests.facezip.viewer.models import random_maps

NAMES = ("smile", "笑顔", "grîmace", "улыбка", "\N{GRINNING FACE}")


@pytest.fixture(scope="module")
def pack(tmp_path_factory):
    model = replace(random_maps(expressions=len(NAMES)), expressions=NAMES)
    path = tmp_path_factory.mktemp("code pages") / "笑.facezip"
    write_pack(model, path)
    return path


def said(monkeypatch, encoding, *words):
    """The exit code of a command, and the bytes that it writes to a pipe of that code page."""
    pipe = io.BytesIO()
    with monkeypatch.context() as patch:
        patch.setattr(sys, "stdout", io.TextIOWrapper(pipe, encoding=encoding))
        patch.setattr(sys, "argv", ["facezip", *map(str, words)])
        with pytest.raises(SystemExit) as ended:
            cli.main()
        sys.stdout.flush()
        return ended.value.code, pipe.getvalue()


@pytest.mark.parametrize(
    "encoding", ["ascii", "cp1252", "cp437", "latin-1", "shift_jis", "koi8-r", "utf-8", "utf-16-le"]
)
@pytest.mark.parametrize("verb", ["info", "verify"])
def test_letters_that_a_page_lacks_are_escaped_and_nothing_else_changes(monkeypatch, pack, encoding, verb):
    _, plain = said(monkeypatch, "utf-8", verb, pack)
    code, content = said(monkeypatch, encoding, verb, pack)
    assert code == 0
    assert content.decode(encoding) == plain.decode().encode(encoding, "backslashreplace").decode(encoding)


def test_help_is_printed_everywhere(monkeypatch):
    for words in ([], ["compress"], ["decompress"]):
        assert said(monkeypatch, "cp437", *words, "--help")[0] == 0


def test_a_document_for_programs_is_the_same_on_every_page(monkeypatch, pack):
    documents = {said(monkeypatch, encoding, "info", pack, "--json") for encoding in ("ascii", "cp1252", "utf-8")}
    assert len(documents) == 1
