"""``facezip animate``: sequences, what a blend is compared with, and the report."""

import json
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image

from facezip.character.loading import save_character
from facezip.cli import facezip
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.images import to_float
from facezip.fit.methods import compress
from facezip.pack.write import write_pack
from facezip.rigging.originals import originals_of
from facezip.rigging.sequences import ARKIT, EMBEDDED, Pose, frames_of, poses_for
from scenes.face.expressions import EXPRESSIONS
from scenes.face.shapes import ARKIT_SHAPES
from tests.facezip.rigging.case import make_case


@pytest.fixture(scope="module")
def scans():
    return make_case().scans


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


def test_an_original_of_one_expression_is_its_scan(scans, model, tmp_path):
    originals = originals_of(scans, model, tmp_path)
    name = scans.expressions[1]
    assert np.allclose(originals.texture({name: 1.0}), scans.texture(name), atol=1e-6)
    assert np.allclose(originals.vertices({name: 1.0}), scans.mesh_vertices(name), atol=1e-5)
    assert np.array_equal(originals.texture({}), to_float(scans.first.neutral))


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
    assert np.allclose(originals.texture({"x0": 0.5}), scans.texture(scans.expressions[0]), atol=1e-5)


def test_the_worst_frame_is_named_and_the_files_agree(report):
    answer, folder = report
    errors = [frame["image_rmse"] for frame in answer["frames"]]
    assert len(errors) == 6
    assert errors[answer["worst"]] == max(errors)
    assert {"output": answer["output"], **json.loads((folder / "animation.json").read_text())} == answer
    page = (folder / "index.html").read_text(encoding="utf-8")
    assert f"worst: frame {answer['worst']}" in page
    assert "prefers-reduced-motion" in page


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
