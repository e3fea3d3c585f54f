"""A small part of ``make trust``, and everything that fuzzing has found."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from facezip import FaceZipError
from tests.trust import fuzz
from tests.trust.fuzz import FINDINGS, finding
from tests.trust.names import CHROMIUM, MARKUP, dom_of
from tests.trust.system_calls import MISSING, may_trace

READERS = {".obj": "mesh", ".glb": "glb"}
SECURITY = Path(__file__).parents[2] / "SECURITY.md"
# A line that has cases, without its notes.
LINE = re.compile(r"^  ok   +[0-9,]+  ([^(\n]*[^ (\n])", re.MULTILINE)


def test_a_part_of_the_table_holds_and_all_of_its_lines_are_published():
    """In a process without threads: all but its own are forked."""
    call = [sys.executable, "-m", "tests.trust", "--part", "0.02"]
    done = subprocess.run(call, capture_output=True, text=True, timeout=500, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "FAIL" not in done.stdout
    made, published = lines(done.stdout), lines(SECURITY.read_text("utf-8"))
    assert [line for line in made if line not in published] == []
    if "  skip  " not in done.stdout:
        # Pages that are rendered for, and code of other processors, are of the whole table alone.
        in_part = [line for line in published if not line.startswith("page of ") and "other processors" not in line]
        assert [line for line in in_part if line not in made] == []


def lines(table):
    """What each line is of and what must not happen, whatever the numbers."""
    return [re.sub(r"[0-9,]*[0-9]", "N", line) for line in LINE.findall(table)]


# What each promise rests on, taken away: a check that does not notice shows nothing.
BROKEN = {
    "power": "from facezip.files import writing; writing._sync = lambda *_: None",
    "refusals": "from facezip.files import images; images.has_arrived = lambda *_: True",
    "contention": "from facezip.pack import read; read.undisturbed = lambda _, reading: reading()",
}


@pytest.mark.skipif(not may_trace(), reason=MISSING)
@pytest.mark.parametrize("check", BROKEN)
def test_the_table_finds_what_is_broken(check):
    run = f"import sys; {BROKEN[check]}; sys.argv[1:] = '--part 0.05 --only {check}'.split(); main()"
    call = [sys.executable, "-c", f"from tests.trust.__main__ import main; {run}"]
    done = subprocess.run(call, capture_output=True, text=True, timeout=250, check=False)
    assert done.returncode == 1, done.stdout + done.stderr
    assert "FAIL" in done.stdout


@pytest.mark.parametrize("file", sorted(FINDINGS.iterdir()), ids=lambda file: file.name)
def test_what_was_found_once_is_refused_since(file):
    reader = READERS.get(file.suffix, "image")
    assert finding(reader, file) == ""
    with pytest.raises(FaceZipError):
        fuzz.READERS[reader](file)


@pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed")
def test_the_browser_would_run_what_is_not_escaped(tmp_path):
    (tmp_path / "page.html").write_text(f"<!doctype html>{MARKUP[2]}")
    assert "data-owned" in dom_of(tmp_path / "page.html")
