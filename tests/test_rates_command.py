"""``facezip rates`` as its users call it."""

import json

from facezip.character.loading import save_character
from facezip.errors import ExitCode
from tests.facezip.conftest import random_character
from tests.facezip.surfaces import random_surface
from tests.test_cli import run


def test_the_report_is_a_page_with_its_numbers_beside_it_and_is_kept(tmp_path):
    save_character(random_surface(side=32, expressions=2, tiles=(2, 1)), tmp_path / "sheet")
    call = ("rates", tmp_path / "sheet", "-o", tmp_path / "rates", "--blends-to", 0, "--effort", "fast", "--json")
    done = run(*call)
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout)
    stored = json.loads((tmp_path / "rates" / "rates.json").read_text(encoding="utf-8"))
    assert answer["rounds"] == stored["rounds"]
    assert len(stored["rounds"][0]["points"]) > 10
    assert all(set(point["errors"]) == {"albedo", "normal", "roughness"} for point in stored["rounds"][0]["points"])
    assert answer["character"]["tiles"] == [1001, 1002]
    assert ".tmp" not in json.dumps(answer)
    assert (tmp_path / "rates" / "index.html").is_file()
    assert run(*call).returncode == ExitCode.CANNOT_WRITE


def test_sizes_of_the_embedded_character_are_refused_beside_scans(tmp_path):
    for verb in ("rates", "paper"):
        done = run(verb, tmp_path / "sheet", "-o", tmp_path / "out", "--expressions", 3)
        assert done.returncode == ExitCode.USAGE
        assert "--expressions" in done.stderr
        assert "of the embedded character" in done.stderr
    assert not any(tmp_path.iterdir())


def test_a_round_that_adds_nothing_is_refused_before_any_work(tmp_path):
    save_character(random_character(side=32, expressions=4), tmp_path / "sheet")
    done = run("rates", tmp_path / "sheet", "-o", tmp_path / "rates", "--blends-to", 3)
    assert done.returncode == ExitCode.BAD_INPUT
    assert done.stderr.startswith("facezip: ")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["sheet"]
