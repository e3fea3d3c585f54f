"""A kept kernel is used again as long as no file changes that it came from, and no longer."""

import subprocess
import sys
from pathlib import Path

import pytest

# A kernel takes in a function of another module, and that one a constant of a third.
MODULES = {
    "kernels_of_mine": "from facezip.machine.kernels import kernel\nfrom inner_of_mine import times\n"
    "@kernel()\ndef scaled(value):\n    return times(value)\n",
    "inner_of_mine": "from facezip.machine.kernels import inner\nfrom constants_of_mine import FACTOR\n"
    "@inner()\ndef times(value):\n    return FACTOR * value\n",
    "constants_of_mine": "FACTOR = 2\n",
    "bystander": "from kernels_of_mine import scaled\n",
}
RUN = "import kernels_of_mine as k; print(k.scaled(10), sum(k.scaled.stats.cache_hits.values()))"


@pytest.fixture
def folder(tmp_path):
    for name, text in MODULES.items():
        (tmp_path / f"{name}.py").write_text(text)
    assert run(tmp_path) == (20, 0)
    assert run(tmp_path) == (20, 1)
    return tmp_path


def run(folder: Path) -> tuple[int, int]:
    """The result, and how often a kept kernel was found."""
    call = [sys.executable, "-c", RUN]
    result, hits = subprocess.check_output(call, cwd=folder, text=True, timeout=60).split()
    return int(result), int(hits)


@pytest.mark.parametrize(
    ("name", "before", "after", "result"),
    [
        ("kernels_of_mine", "times(value)", "times(value) + 1", 21),
        ("inner_of_mine", "FACTOR * value", "FACTOR + value", 12),
        ("constants_of_mine", "2", "3", 30),
    ],
)
def test_a_change_of_any_file_is_compiled(folder, name, before, after, result):
    source = folder / f"{name}.py"
    source.write_text(source.read_text().replace(before, after))
    assert run(folder) == (result, 0)


def test_other_files_may_change(folder):
    (folder / "bystander.py").write_text("# Another one.")
    assert run(folder) == (20, 1)
