"""``facezip importance`` as its users call it."""

import json

import numpy as np
import pytest

from facezip.character.loading import load_character, save_character
from facezip.errors import ExitCode
from facezip.files.images import write_texture, write_values
from facezip.files.values import read_values
from facezip.fit.importance import importance_files, map_factors
from scenes.character import make_character
from scenes.face.capture import MAPS
from tests.test_cli import run

QUICK = ("--views", 2, "--lights", 1, "--resolution", 32, "--spp", 2)


@pytest.fixture(scope="module")
def scans(tmp_path_factory):
    folder = tmp_path_factory.mktemp("scans") / "person"
    save_character(make_character(64, 2, nuisances=0), folder)
    return folder


@pytest.fixture(scope="module")
def report(scans):
    folder = scans.parent / "importance"
    done = run("importance", scans, "-o", folder, *QUICK, "--floor", 0.25, "--json")
    assert done.returncode == 0, done.stderr
    return folder, json.loads(done.stdout)


def test_it_leaves_the_importance_its_numbers_and_a_page(report):
    folder, document = report
    assert {path.name for path in folder.iterdir()} == {"importance.exr", "importance.json", "index.html"}
    stored = json.loads((folder / "importance.json").read_text(encoding="utf-8"))
    assert stored["looks"] == document["looks"]
    assert [look["held_out"] for look in stored["looks"]] == [False, False, True, True, True]
    uniform, weighted = stored["fits"]
    assert uniform["bytes_on_gpu"] == weighted["bytes_on_gpu"]
    assert ".tmp" not in json.dumps(document)
    page = (folder / "index.html").read_text(encoding="utf-8")
    assert "http" not in page.replace("http-equiv", "")
    assert page.count("data:image/webp") == 5


def test_the_importance_counts_the_face_alone_and_unseen_texels_by_the_floor(scans, report):
    mask = load_character(scans).first.mask
    importance = read_values(report[0] / "importance.exr")
    assert (importance > 0).all()
    assert importance[mask > 0].min() == np.float32(0.25)
    assert importance[mask > 0].mean() == pytest.approx(1, rel=1e-4)


def test_compress_takes_what_it_wrote(scans, report, tmp_path):
    done = run("compress", scans, "-o", tmp_path / "a.facezip", "--importance", report[0] / "importance.exr", "--json")
    assert done.returncode == 0, done.stderr
    document = json.loads(done.stdout)
    assert document["made_with"]["importance"] == "importance.exr"
    assert document["rmse"] == pytest.approx(report[1]["fits"][1]["texture_rmse"], rel=1e-4)


@pytest.fixture(scope="module")
def tiled(tmp_path_factory):
    """A character with albedo, normals and roughness on two tiles, and the answer for it."""
    folder = tmp_path_factory.mktemp("tiled")
    save_character(make_character(64, 5, tiles=(2, 1), maps=MAPS[:2]), folder / "person")
    call = ("importance", folder / "person", "-o", folder / "importance", *QUICK, "--floor", 0.25)
    done = run(*call, "--differences", 2, "--json")
    assert done.returncode == 0, done.stderr
    return folder, json.loads(done.stdout)


def test_every_map_and_tile_has_its_image(tiled):
    folder, document = tiled
    scans = load_character(folder / "person")
    names = importance_files(scans)
    written = {path.name for path in (folder / "importance").iterdir()}
    assert written == {*names.values(), "importance.json", "index.html"}
    assert document["importance_file"] == str(folder / "importance")
    weights = {key: read_values(folder / "importance" / name) for key, name in names.items()}
    face = np.concatenate([weights["albedo", tile][s.mask > 0] for tile, s in scans.of_map("albedo").items()])
    assert face.mean() == pytest.approx(1, rel=1e-4)
    assert face.min() == np.float32(0.25)


def test_how_the_importance_of_each_map_was_found_is_said(tiled):
    folder, document = tiled
    words = document["conditions"]["importance_of"]
    assert words.startswith("the albedo, exact")
    assert "normal, roughness: by finite differences" in words
    assert document["conditions"]["maps_rendered"] == ["albedo", "normal", "roughness"]
    assert set(document["importance"]["counts"]) == {"albedo", "normal", "roughness"}
    page = (folder / "importance" / "index.html").read_text(encoding="utf-8")
    assert words in page
    assert "Normal, mean angle in degrees" in page
    assert "3 maps on 2 tiles" in page
    # Two views of the head and its importance, and six images in UV.
    assert page.count("data:image/webp") == 10


def test_how_much_maps_count_is_as_their_differences_show(tiled):
    """The images are in the unit of the albedo's mean: so are the numbers that are said."""
    folder, document = tiled
    scans = load_character(folder / "person")
    alike = map_factors(scans, {})
    for name, count in document["importance"]["counts"].items():
        files = [file for (kind, _), file in importance_files(scans).items() if kind == name]
        masks = [stack.mask for stack in scans.of_map(name).values()]
        images = [read_values(folder / "importance" / file) for file in files]
        mean = sum(np.vdot(*pair) for pair in zip(images, masks, strict=True)) / sum(mask.sum() for mask in masks)
        assert count * alike[name] == pytest.approx(mean, rel=1e-3)


def test_compress_takes_the_folder(tiled, tmp_path):
    folder, document = tiled
    scans, given = folder / "person", document["importance_file"]
    call = ("compress", scans, "-o", tmp_path / "a.facezip", "--importance", given, "--differences", 2)
    done = run(*call, "--json")
    assert done.returncode == 0, done.stderr
    errors = json.loads(done.stdout)["errors"]
    for name, key in (("albedo", "rmse"), ("normal", "angular_error"), ("roughness", "rmse")):
        assert errors[name][key] == pytest.approx(document["fits"][1]["map_errors"][name][key], rel=2e-2)


def test_values_come_back_as_they_were_written(tmp_path):
    values = np.random.default_rng(0).gamma(1, 3, (8, 12)).astype(np.float32)
    write_values(tmp_path / "values.exr", values)
    np.testing.assert_array_equal(read_values(tmp_path / "values.exr"), values)
    write_texture(tmp_path / "values.png", np.array([[[0], [51], [255]]], np.uint8))
    np.testing.assert_allclose(read_values(tmp_path / "values.png"), [[0, 0.2, 1]], rtol=1e-6)


def test_wrong_calls_are_one_line_and_write_nothing(scans, report, tmp_path):
    write_values(tmp_path / "negative.exr", np.full((64, 64), -1, np.float32))
    for arguments, code in {
        ("importance", scans, "-o", report[0], *QUICK): ExitCode.CANNOT_WRITE,
        ("importance", scans, "-o", tmp_path / "x", *QUICK, "--weight-scale", 7): ExitCode.BAD_INPUT,
        ("importance", scans, "-o", tmp_path / "x", "--views", 99): ExitCode.USAGE,
        ("compress", scans, "-o", tmp_path / "x", "--importance", tmp_path / "negative.exr"): ExitCode.BAD_INPUT,
        ("compress", scans, "-o", tmp_path / "x", "--importance", tmp_path / "nothing.exr"): ExitCode.BAD_INPUT,
    }.items():
        done = run(*arguments)
        assert done.returncode == code, done.stderr
        assert "Traceback" not in done.stderr
        if code is not ExitCode.USAGE:
            assert len(done.stderr.splitlines()) == 1
        assert not (tmp_path / "x").exists()
