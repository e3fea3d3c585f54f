"""Kept figures: the file reads back as it is, pages print its numbers, and it says what the code does today."""

import re
from dataclasses import replace
from decimal import Decimal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from facezip.errors import ErrorCode, FaceZipError
from reports.kept import cost as cost_module
from reports.kept.__main__ import ANSWERS, RESULTS
from reports.kept.answers import QUESTIONS, Figure, numbers, read_figures, unanswered, write_figures
from reports.kept.cost import cost
from reports.kept.inputs import code_of, digest
from reports.kept.measure import FIRST, USUAL, measure, rows_of, stale
from reports.kept.pages import NUMBER, pages, renewed
from reports.kept.rows import Row, read_rows, write_rows

ROWS, FIGURES = read_rows(RESULTS), read_figures(ANSWERS)
ROW = Row(
    character="embedded",
    size=512,
    expressions=20,
    method="refined",
    rmse=1.1949,
    bytes_on_gpu=4_259_840,
    bytes_bc7=1_638_400,
    bits=0.833,
    fetches=6,
    cpu=2.9,
    cpu_spread=0.02,
    versions="numpy 2, numba 1",
    inputs="0123456789ab",
    command="compress scans -o me.facezip",
)
# Tables whose every number is kept, by words of their header.
WHOLE_TABLES = ("fetches", "embedded head", "a real capture")


@pytest.mark.parametrize("page", pages(), ids=lambda page: page.name)
def test_the_numbers_of_a_page_are_those_that_were_measured(page):
    text = page.read_text(encoding="utf-8")
    assert renewed(text, ROWS, FIGURES) == text, "'python -m reports.kept --pages' writes them anew"


def test_tables_of_methods_print_no_number_that_is_not_kept():
    texts = [page.read_text(encoding="utf-8") for page in pages()]
    tables = [table.splitlines() for text in texts for table in re.findall(r"(?:^\|.*\n)+", text, re.MULTILINE)]
    whole = [lines for head, *lines in tables if all(word in head for word in WHOLE_TABLES)]
    assert whole
    for line in (line for lines in whole for line in lines):
        bare = re.sub(r"`[^`]*`", "", NUMBER.sub("", line))
        assert re.findall(r"\d+\.\d+", bare) == [], line


def test_the_file_reads_back_as_it_is(tmp_path):
    write_rows(tmp_path / "again.csv", ROWS.values())
    assert (tmp_path / "again.csv").read_bytes() == RESULTS.read_bytes()
    write_figures(tmp_path / "again.csv", list(FIGURES.values()))
    assert (tmp_path / "again.csv").read_bytes() == ANSWERS.read_bytes()


def test_rows_stand_in_one_order_and_keep_their_cells(tmp_path):
    rows = [ROW, replace(ROW, size=64, cpu=None), replace(ROW, method="paper", command='a, "b"')]
    write_rows(tmp_path / "one.csv", rows)
    write_rows(tmp_path / "other.csv", reversed(rows))
    assert (tmp_path / "one.csv").read_bytes() == (tmp_path / "other.csv").read_bytes()
    assert read_rows(tmp_path / "one.csv") == {row.key: row for row in rows}


def test_what_the_code_does_today_is_what_is_kept(tmp_path):
    """At the size that is measured in seconds: a change of a fit is to be seen in the file."""
    first, free = replace(FIRST, methods=("refined", "pca-8")), {"rmse": 0, "bits": 0, "versions": "", "inputs": ""}
    for row in rows_of(first, tmp_path):
        kept = ROWS[row.key]
        assert row.rmse == pytest.approx(kept.rmse, rel=0.02), "'make figures' measures anew"
        assert replace(row, **free) == replace(kept, **free)


@given(st.integers(0, 4), st.floats(0, 999, allow_nan=False))
def test_a_number_keeps_the_decimals_that_it_is_written_with(decimals, value):
    written = f"{0:.{decimals}f}"
    page = f"| **{written}**<!--kept embedded/512/refined/rmse--> | 7.1 |"
    new = renewed(page, {ROW.key: replace(ROW, rmse=value)}, {})
    assert abs(Decimal(new.split("**")[1]) - Decimal(value)) <= Decimal("0.5000001") * Decimal(10) ** -decimals
    assert len(new.split("**")[1].partition(".")[2]) == decimals
    assert new.endswith("<!--kept embedded/512/refined/rmse--> | 7.1 |")


def test_bytes_are_in_megabytes_and_two_figures_are_a_ratio():
    rows = {ROW.key: ROW, "embedded/512/textures": replace(ROW, method="textures", bytes_on_gpu=16_515_072)}
    page = "1.0<!--kept embedded/512/textures/bytes_on_gpu--> MB, "
    page += "1.00<!--kept embedded/512/textures/bytes_on_gpu / embedded/512/refined/bytes_on_gpu--> times"
    assert renewed(page, rows, {}).startswith("16.5<!--")
    assert " 3.88<!--" in renewed(page, rows, {})


@pytest.mark.parametrize("source", ["embedded/512/nothing/rmse", "embedded/512/refined/nothing", "rmse", "rig/ours"])
def test_a_figure_that_is_not_kept_is_refused(source):
    with pytest.raises(FaceZipError) as caught:
        renewed(f"1.0<!--kept {source}-->", {ROW.key: ROW}, {})
    assert caught.value.code is ErrorCode.UNKNOWN_NAME


def test_a_page_prints_what_a_benchmark_answered():
    figure = Figure("rig/clean/ours", 0.4712, "0123456789ab", "bench rig")
    page = "**0.00**<!--kept rig/clean/ours-->, 0<!--kept embedded/512/refined/fetches-->"
    assert renewed(page, {ROW.key: ROW}, {figure.key: figure}).startswith("**0.47**<!--")
    assert ", 6<!--" in renewed(page, {ROW.key: ROW}, {figure.key: figure})


def test_every_number_of_an_answer_has_a_name_and_times_have_none():
    answer = {
        "format": "facezip-bench/1",
        "ways": [{"way": "shared, 1/4", "rmse": 1.23456, "rmse_per_expression": {"smile": 1}, "seconds": 3.0}],
        "mips": [{"size": [64, 64], "fitted": 0.5}],
        "kept": True,
        "counts": [3, None],
    }
    assert dict(numbers(answer)) == {
        "ways/shared, 1/4/rmse": 1.2346,
        "mips/64/fitted": 0.5,
        "counts/0": 3,
    }


def test_only_what_depends_on_something_else_by_now_is_measured(monkeypatch):
    subject = replace(USUAL[0], methods=("refined", "paper"))
    row = replace(ROW, size=subject.size, inputs=subject.inputs)
    assert stale(subject, {}).methods == ("refined", "paper")
    assert stale(subject, {row.key: row}).methods == ("paper",)
    assert stale(subject, {row.key: replace(row, inputs="")}).methods == ("refined", "paper")
    fresh = {key: replace(row, method=key.split("/")[-1]) for key in ("embedded/256/refined", "embedded/256/paper")}
    assert list(measure([stale(subject, fresh)])) == []
    figures = {question.name: Figure(f"{question.name}/x", 0.0, question.inputs, "") for question in QUESTIONS}
    assert unanswered(QUESTIONS, figures) == []
    changed = replace(figures["rig"], inputs="")
    assert [question.name for question in unanswered(QUESTIONS, figures | {"rig": changed})] == ["rig"]


def test_a_digest_sees_code_and_files_and_neither_comments_nor_docstrings(tmp_path):
    assert code_of('"""Says."""\n\ndef f(x):\n    """Says."""\n    # why\n    return x + 1\n') == code_of(
        "def f(x): return (x + 1)"
    )
    assert code_of("def f(x): return x + 1") != code_of("def f(x): return x + 2")
    image = tmp_path / "neutral.png"
    image.write_bytes(b"1")
    found = digest((), tmp_path, 512)
    assert found == digest((), tmp_path, 512) != digest((), tmp_path, 256)
    assert digest(("scenes",), tmp_path, 512) != found
    image.write_bytes(b"2")
    assert digest((), tmp_path, 512) != found


def test_a_cost_is_the_same_on_a_machine_that_gets_slower(monkeypatch):
    """Twice as slow with every repeat; yardsticks on both sides follow it."""
    now, slowness = [0.0], [1.0]

    def take(seconds):
        now[0] += seconds * slowness[0]
        slowness[0] *= 1.02

    monkeypatch.setattr(cost_module, "process_time", lambda: now[0])
    found = cost(lambda: take(3.5), lambda: take(1.0))
    assert found.ratio == pytest.approx(3.5, rel=1e-3)
    assert found.spread < 1e-3
