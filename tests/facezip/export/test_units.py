"""The size of a head: known, it is in metres in every export; unknown, numbers stay, and their likely unit is said."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from facezip.character.meshes import Meshes
from facezip.character.placement import Placement, placed
from facezip.character.units import HEAD, UNITS, WORDS, in_metres, likely_unit
from facezip.export import TARGETS
from facezip.files.glb import Glb
from facezip.pack.read import read_pack
from facezip.pack.write import write_pack
from tests.facezip.conftest import random_model

TALL = 28.0


def sized(unit):
    """A model whose mesh is as large as a head in some unit."""
    model = random_model(meshes=True)
    meshes = model.meshes
    scale = np.float32(TALL / UNITS[unit] / np.ptp(meshes.neutral[meshes.topology.faces].reshape(-1, 3), axis=0).max())
    neutral = scale * meshes.neutral
    return replace(model, meshes=Meshes(meshes.topology, neutral, neutral + np.float32(0.02) * scale * meshes.deltas))


def stated(model, unit):
    """The same, as a character whose ``character.toml`` states its unit is read."""
    stated = Placement(up="y", front="z", unit=unit)
    return replace(model, meshes=placed(model.meshes, model.expressions, stated, Path("scans"))[0])


def exported(model, folder, target):
    write_pack(model, folder / "me.facezip")
    return TARGETS[target](folder / "me.facezip", folder / target)


def points(folder, target):
    """Positions ``(K, 3)`` of the neutral and what an expression adds, in metres as the format says."""
    if target == "usd":
        text = (folder / target / "head.usda").read_text()
        metres = float(re.search(r"metersPerUnit = ([\d.]+)", text)[1])
        written = re.search(r"point3f\[\] points = \[(.*)\]", text)[1]
        numbers = re.findall(r"[-+.\de]+", written)
        return metres * np.array(numbers, float).reshape(-1, 3)
    glb = Glb.read(folder / target / "head.glb")
    (primitive,) = glb.document["meshes"][0]["primitives"]
    return glb.array(primitive["attributes"]["POSITION"]).astype(float)


@pytest.mark.parametrize("target", ["gltf", "unreal", "unity", "godot", "blender", "usd"])
def test_heads_of_every_stated_unit_come_out_alike_and_in_metres(tmp_path, target):
    alike = []
    for unit in UNITS:
        (tmp_path / unit).mkdir()
        document = exported(stated(sized(unit), unit), tmp_path / unit, target)
        alike.append(points(tmp_path / unit, target))
        (words,) = document.notes
        assert "m tall, as its unit is known" in words
    assert np.ptp(alike[0], axis=0).max() == pytest.approx(TALL / 100, rel=1e-5)
    for other in alike[1:]:
        np.testing.assert_allclose(other, alike[0], atol=1e-6)


@pytest.mark.parametrize("target", ["gltf", "usd"])
@pytest.mark.parametrize("unit", UNITS)
def test_numbers_of_an_unknown_unit_stay_and_the_unit_that_is_likely_is_said(tmp_path, target, unit):
    model = sized(unit)
    document = exported(model, tmp_path, target)
    found = points(tmp_path, target) * (100 if target == "usd" else 1)
    assert np.ptp(found, axis=0).max() == pytest.approx(TALL / UNITS[unit], rel=1e-5)
    said = " ".join(document.notes)
    if unit == ("cm" if target == "usd" else "m"):
        assert not said
    else:
        assert f"probably {WORDS[unit]}" in said
        assert f'unit = "{unit}"' in said


@pytest.mark.parametrize("target", ["unity", "godot"])
def test_guides_say_how_large_a_head_is_where_there_is_one(tmp_path, target):
    said = []
    for model in (sized("m"), random_model()):
        write_pack(model, tmp_path / "me.facezip", overwrite=True)
        TARGETS[target](tmp_path / "me.facezip", tmp_path / target, overwrite=True)
        said.append("metres" in (tmp_path / target / "GUIDE.md").read_text(encoding="utf-8"))
    assert said == [True, False]


@given(st.sampled_from([*UNITS]), st.floats(0.7, 1.5))
def test_a_head_is_likely_to_be_in_its_own_unit_whatever_its_size(unit, times):
    extents = np.array([0.7, 1.0, 0.8]) * times * HEAD / UNITS[unit]
    assert likely_unit(extents) == unit
    assert likely_unit(extents * 1e4) is None


def test_a_pack_keeps_that_its_unit_is_known(tmp_path):
    for model in (sized("cm"), stated(sized("cm"), "cm")):
        write_pack(model, tmp_path / "me.facezip", overwrite=True)
        assert read_pack(tmp_path / "me.facezip").meshes.centimetres == model.meshes.centimetres
    plain = in_metres(model.meshes)
    np.testing.assert_allclose(100 * plain.deltas, model.meshes.deltas, rtol=1e-4, atol=1e-5)
    assert in_metres(plain) is plain
