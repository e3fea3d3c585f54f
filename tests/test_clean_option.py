"""``--clean``: compress and batch take it, say what was done, and the pack states it; ``bench clean`` measures it."""

import json

import pytest
from click.testing import CliRunner

from facezip.character.loading import save_character
from facezip.cleaning.steps import STEPS
from facezip.cli import facezip
from facezip.errors import ExitCode
from scenes.character import make_character


def run(*arguments):
    result = CliRunner().invoke(facezip, [*map(str, arguments)], catch_exceptions=False)
    assert result.exit_code == ExitCode.DONE
    return result


@pytest.fixture(scope="module")
def scans(tmp_path_factory):
    folder = tmp_path_factory.mktemp("clean") / "person"
    save_character(make_character(128, 4, seed=6), folder)
    return folder


def test_compress_says_what_it_cleaned_and_the_pack_states_it(scans):
    pack = scans.parent / "all.facezip"
    document = json.loads(run("compress", scans, "-o", pack, "--clean", "all", "--json").stdout)
    assert tuple(document["cleaning"]) == STEPS
    assert document["cleaning"]["neutral"]["albedo.1001"]["noise"] > 0
    manifest = json.loads((pack / "manifest.json").read_text(encoding="utf-8"))
    assert manifest["made_with"]["clean"] == list(STEPS)


def test_a_person_reads_a_line_a_step(scans):
    lines = run(
        "compress", scans, "-o", scans.parent / "two.facezip", "--clean", "neutral", "--clean", "exposure"
    ).stdout
    assert "cleaned    exposure: " in lines
    assert "cleaned    neutral albedo.1001: noise" in lines
    assert "registration" not in lines


def test_without_it_nothing_is_cleaned(scans):
    document = json.loads(run("compress", scans, "-o", scans.parent / "none.facezip", "--json").stdout)
    assert "cleaning" not in document


def test_cleaning_brings_packs_nearer_to_the_truth():
    document = json.loads(run("bench", "clean", "--resolution", 128, "--seed", 6, "--json").stdout)
    steps = document["people"]["6"]
    assert list(steps) == ["none", *STEPS]
    assert steps["neutral"]["pack"] < 0.75 * steps["none"]["pack"]
    assert steps["neutral"]["neutral"] < 0.75 * steps["none"]["neutral"]
