"""``facezip check`` as its users call it."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from facezip.character.loading import load_character, save_character
from facezip.errors import ExitCode
from scenes.character import make_character
from scenes.face.capture import MAPS
from scenes.tiles import in_tiles
from tests.facezip.character.test_alignment import LEFT, MOVED, moved, off
from tests.facezip.conftest import with_albedo
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


@pytest.fixture(scope="module")
def tiled(folder):
    """A character with three maps on two tiles, one expression of which is off in all of them."""
    true = make_character(256, 4, nuisances=0, maps=MAPS[:2])
    save_character(in_tiles(moved(true, 3)[0], 2, 1), folder / "tiled")
    return folder / "tiled", in_tiles(true, 2, 1)


def test_every_map_on_every_tile_is_put_right(tiled, tmp_path):
    scans, true = tiled
    done = run("check", scans, "--register", tmp_path / "right", "-o", tmp_path / "out", "--json")
    assert done.returncode == ExitCode.DONE, done.stderr
    document = json.loads(done.stdout)
    assert document["misregistered"] == [MOVED]
    found = document["expressions"][MOVED]
    assert set(found["tiles"]) == {"1001", "1002"}
    assert found["rms"] == max(tile["rms"] for tile in found["tiles"].values())
    assert found["rms"] == found["tiles"][str(found["tile"])]["rms"]
    assert document["register"]["rms"][MOVED] < 2 * LEFT
    bad, right = load_character(scans), load_character(tmp_path / "right")
    assert right.maps == bad.maps
    for key in true.stacks:
        assert off(right, true, key) < 0.5 * off(bad, true, key)


def test_people_are_told_the_tile(tiled):
    done = run("check", tiled[0])
    assert done.returncode == ExitCode.DIFFERENCE
    heading, worst, *_ = done.stdout.splitlines()
    assert heading.endswith("on tile")
    assert re.fullmatch(rf"  {MOVED} .* on 100[12]  <-- misregistered", worst)


def test_compress_warns_of_several_maps_and_tiles_too(tiled, tmp_path):
    done = run("compress", tiled[0], "-o", tmp_path / "bad.facezip", "--method", "pca", "--json")
    assert done.returncode == ExitCode.DONE, done.stderr
    assert list(json.loads(done.stdout)["misregistered"]) == [MOVED]
    assert MOVED in done.stderr


def test_what_is_turned_is_listed_before_what_is_registered(folder, tmp_path):
    good = load_character(folder / "good")
    textures = good.first.textures.copy()
    textures[-1] = textures[-1][::-1]
    save_character(with_albedo(good, textures=textures), tmp_path / "turned")
    _, worst, *_ = run("check", tmp_path / "turned").stdout.splitlines()
    assert re.fullmatch(rf"  {good.expressions[-1]} .*  <-- misregistered: upside down", worst)


def test_what_is_there_is_not_replaced(folder, tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").touch()
    for option in ("-o", "--register"):
        done = run("check", folder / "good", option, tmp_path / "mine")
        assert done.returncode == ExitCode.CANNOT_WRITE
        assert len(done.stderr.splitlines()) == 1
    assert [path.name for path in (tmp_path / "mine").iterdir()] == ["thesis.tex"]


@pytest.mark.parametrize("overwrite", [(), ("--overwrite",)])
def test_scans_are_refused_as_a_target_before_anything_is_read(folder, tmp_path, overwrite):
    """Nothing tells scans that facezip wrote from those of a capture: none are replaced, and no remedy says so."""
    before = sorted(path.name for path in (folder / "bad").iterdir())
    done = run("check", tmp_path / "no scans at all", "--register", folder / "bad", *overwrite)
    assert done.returncode == ExitCode.CANNOT_WRITE
    assert done.stderr.endswith(f"{folder / 'bad'}: exists already; choose another name\n")
    assert sorted(path.name for path in (folder / "bad").iterdir()) == before
