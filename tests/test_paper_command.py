"""``facezip paper`` as its users call it."""

import json

import pytest

from facezip.character.loading import save_character
from facezip.errors import ExitCode
from tests.facezip.surfaces import random_surface
from tests.test_cli import run

QUICK = ("--masks", 5, "--restarts", 4, "--starts", 2, "--mask-count", 3)


@pytest.fixture(scope="module")
def scans(tmp_path_factory):
    folder = tmp_path_factory.mktemp("scans") / "sheet"
    save_character(random_surface(side=64, tiles=(1, 2)), folder)
    return folder


@pytest.fixture(scope="module")
def report(scans):
    folder = scans.parent / "report"
    done = run("paper", scans, "-o", folder, "--resolution", 32, "--resolution", 64, *QUICK, "--json")
    assert done.returncode == 0, done.stderr
    return folder, json.loads(done.stdout)


def test_the_report_is_a_page_with_its_numbers_beside_it(report):
    folder, document = report
    stored = json.loads((folder / "paper.json").read_text(encoding="utf-8"))
    assert (folder / "index.html").is_file()
    assert {key: value for key, value in document.items() if key not in ("output", "report")} == stored
    assert [row["resolution"] for row in stored["table_1"]] == [[16, 32], [32, 64]]
    assert stored["figure_6"]["resolution"] == [32, 64]
    page = (folder / "index.html").read_text(encoding="utf-8")
    assert "Measured on the albedo, as in the paper, of all 2 tiles" in page
    assert [kind["name"] for kind in stored["character"]["maps"]] == ["albedo"]


def test_the_report_names_the_command_that_makes_it_again(report):
    _, document = report
    assert (
        "--resolution 64 --resolution 32 --mask-count 3 --masks 5 --restarts 4 --starts 2 --seed 0"
        in document["command"]
    )
    assert ".tmp" not in json.dumps(document)


def test_a_report_is_replaced_only_when_told_to(report, scans):
    folder, _ = report
    calls = ("paper", scans, "-o", folder, *QUICK)
    assert run(*calls).returncode == ExitCode.CANNOT_WRITE
    done = run(*calls, "--overwrite")
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1] == f"  open {folder / 'index.html'}"


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        (("--resolution", 128), ExitCode.BAD_INPUT),
        (("--masks", 500), ExitCode.BAD_INPUT),
        (("--starts", 0), ExitCode.USAGE),
    ],
)
def test_a_wrong_call_writes_nothing(scans, tmp_path, arguments, code):
    done = run("paper", scans, "-o", tmp_path / "x", *arguments)
    assert done.returncode == code
    assert "Traceback" not in done.stderr
    assert not list(tmp_path.iterdir())


def test_without_a_character_the_embedded_one_is_made(tmp_path):
    done = run("paper", "-o", tmp_path / "x", "--resolution", 64, "--expressions", 3, *QUICK, "--json")
    assert done.returncode == 0, done.stderr
    document = json.loads(done.stdout)
    assert len(document["character"]["expressions"]) == 3
    assert document["table_1"][0]["resolution"] == [64, 64]
