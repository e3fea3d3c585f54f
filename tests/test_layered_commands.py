"""The verbs on a character with several maps and tiles."""

import json
import shutil
import sys
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import replace
from io import StringIO
from types import SimpleNamespace

import numpy as np
import OpenImageIO as oiio
import pytest

from facezip.character.loading import load_character, save_character
from facezip.character.maps import angles
from facezip.character.neutrals import packed_neutral
from facezip.cli import main
from facezip.errors import ExitCode
from facezip.files.images import read_texture_exactly, write_texture
from facezip.pack.read import read_pack
from tests.documents.checked import checked
from tests.facezip.conftest import random_character
from tests.facezip.surfaces import random_surface


def run(*arguments):
    """The command in this process, which has loaded everything: what it prints, and how it ends."""
    out, err, code = StringIO(), StringIO(), 0
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(out), redirect_stderr(err):
        patch.setattr(sys, "argv", ["facezip", *map(str, arguments)])
        try:
            main()
        except SystemExit as end:
            code = end.code
    return SimpleNamespace(returncode=code, stdout=checked(arguments, out.getvalue()), stderr=err.getvalue())


@pytest.fixture(scope="module")
def scans(tmp_path_factory):
    folder = tmp_path_factory.mktemp("layered") / "sheet"
    save_character(random_surface(expressions=6, tiles=(2, 1)), folder)
    return folder


@pytest.fixture(scope="module")
def pack(scans):
    path = scans.parent / "sheet.facezip"
    done = run("compress", scans, "-o", path, "--differences", 2, "--map-weight", "normal=2", "--json")
    assert done.returncode == 0, done.stderr
    return path, json.loads(done.stdout)


def test_compress_states_the_error_of_each_map_as_it_was_written(scans, pack):
    path, document = pack
    assert [kind["name"] for kind in document["maps"]] == ["albedo", "normal", "roughness"]
    stated = {"method": "refined", "differences": 2, "weight_scale": 8, "map_weights": {"normal": 2}}
    assert document["made_with"] == stated
    assert document["rmse"] == document["errors"]["albedo"]["rmse"]
    surface, model = load_character(scans), read_pack(path)
    kind, seen = surface.maps[1], []
    for name in surface.expressions:
        keys = [("normal", tile) for tile in surface.tiles]
        both = [(surface.texels(name, key), model.texels({name: 1}, key)) for key in keys]
        seen.append(np.mean([angles(*map(kind.decode, pair)) for pair in both]))
    assert document["errors"]["normal"]["angular_error"] == pytest.approx(np.mean(seen), rel=1e-4)


def test_info_and_verify_take_it(pack):
    facts = json.loads(run("info", pack[0], "--json").stdout)
    # Two tiles of 64 x 32: three textures of six channels, and weight maps of 6 expressions once.
    assert facts["bytes_on_gpu"] == 2 * (3 * 6 * 64 * 32 + 6 * 4 * 8 * 4)
    assert facts["bytes_bc7"] == 2 * (3 * 3 * 64 * 32 + 6 * 4 * 8 * 4)
    assert facts["bytes_raw_bc7"] == 2 * 7 * 3 * 64 * 32
    assert facts["fetches"] == 3 * 3 + 1
    assert [tile["tile"] for tile in facts["tiles"]] == [1001, 1002]
    assert "1001, 1002" in run("info", pack[0]).stdout
    assert run("verify", pack[0]).returncode == 0


def test_decompress_writes_every_map_and_tile(pack, tmp_path):
    done = run("decompress", pack[0], "-o", tmp_path / "mix", "--blend", "expr_0=0.5,expr_3=1", "--json")
    model, written = read_pack(pack[0]), json.loads(done.stdout)["textures"]
    assert sorted(written) == sorted(file.name for file in (tmp_path / "mix").iterdir())
    assert len(written) == 6
    for kind in model.maps:
        fitted = model.texels({"expr_0": 0.5, "expr_3": 1}, (kind.name, 1002))
        middle = "" if kind.name == "albedo" else f".{kind.name}"
        texture = read_texture_exactly(tmp_path / "mix" / f"blend{middle}.1002.png")
        np.testing.assert_array_equal(texture, packed_neutral(fitted, kind, 8))
    normals = read_texture_exactly(tmp_path / "mix" / "blend.normal.1001.png") / 127.5 - 1
    np.testing.assert_allclose(np.linalg.norm(normals, axis=2), 1, atol=0.01)


def test_what_is_decompressed_is_a_character_again(pack, scans, tmp_path):
    assert run("decompress", pack[0], "-o", tmp_path / "back").returncode == 0
    for name in ("neutral", *read_pack(pack[0]).expressions):
        shutil.copy(scans / f"{name}.obj", tmp_path / "back")
    for file in scans.glob("neutral.*.png"):
        shutil.copy(file, tmp_path / "back")
    assert load_character(tmp_path / "back").tiles == (1001, 1002)


def test_validate_renders_and_measures_all_maps(pack, scans, tmp_path):
    small = ("--resolution", 48, "--spp", 4, "--views", 1, "--lights", 1, "--json")
    done = run("validate", scans, pack[0], scans, "-o", tmp_path / "report", *small)
    assert done.returncode == 0, done.stderr
    compressed, same = json.loads(done.stdout)["packs"]
    assert compressed["map_errors"] == pack[1]["errors"]
    assert compressed["image_rmse"] > 0
    assert same["image_rmse"] == 0
    assert same["map_errors"]["normal"]["angular_error"] == 0
    page = (tmp_path / "report" / "index.html").read_text()
    assert "mean angle in degrees" in page
    assert "3 maps on 2 tiles" in page


@pytest.mark.parametrize(("fail_on", "code"), [(None, ExitCode.DONE), ("fails", ExitCode.DIFFERENCE)])
def test_a_gate_ends_with_a_difference(scans, tmp_path, fail_on, code):
    other = tmp_path / "other"
    shutil.copytree(scans, other)
    for image in other.glob("*.1001.png"):
        if "normal" not in image.stem and "roughness" not in image.stem and not image.stem.startswith("mask"):
            write_texture(image, 255 - read_texture_exactly(image))
    look = ("--views", 1, "--lights", 1, "--resolution", 48, "--spp", 4)
    gate = ("--fail-on", fail_on) if fail_on else ()
    done = run("validate", scans, other, "-o", tmp_path / "report", *look, *gate, "--json")
    assert done.returncode == code, done.stderr
    assert json.loads(done.stdout)["packs"][0]["level"] == "fails"


def test_a_normal_map_changes_the_image(scans, pack, tmp_path):
    """Packs whose normals or whose roughness alone are wrong are seen to be wrong."""
    surface = load_character(scans)
    small = ("--resolution", 48, "--spp", 4, "--views", 1, "--lights", 1, "--json")
    for name in ("normal", "roughness"):
        stacks = dict(surface.stacks)
        for tile, stack in surface.of_map(name).items():
            stacks[name, tile] = replace(stack, textures=np.roll(stack.textures, 9, axis=1))
        save_character(replace(surface, stacks=stacks), tmp_path / name)
    done = run("validate", scans, tmp_path / "normal", tmp_path / "roughness", "-o", tmp_path / "report", *small)
    for other in json.loads(done.stdout)["packs"]:
        assert other["texture_rmse"] == 0
        assert other["image_rmse"] > 0.5


def test_floats_beyond_the_range_come_back(tmp_path):
    folder = tmp_path / "scans"
    save_character(random_character(expressions=3, side=32), folder)
    y, x = np.mgrid[:32, :32].astype(np.float32) / 32
    for n, name in enumerate(("neutral", "expr_0", "expr_1", "expr_2")):
        image = oiio.ImageBuf(oiio.ImageSpec(32, 32, 1, "float"))
        image.set_pixels(oiio.ROI(), (5 * np.sin(3 * x + n) + y - 2)[..., None])
        image.write(str(folder / f"{name}.cavity.exr"))
    refused = run("compress", folder, "-o", tmp_path / "a.facezip")
    assert refused.returncode == ExitCode.BAD_INPUT
    assert "--float" in refused.stderr
    assert run("compress", folder, "-o", tmp_path / "a.facezip", "--float").returncode == 0
    assert run("decompress", tmp_path / "a.facezip", "-o", tmp_path / "out").returncode == 0
    back = oiio.ImageBuf(str(tmp_path / "out" / "expr_1.cavity.exr")).get_pixels()[..., 0]
    np.testing.assert_allclose(back, 5 * np.sin(3 * x + 2) + y - 2, atol=0.1)


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (("compress", "SCANS", "-o", "OUT", "--map-weight", "gloss=1"), ExitCode.BAD_INPUT, "gloss"),
        (("compress", "SCANS", "-o", "OUT", "--map-weight", "normal"), ExitCode.BAD_INPUT, "MAP=0.5"),
    ],
)
def test_a_weight_of_no_map_is_refused(scans, tmp_path, arguments, code, message):
    places = {"SCANS": scans, "OUT": tmp_path / "out"}
    done = run(*(places.get(word, word) for word in arguments))
    assert done.returncode == code
    assert message in done.stderr
    assert not (tmp_path / "out").exists()


def test_bench_maps_shows_what_sharing_saves_and_costs():
    document = json.loads(run("bench", "maps", "--resolution", 64, "--expressions", 6, "--json").stdout)
    shared, separate = document["ways"][:2]
    assert separate["bytes_on_gpu"] - shared["bytes_on_gpu"] == 2 * 6 * 4 * 8 * 8
    assert (shared["fetches"], separate["fetches"]) == (16, 18)
    assert (shared["fetches_packed"], separate["fetches_packed"]) == (11, 13)
    for name, key in (("albedo", "rmse"), ("normal", "angular_error"), ("roughness", "rmse")):
        assert 0 < separate["errors"][name][key] <= shared["errors"][name][key] * 1.001
