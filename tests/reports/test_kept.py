"""Kept figures: the file reads back as it is, pages print its numbers, and it says what the code does today."""

import re
from dataclasses import replace
from decimal import Decimal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from facezip.errors import ErrorCode, FaceZipError
from reports.kept.__main__ import RESULTS
from reports.kept.measure import FIRST, rows_of
from reports.kept.pages import NUMBER, pages, renewed
from reports.kept.rows import Row, read_rows, write_rows

ROWS = read_rows(RESULTS)
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
    versions="numpy 2, numba 1",
    command="compress scans -o me.facezip",
)
# Tables whose every number is kept, by words of their header.
WHOLE_TABLES = ("fetches", "embedded head", "a real capture")


@pytest.mark.parametrize("page", pages(), ids=lambda page: page.name)
def test_the_numbers_of_a_page_are_those_that_were_measured(page):
    text = page.read_text(encoding="utf-8")
    assert renewed(text, ROWS) == text, "'python -m reports.kept --pages' writes them anew"


@pytest.mark.parametrize("page", pages(), ids=lambda page: page.name)
def test_tables_of_methods_print_no_number_that_is_not_kept(page):
    for table in re.findall(r"(?:^\|.*\n)+", page.read_text(encoding="utf-8"), re.MULTILINE):
        head, *lines = table.splitlines()
        if all(word in head for word in WHOLE_TABLES):
            for line in lines:
                bare = re.sub(r"`[^`]*`", "", NUMBER.sub("", line))
                assert re.findall(r"\d+\.\d+", bare) == [], line


def test_the_file_reads_back_as_it_is(tmp_path):
    write_rows(tmp_path / "again.csv", ROWS.values())
    assert (tmp_path / "again.csv").read_bytes() == RESULTS.read_bytes()


def test_rows_stand_in_one_order_and_keep_their_cells(tmp_path):
    rows = [ROW, replace(ROW, size=64, cpu=None), replace(ROW, method="paper", command='a, "b"')]
    write_rows(tmp_path / "one.csv", rows)
    write_rows(tmp_path / "other.csv", reversed(rows))
    assert (tmp_path / "one.csv").read_bytes() == (tmp_path / "other.csv").read_bytes()
    assert read_rows(tmp_path / "one.csv") == {row.key: row for row in rows}


def test_what_the_code_does_today_is_what_is_kept(tmp_path):
    """At the size that is measured in seconds: a change of a fit is to be seen in the file."""
    first = replace(FIRST, methods=("refined", "pca-8"))
    for row in rows_of(first, tmp_path, timed=False):
        kept = ROWS[row.key]
        assert row.rmse == pytest.approx(kept.rmse, rel=0.02), "'make figures' measures anew"
        assert replace(row, rmse=0, versions="", bits=0) == replace(kept, rmse=0, versions="", bits=0)


@given(st.integers(0, 4), st.floats(0, 999, allow_nan=False))
def test_a_number_keeps_the_decimals_that_it_is_written_with(decimals, value):
    written = f"{0:.{decimals}f}"
    page = f"| **{written}**<!--kept embedded/512/refined/rmse--> | 7.1 |"
    new = renewed(page, {ROW.key: replace(ROW, rmse=value)})
    assert abs(Decimal(new.split("**")[1]) - Decimal(value)) <= Decimal("0.5000001") * Decimal(10) ** -decimals
    assert len(new.split("**")[1].partition(".")[2]) == decimals
    assert new.endswith("<!--kept embedded/512/refined/rmse--> | 7.1 |")


def test_bytes_are_in_megabytes_and_two_figures_are_a_ratio():
    rows = {ROW.key: ROW, "embedded/512/textures": replace(ROW, method="textures", bytes_on_gpu=16_515_072)}
    page = "1.0<!--kept embedded/512/textures/bytes_on_gpu--> MB, "
    page += "1.00<!--kept embedded/512/textures/bytes_on_gpu / embedded/512/refined/bytes_on_gpu--> times"
    assert renewed(page, rows).startswith("16.5<!--")
    assert " 3.88<!--" in renewed(page, rows)


@pytest.mark.parametrize("source", ["embedded/512/nothing/rmse", "embedded/512/refined/nothing", "rmse"])
def test_a_figure_that_is_not_kept_is_refused(source):
    with pytest.raises(FaceZipError) as caught:
        renewed(f"1.0<!--kept {source}-->", {ROW.key: ROW})
    assert caught.value.code is ErrorCode.UNKNOWN_NAME
