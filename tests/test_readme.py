"""What the README tells people to type is typed here."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from facezip.character.loading import save_character
from facezip.cli import VERBS
from scenes.character import make_character

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```(\w*)\n(.*?)```", README, re.DOTALL)
COMMANDS = [
    line.split("#")[0].split()
    for kind, block in BLOCKS
    if kind == "sh"
    for line in block.splitlines()
    if line.startswith("facezip ")
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A place with ``my_scans`` in it, its first two expressions called as in the README."""
    folder = tmp_path_factory.mktemp("readme")
    save_character(make_character(64, 4, nuisances=0), folder / "my_scans")
    return folder


def test_the_readme_shows_commands():
    assert len(COMMANDS) >= 4
    assert {words[1] for words in COMMANDS} <= {*VERBS}


def test_the_commands_run_as_written_one_after_the_other(folder):
    for words in COMMANDS:
        small = ["--resolution", "32", "--spp", "2"] if words[1] == "validate" else []
        command = [sys.executable, "-c", "from facezip.cli import main; main()", *words[1:], *small]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=280, check=False)
        assert done.returncode == 0, f"{' '.join(words)}: {done.stderr}"


def test_the_python_snippet_runs_as_written(folder):
    snippet = next(block for kind, block in BLOCKS if kind == "python").replace("me.facezip", "python.facezip")
    done = subprocess.run(
        [sys.executable, "-c", snippet], cwd=folder, capture_output=True, text=True, timeout=280, check=False
    )
    assert done.returncode == 0, done.stderr


def test_every_verb_and_every_linked_file_exists():
    for verb in VERBS:
        assert f"facezip {verb}" in README
    for target in re.findall(r"\]\(([^)#]+)\)", README):
        assert (ROOT / target).exists(), target
