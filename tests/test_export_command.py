"""``facezip export`` as its users call it, and the scripts that it leaves in their projects."""

import ast
import json
import re
import shutil
import sys
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import OpenImageIO as oiio
import pytest

from facezip import FaceZipError
from facezip.blocks.basis import find_package
from facezip.cli import main
from facezip.errors import ErrorCode, ExitCode
from facezip.export import TARGETS
from facezip.files.images import read_texture_exactly, write_texture
from facezip.pack.read import read_pack
from facezip.pack.write import write_pack
from facezip.viewer.build import BUNDLE
from tests.facezip.conftest import ALBEDO_KEY
from tests.facezip.export.conftest import layered_model, smooth_model
from tests.facezip.export.gains import regions_in

# Tests of their own have the page for browsers (tests/browser, tests/test_view_command.py) and exports of layers
# (tests/facezip/export/test_layers.py), which take few packs.
BUILT = pytest.mark.skipif(not (BUNDLE / "three").is_dir(), reason="the viewer is not built; run 'make viewer'")
OTHERS = ("web", "metahuman", "o3de")
ENGINES = {name: BUILT if name == "three" else () for name in TARGETS if name not in OTHERS}
NASTY = ("<img src=x onerror=alert(1)>", "$(touch owned)", '";DROP', "`id`", "sourire à 50 %")


@pytest.fixture
def run(monkeypatch, capsys):
    """Calls the command line in this process, where everything is imported already."""

    def call(*arguments):
        monkeypatch.setattr(sys, "argv", ["facezip", *map(str, arguments)])
        with pytest.raises(SystemExit) as ended:
            main()
        return int(ended.value.code), *capsys.readouterr()

    return call


@pytest.fixture(scope="module")
def pack(tmp_path_factory):
    """A pack whose expressions, and whose own name, are no names for files, shells or pages."""
    model = replace(smooth_model(side=32, weights=4), expressions=NASTY)
    path = tmp_path_factory.mktemp("packs") / "me.facezip"
    write_pack(model, path, name='../"><script>x</script>')
    return path


@pytest.fixture(scope="module")
def layered(tmp_path_factory):
    """The same with several maps, on two tiles."""
    model = replace(layered_model(smooth_model, tiles=(1001, 1002), side=32, weights=4), expressions=NASTY)
    path = tmp_path_factory.mktemp("packs") / "me.facezip"
    write_pack(model, path, name='../"><script>x</script>')
    return path


@pytest.fixture(scope="module", params=[pytest.param(name, marks=marks) for name, marks in ENGINES.items()])
def exported(request, pack):
    TARGETS[request.param](pack, pack.parent / request.param)
    return request.param, pack.parent / request.param


@pytest.fixture(
    scope="module",
    params=[
        pytest.param((target, which), marks=marks, id=f"{target}-{which}")
        for target, marks in ENGINES.items()
        for which in ("pack", "layered")
    ],
)
def either(request):
    """An export of one albedo, or of several maps on two tiles."""
    target, which = request.param
    source = request.getfixturevalue(which)
    folder = source.parent / f"{target}_{which}"
    TARGETS[target](source, folder)
    return target, folder


def test_the_document_is_what_lies_in_the_folder(pack, tmp_path, run):
    code, out, error = run("export", pack, "--to", "godot", "--textures", "dds", "-o", tmp_path / "out", "--json")
    assert (code, error) == (0, "")
    document, stored = json.loads(out), json.loads((tmp_path / "out" / "facezip.json").read_text())
    assert document.pop("output") == str(tmp_path / "out")
    assert document.pop("bytes") == sum(file.stat().st_size for file in (tmp_path / "out").rglob("*") if file.is_file())
    assert document == stored
    assert document["codec"]["rmse"] > 0
    assert run("export", pack, "--to", "godot", "-o", tmp_path / "out")[0] == ExitCode.CANNOT_WRITE
    assert run("export", pack, "--to", "unity", "-o", tmp_path / "out", "--overwrite")[0] == 0
    assert not (tmp_path / "out" / "facezip_head.gd").exists()


def test_several_tiles_are_in_one_document_and_in_those_of_their_folders(layered, tmp_path, run):
    out = tmp_path / "out"
    code, answer, error = run("export", layered, "--to", "unreal", "-o", out, "--json")
    assert (code, error) == (0, "")
    document, stored = json.loads(answer), json.loads((out / "facezip.json").read_text())
    assert document.pop("output") == str(out)
    assert document.pop("bytes") == sum(file.stat().st_size for file in out.rglob("*") if file.is_file())
    assert document == stored
    assert list(stored["tiles"]) == ["1001", "1002"]
    for tile, facts in stored["tiles"].items():
        assert json.loads((out / tile / "facezip.json").read_text()) == facts
        assert all((out / tile / entry["file"]).is_file() for entry in facts["textures"].values())
    shown = run("export", layered, "--to", "unreal", "-o", out, "--overwrite")[1]
    assert "normal: mip-maps" in shown
    assert "degrees" in shown


def test_names_are_shown_and_do_nothing(either, pack):
    _, folder = either
    files = [file for file in folder.rglob("*") if file.is_file()]
    known = set("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._")
    assert all({*file.name} <= known for file in files)
    assert sorted(entry.name for entry in pack.parent.iterdir() if entry.name in ("owned", "x")) == []
    document = json.loads((folder / "facezip.json").read_text())
    for tile in document.get("tiles", {"": document}).values():
        assert tile["order"] == list(NASTY)
    texts = [file for file in files if file.suffix not in (".json", ".png", ".glb", ".exr", ".usda")]
    assert texts
    for file in texts:
        content = file.read_text(encoding="utf-8")
        assert not any(name in content for name in (*NASTY, "<script>")), file.name


def test_reconstruction_by_the_document_alone_is_the_pack(exported, pack):
    """What an engine programmer does who reads nothing but ``facezip.json``."""
    _, folder = exported
    document, model = json.loads((folder / "facezip.json").read_text()), read_pack(pack)
    textures = document["textures"]
    texture = read_texture_exactly(folder / textures["neutral"]["file"]) / 255
    name = NASTY[2]
    column, row = document["expressions"][name]["weight_tile"]
    weights = textures["weights_0"]
    h, w = weights["size"]
    tile = read_texture_exactly(folder / weights["file"])[row * h : (row + 1) * h, column * w : (column + 1) * w] / 255
    tile = tile * weights["scale"] + weights["offset"]
    np.testing.assert_allclose(tile, model.weights[1001][2], atol=1e-5)
    part = model.parts[ALBEDO_KEY]
    for i in range(4):
        entry = textures[f"difference_{i}"]
        values = (read_texture_exactly(folder / entry["file"]) / 255 - entry["zero"]) * entry["scale"]
        np.testing.assert_allclose(values, part.differences[i], atol=1e-5)
    np.testing.assert_allclose(texture, part.neutral, atol=1e-6)


@pytest.mark.parametrize("target", [target for target in TARGETS if target != "web"])
def test_a_damaged_pack_is_refused_as_verify_refuses_it(pack, tmp_path, target):
    shutil.copytree(pack, tmp_path / "spoilt")
    content = bytearray((tmp_path / "spoilt" / "albedo.1001.difference_1.png").read_bytes())
    content[len(content) // 2] ^= 1
    (tmp_path / "spoilt" / "albedo.1001.difference_1.png").write_bytes(content)
    with pytest.raises(FaceZipError) as caught:
        read_pack(tmp_path / "spoilt")
    with pytest.raises(FaceZipError) as mine:
        TARGETS[target](tmp_path / "spoilt", tmp_path / "out")
    assert (str(mine.value), mine.value.code) == (str(caught.value), ErrorCode.DAMAGED_PACK)
    assert [entry.name for entry in tmp_path.iterdir()] == ["spoilt"]


def test_wrong_calls_are_one_line_and_write_nothing(pack, tmp_path, run):
    (tmp_path / "photos").mkdir()
    (tmp_path / "photos" / "me.jpg").write_bytes(b"precious")
    calls = {
        ("--to", "nowhere", "-o", tmp_path / "x"): ExitCode.USAGE,
        ("--to", "unreal", "--textures", "dds", "-o", tmp_path / "x"): ExitCode.BAD_INPUT,
        ("--to", "three", "--maps", "together", "-o", tmp_path / "x"): ExitCode.BAD_INPUT,
        ("--to", "unity", "--region", "chin=none.png", "-o", tmp_path / "x"): ExitCode.BAD_INPUT,
        ("--to", "unity", "--region", "chin", "-o", tmp_path / "x"): ExitCode.USAGE,
        ("--to", "unity", "--region", "a=b", "--region", "a=c", "-o", tmp_path / "x"): ExitCode.USAGE,
        ("--to", "unity", "-o", tmp_path / "photos", "--overwrite"): ExitCode.CANNOT_WRITE,
        ("--to", "unity", "-o", "/proc/nowhere/x"): ExitCode.CANNOT_WRITE,
    }
    for arguments, code in calls.items():
        ended, out, error = run("export", pack, *arguments)
        assert (ended, out) == (code, ""), error
        if code is not ExitCode.USAGE:
            assert len(error.splitlines()) == 1
    assert [entry.name for entry in tmp_path.iterdir()] == ["photos"]
    assert (tmp_path / "photos" / "me.jpg").read_bytes() == b"precious"


def test_a_missing_encoder_is_named_with_the_command_that_installs_it(pack, tmp_path, monkeypatch):
    monkeypatch.setenv("NODE_PATH", "")
    monkeypatch.chdir(tmp_path)
    assert find_package() is None
    with pytest.raises(FaceZipError, match="npm install ktx2-encoder"):
        TARGETS["gltf"](pack, tmp_path / "out", textures="ktx2")
    assert list(tmp_path.iterdir()) == []


def test_scripts_are_of_their_languages(either):
    target, folder = either
    if target in ("unreal", "blender"):
        script = {"unreal": "setup_facezip.py", "blender": "build_head.py"}[target]
        ast.parse((folder / script).read_text(encoding="utf-8"))
    elif target == "usd":
        for file in folder.rglob("*.mtlx"):
            assert ElementTree.parse(file).getroot().tag == "materialx"
    elif target == "godot":
        parser = pytest.importorskip("gdtoolkit.parser")
        parser.parser.parse((folder / "facezip_head.gd").read_text(encoding="utf-8"))
    elif target == "unity":
        sitter, grammar = pytest.importorskip("tree_sitter"), pytest.importorskip("tree_sitter_c_sharp")
        parser = sitter.Parser(sitter.Language(grammar.language()))
        scripts = sorted(folder.rglob("*.cs"))
        assert [file.name for file in scripts] == ["FaceZipBlocks.cs", "FaceZipImport.cs", "FaceZipHead.cs"]
        for file in scripts:
            assert not parser.parse(file.read_bytes()).root_node.has_error
            # Unity finds components and importers by the names of their files.
            assert re.findall(r"^public sealed class (\w+)", file.read_text(encoding="utf-8"), re.M) == [file.stem]


def test_guides_state_the_settings_that_break_a_blend(either):
    target, folder = either
    guide = (folder / "GUIDE.md").read_text(encoding="utf-8").lower()
    assert "| neutral, differences |" in guide
    assert "| weights" in guide
    assert all(f"gains.{kind}" in guide for kind in ("maps", "expressions", "regions"))
    assert all(word in guide for word in ("srgb", "mip-maps", "repeat" if target == "godot" else "clamp"))
    assert len(guide.splitlines()) < 60


OPTIONS_OF_OTHERS = {
    "--textures": "web png", "--maps": "web apart", "--memory": "web 1G", "--character": "unity scans",
    "--region": "web chin=a.png", "--animation": "blender frames.csv",
}  # fmt: skip


@pytest.mark.parametrize("option", OPTIONS_OF_OTHERS)
def test_an_option_of_another_target_is_refused(run, pack, tmp_path, option):
    target, value = OPTIONS_OF_OTHERS[option].split()
    code, _, err = run("export", pack, "--to", target, option, value, "-o", tmp_path / "x")
    assert code == ExitCode.USAGE
    assert option in err
    assert not (tmp_path / "x").exists()


def test_maps_apart_are_said_with_their_blocks(run, layered, tmp_path):
    line = ("export", layered, "--to", "unity", "--textures", "dds", "--maps", "apart", "-o", tmp_path / "out")
    code, shown, error = run(*line)
    assert (code, error) == (0, "")
    for name, codec in (("albedo", "bc7"), ("normal", "bc5"), ("roughness", "bc4"), ("cavity", "bc4")):
        assert f"  {name}: {codec} adds" in shown
        textures = [file for file in (tmp_path / "out" / "1002").iterdir() if file.suffix == f".{codec}"]
        assert any(file.name == f"{name}_neutral.{codec}".removeprefix("albedo_") for file in textures)


def animated(run, pack, tmp_path, text, output="out"):
    (tmp_path / "frames.csv").write_text(text, encoding="utf-8")
    call = ("export", pack, "--to", "usd", "--animation", tmp_path / "frames.csv", "-o", tmp_path / output)
    return run(*call)


def test_an_animation_has_an_image_of_weights_for_every_frame(run, pack, tmp_path):
    code, _, error = animated(run, pack, tmp_path, f"{NASTY[1]},{NASTY[3]}\n0,1\n0.5,-0.25\n\n1,0\n")
    assert (code, error) == (0, "")
    frames = sorted(file.name for file in (tmp_path / "out").glob("*.exr"))
    assert frames == [f"weights_0.{number:04d}.exr" for number in range(3)]
    assert "endTimeCode = 2" in (tmp_path / "out" / "head.usda").read_text(encoding="utf-8")


def test_without_an_animation_every_expression_has_a_frame(run, pack, tmp_path):
    assert run("export", pack, "--to", "usd", "-o", tmp_path / "out")[0] == 0
    assert len([*(tmp_path / "out").glob("*.exr")]) == 1 + len(NASTY)


def test_the_gain_of_a_region_is_a_column_of_an_animation(run, pack, tmp_path):
    """Weights are turned down as much as the region's mask says, and nowhere else."""
    (tmp_path / "frames.csv").write_text(f"{NASTY[1]},gains.regions.chin\n1,1\n1,0.25\n1,0\n", encoding="utf-8")
    write_texture(tmp_path / "chin.png", np.random.default_rng(0).integers(0, 256, (40, 24, 1), np.uint8))
    options = ("--animation", tmp_path / "frames.csv", "--region", f"chin={tmp_path / 'chin.png'}")
    assert run("export", pack, "--to", "usd", *options, "-o", tmp_path / "out")[0] == 0
    whole, quarter, none = (
        oiio.ImageBuf(str(tmp_path / "out" / f"weights_0.{n:04d}.exr")).get_pixels() for n in range(3)
    )
    mask = read_texture_exactly(tmp_path / "out" / "regions.png")[..., :1] / 255
    np.testing.assert_allclose(none, whole * (1 - mask), atol=1e-6)
    np.testing.assert_allclose(quarter, whole * (1 - 0.75 * mask), atol=1e-6)


ANIMATIONS = {
    "unknown region": ("gains.regions.chin\n1\n", "no region 'chin'"),
    "unknown name": ("smile\n1\n", "no expression 'smile'"),
    "too few numbers": (f"{NASTY[1]},{NASTY[3]}\n0,1\n0\n", "row 2 of weights is '0', not 2 numbers"),
    "no number": (f"{NASTY[1]}\nmuch\n", "row 1 of weights is 'much', not a number"),
    "beyond all": (f"{NASTY[1]}\nnan\n", "must lie within"),
    "no frames": (f"{NASTY[1]}\n", "no row of weights follows"),
    "nothing": ("", "no row of weights follows"),
    "twice": (f"{NASTY[1]},{NASTY[1]}\n1,1\n", "a name twice"),
}


@pytest.mark.parametrize("fault", ANIMATIONS)
def test_an_animation_that_cannot_be_shown_is_refused(run, pack, tmp_path, fault):
    text, words = ANIMATIONS[fault]
    code, out, error = animated(run, pack, tmp_path, text)
    assert (code, out) == (ExitCode.BAD_INPUT, "")
    assert len(error.splitlines()) == 1
    assert words in error
    assert not (tmp_path / "out").exists()


NO_ANIMATIONS = {
    "a mesh": (b"v 0 0.5 1\nv 1 0.5 0\n", "row 1 of weights is 'v 1 0.5 0', not a number as the first row 'v 0 0.5 1'"),
    "an image": (b"\x89PNG\r\n\x1a\n\0", "not a readable CSV file"),
    "nothing": (b"", "no row of weights follows its first row ''"),
}


@pytest.mark.parametrize("what", NO_ANIMATIONS)
def test_of_what_is_no_animation_it_is_said_what_it_holds_and_what_is_expected(run, pack, tmp_path, what):
    content, words = NO_ANIMATIONS[what]
    (tmp_path / "smile.obj").write_bytes(content)
    code, _, error = run("export", pack, "--to", "usd", "--animation", tmp_path / "smile.obj", "-o", tmp_path / "out")
    assert code == ExitCode.BAD_INPUT
    assert len(error.splitlines()) == 1
    for part in (
        "smile.obj: ",
        words,
        "; give a CSV file of weights: different names of expressions",
    ):
        assert part in error


def test_a_missing_animation_is_named(run, pack, tmp_path):
    code, _, error = run("export", pack, "--to", "usd", "--animation", tmp_path / "none.csv", "-o", tmp_path / "out")
    assert code == ExitCode.BAD_INPUT
    assert "none.csv" in error


def test_regions_are_given_by_name(run, pack, tmp_path):
    regions = regions_in(tmp_path)
    words = [word for name, file in regions.items() for word in ("--region", f"{name}={file}")]
    code, out, error = run("export", pack, "--to", "godot", *words, "-o", tmp_path / "out", "--json")
    assert (code, error) == (0, "")
    assert json.loads(out)["gains"]["regions"] == list(regions)
    assert (tmp_path / "out" / "regions.png").is_file()
