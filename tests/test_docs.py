"""What the documentation tells people is tried here: commands and Python run, links and paths lead somewhere.

All commands of a page run in one process, as do all its blocks of Python: starting takes longer than most of them.
"""

import json
import re
import subprocess
import sys
import tomllib
from importlib import import_module
from pathlib import Path

import click
import numpy as np
import pytest

from facezip import ErrorCode, compress, write_pack
from facezip.character.loading import save_character
from facezip.cli import VERBS, facezip
from facezip.files.images import write_texture
from reports.site import BESIDE, ROOT
from scenes.character import make_character

PAGES = {path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8") for path in (
    *sorted((ROOT / "docs").glob("*.md")), *(ROOT / name for name in BESIDE)
)}  # fmt: skip
BLOCK = re.compile(r"```(\w*)\n(.*?)```", re.DOTALL)
# Pages whose commands run, one after the other, beside the folder of scans that they name.
RUN = ("README.md", "docs/compress.md", "docs/budgets.md", "docs/ci.md", "docs/tutorial.md")
# What would not end, is another program, or makes what a page has made already.
NOT_RUN = ("facezip view", "facezip rates")
# Smaller than people want them, so that tests end.
SMALLER = {
    "demo": "--resolution 64 --expressions 4 --image-resolution 32 --spp 2",
    "validate": "--resolution 32 --spp 2",
    "animate": "--resolution 32 --spp 2",
}
EACH_COMMAND = """
import json, sys
from facezip.cli import main
for words in json.loads(sys.argv.pop()):
    sys.argv[1:] = words
    try:
        main()
    except SystemExit as end:
        # A head of few texels shows too little to tell whether it is registered.
        assert end.code in ((0, 7) if words[0] == "check" else (0,)), (words, end.code)
"""
EACH_BLOCK = """
import json, sys
for block in json.loads(sys.argv.pop()):
    exec(block, {})
"""
PATH = re.compile(r"`((?:facezip|render|scenes|reports|tests|docs)/[a-z0-9_/.-]+)`")


def blocks(page, kind):
    return [block for found, block in BLOCK.findall(PAGES[page]) if found == kind]


def commands(page):
    """Command lines of FaceZip, as a page shows them in blocks for a shell."""
    lines = (line.split("#")[0].split(" > ")[0].strip() for block in blocks(page, "sh") for line in block.splitlines())
    return [line for line in lines if line.startswith("facezip ")]


@pytest.fixture(scope="module")
def scans():
    """A head whose first two expressions have the names that pages use."""
    return make_character(64, 4, nuisances=0, maps=("normal", "roughness"))


@pytest.fixture
def place(scans, tmp_path):
    """A folder with all files that pages speak of."""
    save_character(scans, tmp_path / "my_scans")
    (tmp_path / "masks").mkdir()
    write_texture(tmp_path / "masks" / "brow.png", np.full((8, 8, 1), 255, np.uint8))
    write_texture(tmp_path / "neutral.exr", np.zeros((8, 8, 3), np.float32))
    (tmp_path / "scans").symlink_to("my_scans")
    (tmp_path / "me.json").write_text('{"rmse": 1, "rmse_per_expression": {}, "bytes_bc7": 1}')
    return tmp_path


def run(script, lines, place):
    command = [sys.executable, "-c", script, json.dumps(lines)]
    done = subprocess.run(command, cwd=place, capture_output=True, text=True, timeout=280, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("page", [page for page in PAGES if commands(page)])
def test_the_commands_of_a_page_are_taken(page):
    for line in commands(page):
        _, verb, *words = line.replace("…", "pca").split()
        command = import_module(f"facezip.commands.{verb}").command
        if isinstance(command, click.Group):
            command, words = command.commands[words[0]], words[1:]
        try:
            command.make_context(verb, words, parent=click.Context(facezip), resilient_parsing="--help" in words)
        except click.ClickException as error:
            pytest.fail(f"{line}: {error.format_message()}")


@pytest.mark.parametrize("page", RUN)
def test_the_commands_of_a_page_run_as_written_one_after_the_other(page, place):
    lines = [line for line in commands(page) if not line.startswith(NOT_RUN)]
    words = [[*line.split()[1:], *SMALLER.get(line.split()[1], "").split()] for line in lines]
    run(EACH_COMMAND, words, place)


@pytest.mark.parametrize("page", [page for page in PAGES if blocks(page, "python")])
def test_the_python_of_a_page_runs_as_written_one_after_the_other(page, place, scans):
    if "write_pack(" not in PAGES[page]:
        write_pack(compress(scans), place / "me.facezip")
    run(EACH_BLOCK, blocks(page, "python"), place)


@pytest.mark.parametrize("page", PAGES)
def test_links_and_paths_of_a_page_lead_somewhere(page):
    here = (ROOT / page).parent
    for target in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", PAGES[page]):
        assert (here / target).exists(), target
    for path in PATH.findall(PAGES[page]):
        assert (ROOT / path).exists() or (ROOT / f"{path}.py").exists(), path


def test_every_verb_has_a_task():
    assert [verb for verb in VERBS if f"`facezip {verb}" not in PAGES["docs/tasks.md"]] == []


def test_every_page_is_in_the_navigation_once():
    site = tomllib.loads((ROOT / "zensical.toml").read_text(encoding="utf-8"))["project"]
    shown = [
        page for group in site["nav"] for entries in group.values() for entry in entries for page in entry.values()
    ]
    there = [Path(page).name for page in PAGES if page.startswith("docs/")] + [*BESIDE.values(), "commands.md"]
    assert sorted(shown) == sorted(there)


@pytest.mark.parametrize("code", ErrorCode)
def test_every_error_code_has_a_cause_and_a_remedy(code):
    sections = dict(re.findall(r"^### (\S+)\n(.*?)(?=^#|\Z)", PAGES["docs/errors.md"], re.DOTALL | re.MULTILINE))
    assert "**Cause.**" in sections[code]
    assert "**Remedy.**" in sections[code]
    assert set(sections) == set(ErrorCode)


def test_pictures_are_small_and_used():
    for picture in [*(ROOT / "docs").glob("*.webp"), *(ROOT / "docs").glob("*.svg")]:
        assert picture.stat().st_size < 1.5e6, picture.name
        assert any(f"{picture.name})" in text for text in PAGES.values()), picture.name


def test_the_citation_states_the_version():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert f"\nversion: {project['version']}\n" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")
