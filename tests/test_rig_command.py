"""``facezip rig``: a folder and a template in, shapes, document and pack out; bad templates in one line."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

from facezip.character.loading import save_character
from facezip.cli import facezip
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.obj import read_obj, write_obj
from facezip.pack.read import read_pack
from facezip.rigging.template import load_template
from tests.facezip.rigging.case import SHAPES, make_case


@pytest.fixture(scope="module")
def case():
    return make_case()


@pytest.fixture(scope="module")
def folders(case, tmp_path_factory):
    place = tmp_path_factory.mktemp("rig")
    save_character(case.scans, place / "scans")
    (place / "template").mkdir()
    write_obj(place / "template/neutral.obj", case.template.neutral, case.scans.meshes.topology)
    for name, delta in zip(SHAPES, case.template.deltas, strict=True):
        write_obj(place / f"template/{name}.obj", case.template.neutral + delta, case.scans.meshes.topology)
    return place


@pytest.fixture(scope="module")
def answer(folders):
    call = [
        "rig",
        str(folders / "scans"),
        "--template",
        str(folders / "template"),
        "-o",
        str(folders / "out"),
        "--json",
    ]
    result = CliRunner().invoke(facezip, call, catch_exceptions=False)
    assert result.exit_code == 0
    return json.loads(result.stdout)


def test_the_folder_holds_shapes_document_and_pack(answer, folders):
    assert sorted(path.name for path in (folders / "out").iterdir()) == ["rig.json", "scans.facezip", "shapes"]
    assert sorted(path.stem for path in (folders / "out/shapes").iterdir()) == sorted(["neutral", *SHAPES])
    stored = json.loads((folders / "out/rig.json").read_text(encoding="utf-8"))
    assert {**stored, "output": answer["output"]} == answer


def test_pack_and_meshes_agree(answer, folders, case):
    model = read_pack(answer["pack"]["path"])
    assert model.expressions == SHAPES
    vertices, topology = read_obj(folders / "out/shapes/jaw.obj")
    assert topology.same_as(case.scans.meshes.topology)
    assert np.allclose(vertices - case.scans.meshes.neutral, model.meshes.deltas[SHAPES.index("jaw")], atol=1e-6)


def test_the_document_tells_what_every_scan_is_made_of(answer, case):
    assert list(answer["example_weights"]) == list(case.scans.expressions)
    assert answer["unseen_shapes"] == ["tongue"]
    assert answer["rank"] == 4
    assert all(fit["rms_left"] < fit["rms_displacement"] for fit in answer["fit"].values())


def test_a_template_of_another_topology_is_refused(case, tmp_path):
    topology = case.scans.meshes.topology
    other = type(topology)(topology.faces[1:], topology.uv, topology.face_uv[1:])
    for name in ("neutral", "jaw"):
        write_obj(tmp_path / f"{name}.obj", case.template.neutral, other)
    with pytest.raises(FaceZipError, match=r"neutral\.obj") as caught:
        load_template(tmp_path, topology)
    assert caught.value.code is ErrorCode.TOPOLOGY_MISMATCH


@pytest.mark.parametrize("present", [(), ("neutral",), ("jaw",)])
def test_a_template_needs_a_neutral_and_shapes(case, tmp_path, present):
    for name in present:
        write_obj(tmp_path / f"{name}.obj", case.template.neutral, case.scans.meshes.topology)
    with pytest.raises(FaceZipError) as caught:
        load_template(tmp_path, case.scans.meshes.topology)
    assert caught.value.code is ErrorCode.MISSING_FILE
