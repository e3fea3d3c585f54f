"""The page of the paper: self-contained, safe with hostile names, true to its document."""

import json
from dataclasses import replace

import pytest

from facezip.documents.document import plain
from facezip.errors import ErrorCode, FaceZipError
from reports.paper.experiments import Settings
from reports.paper.report import write_paper_report
from reports.paper.reproduction import reproduce
from reports.paper.sections import sections
from tests.documents.checked import check
from tests.facezip.conftest import random_character
from tests.reports.test_validation import Page

HOSTILE = "<script>alert(1)</script>\"'><img src=x onerror=alert(2)> {{ 7*7 }} & ]]>"


@pytest.fixture(scope="module")
def document():
    character = replace(random_character(side=32), expressions=(HOSTILE, "b", "c", "d", "e"), name=HOSTILE)
    settings = Settings(masks=5, restarts=4, starts=3, mask_counts=(3, 9))
    return replace(reproduce([character], 1, settings, "as they are"), command=HOSTILE)


def test_a_page_loads_nothing_but_itself_and_names_run_nothing(document, tmp_path):
    page = Page(write_paper_report(document, tmp_path).read_text(encoding="utf-8"))
    assert [url for url in page.references if not url.startswith(("data:", "#"))] == []
    assert page.handlers == []
    assert len(page.scripts) == 1
    assert page.count("img") == 0


def test_every_section_has_its_place_in_the_navigation(document, tmp_path):
    page = Page(write_paper_report(document, tmp_path).read_text(encoding="utf-8"))
    anchors = {attrs.get("id") for name, attrs in page.tags if name == "section"}
    assert {url[1:] for url in page.references if url.startswith("#")} - {"main"} == anchors
    assert {section.anchor for section in sections(document)} < anchors
    assert page.count("svg", "chart") >= 10


def test_every_plot_comes_for_wide_pages_and_for_telephones(document, tmp_path):
    page = Page(write_paper_report(document, tmp_path).read_text(encoding="utf-8"))
    assert page.count("figure", "wide") == page.count("figure", "narrow") == 5


def test_json_beside_the_page_holds_the_document(document, tmp_path):
    write_paper_report(document, tmp_path)
    stored = json.loads((tmp_path / "paper.json").read_text(encoding="utf-8"))
    assert check(stored) == "paper"
    keys = {"table_1", "figure_6", "figure_7_convergence", "figure_7_masks", "findings", "conditions", "character"}
    assert keys <= set(stored)
    assert stored["figure_6"] == plain(document.figure_6)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["index.html", "paper.json"]


def test_numbers_of_the_document_are_on_the_page(document, tmp_path):
    words = Page(write_paper_report(document, tmp_path).read_text(encoding="utf-8")).words
    assert f"{document.figure_6.rmse['paper']:.2f}" in words
    for finding in document.findings:
        assert finding.here.replace("\N{NO-BREAK SPACE}", " ") in words


def test_the_same_document_makes_the_same_bytes(document, tmp_path):
    first = write_paper_report(document, tmp_path).read_bytes()
    assert write_paper_report(document, tmp_path).read_bytes() == first


def test_a_folder_that_cannot_be_written_is_named(document, tmp_path):
    (tmp_path / "nowhere").write_bytes(b"")
    with pytest.raises(FaceZipError, match="nowhere") as caught:
        write_paper_report(document, tmp_path / "nowhere")
    assert caught.value.code is ErrorCode.CANNOT_WRITE
