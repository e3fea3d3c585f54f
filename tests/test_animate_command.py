"""``facezip animate``: sequences, what a blend is compared with, and the report."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image

from facezip.character.loading import save_character
from facezip.cli import facezip
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.images import to_float
from facezip.fit.methods import compress
from facezip.pack.read import read_pack
from facezip.pack.write import write_pack
from facezip.rigging.originals import BLEND, originals_of
from facezip.rigging.sequences import ARKIT, EMBEDDED, Pose, frames_of, poses_for
from render.animation import animate
from render.settings import Settings
from scenes.face.expressions import EXPRESSIONS
from scenes.face.shapes import ARKIT_SHAPES
from tests.facezip.conftest import random_character
from tests.facezip.rigging.case import make_case, with_maps


@pytest.fixture(scope="module")
def scans():
    """Albedo, normals and roughness on two tiles."""
    return with_maps(make_case().scans, (2, 1))


@pytest.fixture(scope="module")
def model(scans):
    return compress(scans, "pca")


@pytest.fixture(scope="module")
def report(scans, model, tmp_path_factory):
    place = tmp_path_factory.mktemp("animate")
    save_character(scans, place / "scans")
    write_pack(model, place / "me.facezip", name="me")
    paths = [str(place / name) for name in ("scans", "me.facezip")]
    call = ["animate", *paths, "-o", str(place / "out"), "--frames", "6", "--resolution", "64", "--spp", "2", "--json"]
    result = CliRunner().invoke(facezip, call, catch_exceptions=False)
    assert result.exit_code == 0
    return json.loads(result.stdout), place / "out"


def test_presets_use_names_that_exist():
    assert poses_for(ARKIT_SHAPES) == ARKIT
    assert poses_for([*EXPRESSIONS]) == EMBEDDED


def test_other_names_each_rise_alone_and_in_pairs():
    poses = poses_for(["a", "b", "c"])
    assert [{**pose.weights} for pose in poses] == [
        {"a": 1},
        {"b": 1},
        {"c": 1},
        {"a": 0.5, "b": 0.5},
        {"b": 0.5, "c": 0.5},
    ]


def test_a_loop_begins_neutral_and_passes_through_every_pose():
    poses = (Pose("one", {"a": 1.0}), Pose("two", {"a": 0.5, "b": 0.5}))
    frames = frames_of(poses)
    assert [dict(frames[i].weights) for i in (0, 4, 8)] == [{}, {"a": 1.0}, {"a": 0.5, "b": 0.5}]
    assert all(0 < weight <= 1 for frame in frames for weight in frame.weights.values())
    assert [len(frames_of(poses, count)) for count in (2, 7)] == [2, 7]


def test_a_blend_of_one_expression_is_its_scan(scans, model, tmp_path):
    originals = originals_of(scans, model, tmp_path)
    name = scans.expressions[1]
    blend = originals.blended({name: 1.0})
    assert blend.maps == scans.maps
    for key, stack in scans.stacks.items():
        np.testing.assert_allclose(blend.texels(BLEND, key), to_float(scans.texels(name, key)), atol=1e-6)
        np.testing.assert_array_equal(originals.texels({}, key), to_float(stack.neutral))
    assert np.allclose(blend.mesh_vertices(BLEND), scans.mesh_vertices(name), atol=1e-5)


def test_a_blend_is_the_sum_of_differences(scans, model, tmp_path):
    """Equation (8), spelled out, where nothing is clipped."""
    originals, weights = originals_of(scans, model, tmp_path), {scans.expressions[0]: 0.5, scans.expressions[2]: 0.25}
    for key, stack in scans.stacks.items():
        neutral = to_float(stack.neutral)
        expected = neutral + sum(w * (to_float(scans.texels(name, key)) - neutral) for name, w in weights.items())
        np.testing.assert_allclose(originals.texels(weights, key), np.clip(expected, 0, 1), atol=1e-6)


def test_a_pack_of_other_scans_is_refused(scans, model, tmp_path):
    other = replace(model, expressions=tuple(f"x{n}" for n in range(len(model.expressions))))
    with pytest.raises(FaceZipError, match="no expression") as caught:
        originals_of(scans, other, tmp_path / "other.facezip")
    assert caught.value.code is ErrorCode.UNKNOWN_NAME


def test_naive_originals_of_a_rig_give_the_scans_back(scans, model, tmp_path):
    """Every scan a shape of its own at half strength: the shape is the scan twice, and half of it the scan."""
    shapes = tuple(f"x{n}" for n in range(len(model.expressions)))
    rows = {name: {shape: 0.5} for name, shape in zip(scans.expressions, shapes, strict=True)}
    (tmp_path / "rig.json").write_text(json.dumps({"example_weights": rows}), encoding="utf-8")
    originals = originals_of(scans, replace(model, expressions=shapes), tmp_path / "rigged.facezip")
    for key in scans.stacks:
        expected = to_float(scans.texels(scans.expressions[0], key))
        np.testing.assert_allclose(originals.texels({"x0": 0.5}, key), expected, atol=1e-5)


def test_the_worst_frame_is_named_and_the_files_agree(report):
    answer, folder = report
    errors = [frame["image_rmse"] for frame in answer["frames"]]
    assert len(errors) == 6
    assert errors[answer["worst"]] == max(errors)
    assert {"output": answer["output"], **json.loads((folder / "animation.json").read_text())} == answer
    page = (folder / "index.html").read_text(encoding="utf-8")
    assert f"worst: frame {answer['worst']}" in page
    assert "prefers-reduced-motion" in page


def test_the_error_of_every_map_is_that_of_all_its_tiles(scans, model, report, tmp_path):
    answer, folder = report
    frame, read = answer["frames"][2], read_pack(folder.parent / "me.facezip")
    originals = originals_of(scans, read, tmp_path)
    assert frame["weights"]
    squares = [
        np.mean((read.texels(frame["weights"], key) - originals.texels(frame["weights"], key)) ** 2)
        for key in scans.stacks
        if key[0] == "roughness"
    ]
    assert frame["map_errors"]["roughness"]["rmse"] == pytest.approx(255 * np.sqrt(np.mean(squares)), rel=1e-3)
    assert frame["texture_rmse"] == frame["map_errors"]["albedo"]["rmse"]
    assert frame["map_errors"]["normal"]["angular_error"] > 0
    page = (folder / "index.html").read_text(encoding="utf-8")
    assert "Normal, mean angle in degrees" in page
    assert "3 maps on 2 tiles" in page
    assert answer["conditions"]["maps_rendered"] == ["albedo", "normal", "roughness"]


@pytest.mark.parametrize("name", ["normal", "roughness"])
def test_what_differs_in_one_map_alone_is_seen(scans, name):
    """The model holds the scans exactly, but for one map of a frame."""
    pose = Pose("one", {scans.expressions[0]: 1.0})
    exact = compress(scans, "pca", differences=4)
    parts = {
        key: replace(part, differences=part.differences[:, ::-1].copy()) if key[0] == name else part
        for key, part in exact.parts.items()
    }
    look = Settings(resolution=48, spp=4)
    same, spoilt = (
        animate(originals_of(scans, one, Path("me.facezip")), one, [pose], look).document.frames[0]
        for one in (exact, replace(exact, parts=parts))
    )
    assert same.image_rmse < 0.1
    assert spoilt.image_rmse > 0.5
    assert spoilt.texture_rmse == same.texture_rmse


def test_an_albedo_alone_has_no_column_of_other_maps(tmp_path):
    scans = random_character(side=32, expressions=2)
    save_character(scans, tmp_path / "sheet")
    write_pack(compress(scans, "pca", differences=1), tmp_path / "me.facezip")
    call = ["animate", tmp_path / "sheet", tmp_path / "me.facezip", "-o", tmp_path / "out", "--frames", 2]
    result = CliRunner().invoke(facezip, [*map(str, call), "--resolution", "48", "--spp", "2"], catch_exceptions=False)
    assert "maps " not in result.output
    assert "mean angle" not in (tmp_path / "out" / "index.html").read_text(encoding="utf-8")


def test_the_loop_has_every_frame_side_by_side(report):
    _, folder = report
    with Image.open(folder / "animation.webp") as loop:
        assert loop.is_animated
        assert loop.width % 3 == 0


@pytest.mark.parametrize(
    "record", ["", "[]", "{}", '{"example_weights": 1}', '{"example_weights": {"a": {"b": "x"}}}', "\xff", "[" * 9000,
               '{"example_weights": {"a": {"b": NaN}}}'],
)  # fmt: skip
def test_a_spoilt_record_of_a_rig_is_one_error(scans, model, tmp_path, record):
    (tmp_path / "rig.json").write_bytes(record.encode("latin-1"))
    other = replace(model, expressions=tuple(f"{name}_shape" for name in model.expressions))
    with pytest.raises(FaceZipError, match=r"rig\.json") as error:
        originals_of(scans, other, tmp_path / "other.facezip")
    assert error.value.code is ErrorCode.BAD_VALUE
