"""``facezip validate`` killed in the middle and started again."""

import json
import os
import signal
import subprocess
import sys
import time

import pytest

from facezip import FaceZipError
from facezip.character.loading import save_character
from facezip.files.writing import resumable_folder
from tests.facezip.conftest import random_character
from tests.test_cli import run

SMALL = ("--resolution", 32, "--spp", 4, "--views", 2, "--lights", 1, "--json")


@pytest.fixture(scope="module")
def scans(tmp_path_factory):
    folder = tmp_path_factory.mktemp("scans")
    save_character(random_character(side=32, expressions=4, seed=0), folder / "a")
    save_character(random_character(side=32, expressions=4, seed=1), folder / "b")
    return folder


def numbers(document):
    return {key: value for key, value in document.items() if key not in ("seconds", "pairs_per_second", "rendered")}


def killed_once_some_are_done(arguments, partial):
    command = [sys.executable, "-c", "from facezip.cli import main; main()", *map(str, arguments)]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
    end = time.monotonic() + 200
    while len(list(partial.glob("renders/*.json"))) < 3:
        if process.poll() is not None or time.monotonic() > end:
            raise AssertionError("it ended before it could be killed")
        time.sleep(0.002)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()


def test_a_killed_run_goes_on_and_ends_in_the_same_numbers(scans, tmp_path):
    whole = run("validate", scans / "a", scans / "b", "-o", tmp_path / "whole", *SMALL)
    assert whole.returncode == 0, whole.stderr
    arguments = ("validate", scans / "a", scans / "b", "-o", tmp_path / "report", *SMALL)
    killed_once_some_are_done(arguments, tmp_path / ".report.partial")
    assert not (tmp_path / "report").exists()
    done = run(*arguments)
    assert done.returncode == 0, done.stderr
    first, second = json.loads(whole.stdout), json.loads(done.stdout)
    assert second["rendered"] < first["rendered"] == 10
    assert numbers(second) == numbers(first)
    assert not list(tmp_path.glob(".*"))


def breaks_off(path, files):
    with resumable_folder(path, False, lambda _: True) as folder:
        for name, text in files.items():
            (folder / name).write_text(text)
        raise RuntimeError


def test_what_a_broken_run_leaves_is_there_for_the_next(tmp_path):
    with pytest.raises(RuntimeError):
        breaks_off(tmp_path / "out", {"half": "done"})
    assert not (tmp_path / "out").exists()
    with resumable_folder(tmp_path / "out", False, lambda _: True) as folder:
        assert (folder / "half").read_text() == "done"
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def test_a_run_that_did_nothing_leaves_nothing(tmp_path):
    with pytest.raises(RuntimeError):
        breaks_off(tmp_path / "out", {})
    assert not any(tmp_path.iterdir())


def test_two_runs_do_not_share_a_folder(tmp_path):
    with resumable_folder(tmp_path / "out", False, lambda _: True) as folder:
        (folder / "first").write_text("mine")
        with pytest.raises(FaceZipError, match="another facezip"):
            breaks_off(tmp_path / "out", {})
    assert (tmp_path / "out" / "first").exists()
