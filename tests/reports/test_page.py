"""Pages: escaped, strict about what they are given, whole or not at all."""

import pytest
from jinja2 import UndefinedError

from reports.page import render_page, write_page


def test_a_template_without_its_data_is_an_error():
    with pytest.raises(UndefinedError):
        render_page("validation.html")


def test_base_escapes_its_title():
    assert "<title>a &lt;b&gt;</title>" in render_page("base.html", title="a <b>")


def test_a_page_leaves_one_file(tmp_path):
    path = write_page(tmp_path / "a.html", "base.html", title="a")
    assert [file.name for file in tmp_path.iterdir()] == ["a.html"]
    assert path.read_bytes().startswith(b"<!doctype html>")
