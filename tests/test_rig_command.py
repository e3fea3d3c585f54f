"""``facezip rig``: a folder and a template in, shapes, document and pack out; bad templates in one line."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from facezip.character.loading import save_character
from facezip.cli import facezip
from facezip.errors import ErrorCode, ExitCode, FaceZipError
from facezip.files.obj import read_obj, write_obj
from facezip.machine import memory
from facezip.pack.geometry import TOLERANCE
from facezip.pack.read import read_pack
from facezip.rigging.template import load_template
from tests.facezip.rigging.case import SHAPES, make_case, repeated, with_maps, write_template
from tests.peaks import peak_of


@pytest.fixture(scope="module")
def case():
    """With albedo, normals and roughness on two tiles."""
    made = make_case()
    return replace(made, scans=with_maps(made.scans, (2, 1)))


@pytest.fixture(scope="module")
def folders(case, tmp_path_factory):
    place = tmp_path_factory.mktemp("rig")
    save_character(case.scans, place / "scans")
    write_template(case, place / "template")
    return place


@pytest.fixture(scope="module")
def answer(folders):
    return rig(folders, "out")


def rig(folders, name, *options):
    call = ["rig", folders / "scans", "--template", folders / "template", "-o", folders / name, "--json", *options]
    result = CliRunner().invoke(facezip, [*map(str, call)], catch_exceptions=False)
    assert result.exit_code == 0
    return json.loads(result.stdout)


def test_the_folder_holds_shapes_document_and_pack(answer, folders):
    assert sorted(path.name for path in (folders / "out").iterdir()) == [
        "evidence.png",
        "rig.json",
        "scans.facezip",
        "shapes",
    ]
    assert sorted(path.stem for path in (folders / "out/shapes").iterdir()) == sorted(["neutral", *SHAPES])
    stored = json.loads((folders / "out/rig.json").read_text(encoding="utf-8"))
    assert {**stored, "output": answer["output"]} == answer


def test_pack_and_meshes_agree(answer, folders, case):
    model = read_pack(answer["pack"]["path"])
    assert model.expressions == SHAPES
    vertices, topology = read_obj(folders / "out/shapes/jaw.obj")
    for name in ("faces", "uv", "face_uv"):
        np.testing.assert_array_equal(getattr(topology, name), getattr(case.scans.meshes.topology, name))
    size = np.ptp(model.meshes.neutral, axis=0).max()
    assert np.allclose(vertices, model.meshes.vertices[SHAPES.index("jaw")], atol=TOLERANCE * size)


def test_every_map_on_every_tile_is_in_the_pack_and_in_the_record(answer, case):
    model = read_pack(answer["pack"]["path"])
    assert set(model.parts) == set(case.scans.stacks)
    assert [kind["name"] for kind in answer["character"]["maps"]] == ["albedo", "normal", "roughness"]
    assert [kind["name"] for kind in answer["pack"]["maps"]] == ["albedo", "normal", "roughness"]
    assert answer["character"]["tiles"] == [tile["tile"] for tile in answer["pack"]["tiles"]] == [1001, 1002]
    for key in model.parts:
        changes = [np.abs(model.texels({name: 1.0}, key) - model.texels({}, key)).max() for name in SHAPES]
        assert max(changes) > 0


def test_within_a_limit_of_memory_the_bytes_are_the_same(answer, folders, monkeypatch):
    monkeypatch.setattr(memory, "LEAST", -(10**9))
    with memory.limited(1, folders):
        streamed = rig(folders, "streamed")
    assert {key: streamed[key] for key in answer if key not in ("output", "pack", "seconds")} == {
        key: answer[key] for key in answer if key not in ("output", "pack", "seconds")
    }
    for file in Path(answer["pack"]["path"]).iterdir():
        assert file.read_bytes() == (Path(streamed["pack"]["path"]) / file.name).read_bytes()


def test_a_limit_is_kept_where_a_run_without_it_takes_more(tmp_path):
    """Two processes with large textures: memory shows in nothing less."""
    case = make_case()
    save_character(with_maps(repeated(case.scans, 16)), tmp_path / "scans")
    write_template(case, tmp_path / "template")
    call = ("rig", tmp_path / "scans", "--template", tmp_path / "template", "-o")
    in_memory, whole = peak_of(*call, tmp_path / "whole")
    streamed, same = peak_of(*call, tmp_path / "streamed", "--memory", "430M")
    assert streamed < 430e6 < in_memory
    assert same["damping"] == whole["damping"]
    assert same["pack"]["bytes_on_disk"] == whole["pack"]["bytes_on_disk"]


def test_a_limit_is_of_methods_that_keep_it(folders):
    call = ["rig", folders / "scans", "--template", folders / "template", "-o", folders / "x", "--method", "paper"]
    result = CliRunner().invoke(facezip, [*map(str, call), "--memory", "1G"])
    assert result.exit_code == ExitCode.USAGE
    assert "--memory needs --method refined or masks" in result.output
    assert not (folders / "x").exists()


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


def test_cleaning_is_done_once_asked_for_and_on_record(answer, folders):
    assert "cleaning" not in answer
    cleaned = rig(folders, "cleaned", "--clean", "exposure", "--clean", "neutral")
    assert list(cleaned["cleaning"]) == ["exposure", "neutral"]
    assert cleaned["settings"]["clean"] == ["exposure", "neutral"]
    assert set(cleaned["cleaning"]["neutral"]) == {f"{name}.{tile}" for name, tile in case_keys(answer)}


def case_keys(answer):
    return {(kind["name"], tile) for kind in answer["character"]["maps"] for tile in answer["character"]["tiles"]}


def test_evidence_tells_of_geometry_and_of_textures(answer, folders):
    for found in answer["evidence"].values():
        assert 0 <= found["shown"] <= 1
        assert found["uncertainty"] >= 0
    unseen, seen = (answer["evidence"][name]["shown"] for name in ("tongue", "jaw"))
    assert unseen < seen
    paper = rig(folders, "paper", "--maps", "pseudo-inverse")
    assert all("shown" not in found for found in paper["evidence"].values())
    assert not (folders / "paper" / "evidence.png").exists()
