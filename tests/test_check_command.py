"""``facezip check`` as its users call it."""

import json
import shutil
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from facezip.character.loading import load_character, save_character
from facezip.errors import ExitCode
from facezip.files.images import read_texture, write_texture
from scenes.character import make_character
from tests.facezip.character.test_alignment import MOVED, moved
from tests.test_cli import run


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("check")
    good = make_character(256, 6, nuisances=0)
    save_character(replace(good, name="good"), folder / "good")
    save_character(moved(good, 3)[0], folder / "bad")
    return folder


def test_a_registered_character_passes(folder):
    done = run("check", folder / "good", "--json")
    assert done.returncode == ExitCode.DONE, done.stderr
    document = json.loads(done.stdout)
    assert document["misregistered"] == []
    assert all(one["rms"] < 0.25 for one in document["expressions"].values())
    assert done.stderr == ""


def test_a_misregistered_one_is_named_shown_and_put_right(folder, tmp_path):
    done = run("check", folder / "bad", "-o", tmp_path / "out", "--json")
    assert done.returncode == ExitCode.DIFFERENCE, done.stderr
    document = json.loads(done.stdout)
    assert document["misregistered"] == [MOVED]
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["alignment.json", "alignment.png"]
    picture = np.asarray(Image.open(document["picture"]).convert("RGB"))
    assert min(picture.shape[:2]) > 300
    assert picture.std() > 10
    done = run("check", folder / "bad", "--register", tmp_path / "right")
    assert done.returncode == ExitCode.DONE, done.stderr
    assert f"{MOVED} " in done.stdout
    assert load_character(tmp_path / "right").expressions == load_character(folder / "bad").expressions
    assert run("check", tmp_path / "right").returncode == ExitCode.DONE


def test_compress_warns_in_one_line_and_goes_on(folder, tmp_path):
    done = run("compress", folder / "bad", "-o", tmp_path / "bad.facezip", "--method", "pca", "--json")
    assert done.returncode == ExitCode.DONE
    assert list(json.loads(done.stdout)["misregistered"]) == [MOVED]
    assert len(done.stderr.splitlines()) == 1
    assert MOVED in done.stderr
    done = run("compress", folder / "good", "-o", tmp_path / "good.facezip", "--method", "pca")
    assert done.stderr == ""


def test_compress_warns_of_several_maps_too(folder, tmp_path):
    shutil.copytree(folder / "bad", tmp_path / "bad")
    for image in [path for path in (tmp_path / "bad").glob("*.png") if path.stem != "mask"]:
        write_texture(image.with_suffix(".roughness.png"), read_texture(image)[:, :, :1].copy())
    done = run("compress", tmp_path / "bad", "-o", tmp_path / "bad.facezip", "--method", "pca", "--json")
    assert done.returncode == ExitCode.DONE, done.stderr
    assert list(json.loads(done.stdout)["misregistered"]) == [MOVED]
    assert MOVED in done.stderr


def test_what_is_there_is_not_replaced(folder, tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").touch()
    for option in ("-o", "--register"):
        done = run("check", folder / "good", option, tmp_path / "mine")
        assert done.returncode == ExitCode.CANNOT_WRITE
        assert len(done.stderr.splitlines()) == 1
    assert [path.name for path in (tmp_path / "mine").iterdir()] == ["thesis.tex"]
