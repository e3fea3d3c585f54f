"""``facezip batch`` and ``validate --workers``: the bytes and the document of a serial run, whoever works."""

import importlib.util
import json
import shutil

import pytest

from facezip.character.loading import save_character
from facezip.errors import ExitCode
from facezip.files.images import read_texture, write_texture
from facezip.pack.verification import verify_pack
from tests.facezip.conftest import random_character
from tests.test_cli import run
from tests.test_resume import numbers

NAMES = ("c0", "c1", "c2")


@pytest.fixture(scope="module")
def scans(tmp_path_factory):
    folder = tmp_path_factory.mktemp("scans")
    for seed, name in enumerate(NAMES):
        save_character(random_character(seed=seed, side=64, expressions=3), folder / name)
    (folder / "bad").mkdir()
    (folder / "bad" / "neutral.obj").write_text("v 0 0 0\n")
    return folder


@pytest.fixture(scope="module")
def serial(scans, tmp_path_factory):
    folder = tmp_path_factory.mktemp("serial")
    for name in NAMES:
        assert run("compress", scans / name, "-o", folder / f"{name}.facezip", "--method", "pca").returncode == 0
    return folder


@pytest.fixture(scope="module")
def batch(scans, tmp_path_factory):
    output = tmp_path_factory.mktemp("batch") / "packs"
    return output, batched(output, scans, code=ExitCode.BAD_INPUT)


def batched(output, *arguments, code=ExitCode.DONE):
    done = run("batch", *arguments, "-o", output, "--method", "pca", "--workers", 2, "--json")
    assert done.returncode == code, done.stderr
    document = json.loads(done.stdout)
    return {entry["name"]: entry for entry in document["characters"]}, document, done.stderr


def content(pack):
    return {path.name: path.read_bytes() for path in pack.iterdir()}


def files(folder):
    """Everything in the folder of a batch but its summary."""
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file() and path.name != "batch.json"}


def test_packs_are_those_of_compress_byte_for_byte(batch, serial):
    for name in NAMES:
        pack = f"{name}.facezip"
        verify_pack(batch[0] / pack)
        assert content(batch[0] / pack) == content(serial / pack)


def test_a_limit_of_memory_changes_no_byte_and_is_no_setting(scans, serial, tmp_path):
    assert batched(tmp_path / "packs", scans / "c0", "--memory", "450M")[1]["made"] == 1
    assert content(tmp_path / "packs" / "c0.facezip") == content(serial / "c0.facezip")
    assert batched(tmp_path / "packs", scans / "c0")[1]["kept"] == 1


def test_a_limit_of_memory_holds_in_every_worker(scans, tmp_path):
    entries = batched(tmp_path / "packs", scans / "c0", "--memory", "1M", code=ExitCode.BAD_INPUT)[0]
    assert "at least" in entries["c0"]["error"]["message"]


def test_a_character_that_fails_stops_no_other_and_is_named(batch):
    entries, document, stderr = batch[1]
    assert entries["bad"]["status"] == "failed"
    assert {entries[name]["status"] for name in NAMES} == {"made"}
    assert document["failed"] == ["bad"]
    assert entries["bad"]["error"]["code"] == "too-few-expressions"
    errors = [line for line in stderr.splitlines() if not line.startswith("facezip: warning: ")]
    assert len(errors) == 1
    assert errors[0].startswith("facezip: bad: ")
    assert not (batch[0] / "bad.facezip").exists()


def test_a_second_run_makes_what_changed_and_keeps_the_rest(batch, scans, tmp_path):
    output, changed = tmp_path / "packs", tmp_path / "scans"
    shutil.copytree(scans, changed)
    sources = [changed / name for name in NAMES]
    batched(output, *sources)
    (output / "c1.facezip" / "albedo.1001.neutral.png").write_bytes(b"damaged")
    texture = read_texture(changed / "c2" / "expr_0.png")
    write_texture(changed / "c2" / "expr_0.png", 255 - texture)
    entries, document, _ = batched(output, *sources)
    assert [entries[name]["status"] for name in NAMES] == ["kept", "made", "made"]
    assert content(output / "c1.facezip") == content(batch[0] / "c1.facezip")
    assert content(output / "c2.facezip") != content(batch[0] / "c2.facezip")
    assert (document["made"], document["kept"], document["failed"]) == (2, 1, [])
    entries, _, _ = batched(output, *sources, "--differences", 2)
    assert {entry["status"] for entry in entries.values()} == {"made"}


def test_packs_of_others_are_left_alone_and_those_of_earlier_runs_stay_in_the_summary(batch, serial, scans, tmp_path):
    output = tmp_path / "packs"
    shutil.copytree(batch[0], output)
    shutil.rmtree(output / "c0.facezip")
    shutil.copytree(serial / "c1.facezip", output / "c0.facezip")
    (output / "c1.facezip.json").unlink()
    shutil.copytree(scans / "c0", tmp_path / "elsewhere" / "c2")
    sources, before = (scans / "c0", scans / "c1", tmp_path / "elsewhere" / "c2"), files(output)
    entries, _, stderr = batched(output, *sources, code=ExitCode.CANNOT_WRITE)
    assert {entry["error"]["code"] for entry in entries.values()} == {"cannot-write"}
    assert all(word in stderr for word in ("c0.facezip: was not made", "c1.facezip: was not made", "c2.facezip: is of"))
    assert files(output) == before
    entries, document, _ = batched(output, scans / "c1", "--overwrite")
    assert {name: entry["status"] for name, entry in entries.items()} == {"c1": "made", "c2": "earlier"}
    assert (document["made"], document["earlier"]) == (1, 1)
    assert entries["c2"]["rmse"] == batch[1][0]["c2"]["rmse"]
    assert json.loads((output / "batch.json").read_text()) == document


def test_a_list_gives_each_its_settings_and_the_command_line_goes_before(scans, tmp_path):
    first, second = (f"[[character]]\npath = '{scans / name}'\n" for name in NAMES[:2])
    (tmp_path / "jobs.toml").write_text(f"method = 'paper'\ndifferences = 2\n{first}{second}differences = 1\n")
    entries, _, _ = batched(tmp_path / "packs", tmp_path / "jobs.toml")
    assert [entries[name]["made_with"]["differences"] for name in NAMES[:2]] == [2, 1]
    assert {entry["method"] for entry in entries.values()} == {"pca"}


def test_wrong_calls_are_refused_before_any_work(scans, tmp_path):
    (tmp_path / "jobs.toml").write_text(f"[[character]]\npath = '{scans / 'c0'}'\nspeed = 3\n")
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").touch()
    both = ("--scheduler", "tcp://nobody:1", "--workers", 2)
    cases = {
        "no such setting": ((tmp_path / "jobs.toml", "-o", tmp_path / "x"), ExitCode.BAD_INPUT),
        "no such list": ((tmp_path / "no.toml", "-o", tmp_path / "x"), ExitCode.BAD_INPUT),
        "a folder of someone else": ((scans, "-o", tmp_path / "mine"), ExitCode.CANNOT_WRITE),
        "no folder to write in": ((scans, "-o", "/proc/nowhere/x"), ExitCode.CANNOT_WRITE),
        "two kinds of workers": ((scans, "-o", tmp_path / "x", *both), ExitCode.USAGE),
        "contradicting options": ((scans, "-o", tmp_path / "x", "--masks", 9), ExitCode.USAGE),
    }
    for case, (arguments, code) in cases.items():
        done = run("batch", *arguments)
        assert done.returncode == code, f"{case}: {done.stderr}"
        assert "Traceback" not in done.stderr, case
        assert not (tmp_path / "x").exists(), case
    assert [path.name for path in (tmp_path / "mine").iterdir()] == ["thesis.tex"]


def test_a_cluster_with_a_worker_killed_makes_the_packs_of_a_serial_run():
    if importlib.util.find_spec("distributed") is None:
        pytest.skip("dask is not installed: pip install 'facezip[cluster]'")
    done = run("bench", "batch", "--characters", 3, "--resolution", 64, "--expressions", 2, "--json")
    assert done.returncode == 0, done.stderr
    document = json.loads(done.stdout)
    assert document["identical"] == {"pool": 3, "dask": 3, "killed": 3}
    assert document["workers_killed"] == 1
    assert done.stderr == ""


def test_a_validation_by_workers_is_the_serial_one(scans, tmp_path):
    small = ("--resolution", 32, "--spp", 4, "--views", 2, "--lights", 1, "--json")
    documents = []
    for name, more in (("serial", ()), ("shared", ("--workers", 2))):
        done = run("validate", scans / "c0", scans / "c1", "-o", tmp_path / name, *small, *more)
        assert done.returncode == 0, done.stderr
        documents.append(json.loads(done.stdout))
        assert done.stderr == ""
    assert numbers(documents[1]) == numbers(documents[0])
    assert documents[1]["rendered"] == documents[0]["rendered"] == 8
    renders = [sorted(path.name for path in (tmp_path / name / "renders").iterdir()) for name in ("serial", "shared")]
    assert renders[0] == renders[1]
