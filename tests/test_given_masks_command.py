"""``facezip compress --method masks`` and ``--given-masks DIR``: expressions as a few numbers under fixed masks."""

import json

import numpy as np
import pytest

from facezip.character.loading import save_character
from facezip.errors import ExitCode
from facezip.files.images import write_texture
from facezip.pack.read import read_pack
from tests.facezip.conftest import random_character
from tests.facezip.surfaces import random_surface
from tests.test_layered_commands import run


def spot(side, x, y):
    v, u = (np.mgrid[:side, :side] + 0.5) / side
    mask = np.exp(-6 * ((u - x) ** 2 + (v - y) ** 2))
    return np.rint(mask * 255).astype(np.uint8)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("given")
    save_character(random_character(side=64, expressions=6), folder / "sheet")
    save_character(random_surface(expressions=5, tiles=(2, 1)), folder / "surface")
    (folder / "masks").mkdir()
    write_texture(folder / "masks" / "cheek.png", spot(30, 0.2, 0.7)[..., None])
    regions = np.stack([spot(128, x, 0.3) for x in (0.2, 0.5, 0.8)], axis=2)
    write_texture(folder / "masks" / "regions.png", regions)
    (folder / "masks" / "masks.toml").write_text(
        'activations = "0..1"\n[channels]\nregions = ["brow_l", "brow", "brow_r"]\n[layers]\ncheek = [1]\n'
    )
    return folder


def compressed(folder, name, *options, character="sheet"):
    path = folder / f"{name}.facezip"
    done = run("compress", folder / character, "-o", path, "--overwrite", "--differences", 2, "--json", *options)
    assert done.returncode == 0, done.stderr
    return path, json.loads(done.stdout)


def test_given_masks_come_back_by_name_and_their_settings_hold(folder):
    path, document = compressed(folder, "given", "--given-masks", folder / "masks")
    assert document["method"] == "masks"
    assert document["masks"] == {"names": ["cheek", "brow_l", "brow", "brow_r"], "activations": "0..1"}
    assert document["made_with"] == {"method": "masks", "differences": 2, "weight_scale": 8, "given_masks": "masks"}
    masked = read_pack(path).masked
    assert masked.clamped
    assert (masked.activations[:, 0, 0] == 0).all()
    assert (masked.activations[:, 0, 1] > 0).any()
    assert json.loads(run("info", path, "--json").stdout)["masks"] == document["masks"]
    assert "4, activations 0..1: cheek, brow_l, brow, brow_r" in run("info", path).stdout
    assert run("verify", path).returncode == 0


def test_the_papers_masks_are_those_without_a_folder(folder):
    _, document = compressed(folder, "papers", "--method", "masks", "--masks", 12)
    assert len(document["masks"]["names"]) == 12
    assert document["masks"]["activations"] == "free"
    _, clamped = compressed(folder, "clamped", "--method", "masks", "--masks", 12, "--nonnegative")
    assert clamped["masks"]["activations"] == "0..1"
    assert document["rmse"] < clamped["rmse"]
    assert clamped["made_with"]["nonnegative"] is True


def test_the_error_is_that_of_what_was_written(folder):
    path, document = compressed(folder, "given", "--given-masks", folder / "masks")
    scans, model = random_character(side=64, expressions=6), read_pack(path)
    gaps = [model.reconstruct(name) - scans.texture(name) for name in scans.expressions]
    expected = np.mean([255 * np.sqrt(np.mean(np.square(gap))) for gap in gaps])
    assert document["rmse"] == pytest.approx(expected, rel=1e-4)


def test_maps_and_tiles_share_the_activations(folder):
    path, document = compressed(folder, "tiles", "--method", "masks", "--masks", 9, character="surface")
    assert read_pack(path).masked.activations.shape == (5, 9, 2)
    assert {*document["errors"]} == {"albedo", "normal", "roughness"}


def test_what_takes_a_pack_takes_it(folder):
    path, _ = compressed(folder, "given", "--given-masks", folder / "masks")
    pair = ("--blend", "expr_0=0.5,expr_1=0.5", "-o", folder / "blend")
    calls = [("decompress", path, *pair), ("export", path, "--to", "godot", "-o", folder / "godot")]
    calls += [("export", path, "--to", "web", "-o", folder / "web"), ("compress", folder / "sheet", "-o", path)]
    codes = [run(*call).returncode for call in calls]
    assert codes == [0, 0, 0, ExitCode.CANNOT_WRITE]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--nonnegative", "--method", "pca"), "--method refined or masks"),
        (("--nonnegative", "--target-rmse", 2), "leave --nonnegative out"),
        (("--given-masks", "DIR", "--method", "paper"), "--method masks, not paper"),
        (("--given-masks", "DIR", "--masks", 9), "leave them out"),
        (("--given-masks", "DIR", "--target-rmse", 2), "need --method refined"),
        (("--method", "paper", "--memory", "2G"), "--memory needs --method refined or pca or masks"),
    ],
    ids=str,
)
def test_options_that_do_not_go_together_are_refused(folder, options, words):
    options = [folder / "masks" if option == "DIR" else option for option in options]
    done = run("compress", folder / "sheet", "-o", folder / "x", *options)
    assert done.returncode == ExitCode.USAGE
    assert words in done.stderr


def test_masks_are_found_wrong_before_scans_are_read(folder):
    done = run("compress", folder / "sheet", "-o", folder / "x", "--given-masks", folder / "nowhere")
    assert done.returncode == ExitCode.BAD_INPUT
    assert "nowhere: no such folder" in done.stderr


def test_a_batch_makes_anew_what_other_masks_change(folder):
    call = ("batch", folder / "sheet", "-o", folder / "batch", "--workers", 1, "--given-masks", folder / "masks")
    assert "1 made, 0 kept" in run(*call).stdout
    assert "0 made, 1 kept" in run(*call).stdout
    write_texture(folder / "masks" / "cheek.png", spot(30, 0.8, 0.7)[..., None])
    assert "1 made, 0 kept" in run(*call).stdout
