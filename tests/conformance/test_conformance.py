"""Two readers, one of them written from docs/pack-format.md alone, say the same of every vector."""

import base64
import json
import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from facezip import FaceZipError, read_pack
from facezip.pack.manifest import FORMAT
from facezip.pack.parsing import MAX_BYTES
from facezip.pack.write import write_pack
from tests.conformance.make import EXPECTED, PACK, VECTORS, make
from tests.conformance.valid import model
from tests.trust.claims import sign

READER = VECTORS.parent / "answers.mjs"
NAMES = sorted(folder.name for folder in VECTORS.iterdir())
EVERY = {name: json.loads((VECTORS / name / EXPECTED).read_text(encoding="utf-8")) for name in NAMES}
READABLE = [name for name in NAMES if EVERY[name]["code"] is None]
NEWEST = [name for name in READABLE if EVERY[name]["format"] == FORMAT]


@pytest.fixture(scope="module")
def answers():
    """What the second reader says of every vector, in one process."""
    return dict(zip(NAMES, _answers(*(VECTORS / name for name in NAMES)), strict=True))


def _answers(*vectors):
    if shutil.which("node") is None:
        pytest.skip("Node.js is not installed")
    command = ["node", READER, *vectors]
    done = subprocess.run([*map(str, command)], capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def code_of(pack):
    try:
        read_pack(pack)
    except FaceZipError as error:
        return str(error.code)
    return None


def assert_texels(kind, values, expected):
    """Within float32's precision; the library keeps slopes of -10 to 10 as numbers from 0 to 1, which costs a digit."""
    tolerance = 1e-5 if kind.is_normal else 1e-6 * max(abs(kind.low), abs(kind.high))
    np.testing.assert_allclose(values, expected, rtol=0, atol=tolerance)


def numbers(text, dtype=np.float32):
    return np.frombuffer(base64.b64decode(text), dtype)


def test_there_are_many_vectors_and_half_of_them_are_refusals():
    assert len(NAMES) >= 60
    assert len(READABLE) >= 30
    assert len(NAMES) - len(READABLE) >= 30


@pytest.mark.parametrize("name", NAMES)
def test_the_library_says_what_is_expected(name):
    assert code_of(VECTORS / name / PACK) == EVERY[name]["code"]


@pytest.mark.parametrize("name", NAMES)
def test_the_second_reader_says_what_is_expected(answers, name):
    code = EVERY[name]["code"]
    assert answers[name]["code"] == (code if code or name in NEWEST else "other-format")


@pytest.mark.parametrize("name", READABLE)
def test_the_library_reads_the_expected_texels_and_meshes(name):
    back, expected = read_pack(VECTORS / name / PACK), EVERY[name]
    assert [list(back.expressions), list(back.tiles)] == [expected["expressions"], expected["tiles"]]
    kinds = {kind.name: kind for kind in back.maps}
    assert [*kinds] == expected["maps"]
    for asked in expected["blends"]:
        values = back.blend(asked["blend"], asked["map"], asked["tile"])
        assert list(values.shape) == asked["size"]
        assert_texels(kinds[asked["map"]], values.mean(axis=(0, 1), dtype=np.float64), asked["mean"])
        for texel in asked["texels"]:
            assert_texels(kinds[asked["map"]], values[texel["row"], texel["column"]], texel["values"])
    assert (back.meshes is None) == (expected["meshes"] is None)
    if back.meshes:
        assert back.meshes.topology.faces.tolist() == expected["meshes"]["triangles"]
        assert np.array_equal(back.meshes.neutral, np.float32(expected["meshes"]["neutral"]))
        assert np.array_equal(back.meshes.vertices[-1], np.float32(expected["meshes"]["last_expression"]))


@pytest.mark.parametrize("name", NEWEST)
def test_both_readers_see_the_same_texels(answers, name):
    back, answer = read_pack(VECTORS / name / PACK), answers[name]
    kinds = {kind.name: kind for kind in back.maps}
    assert [answer["name"], answer["expressions"]] == [EVERY[name]["name"], list(back.expressions)]
    for asked, seen in zip(EVERY[name]["blends"], answer["blends"], strict=True):
        expected = back.blend(asked["blend"], asked["map"], asked["tile"])
        assert_texels(kinds[asked["map"]], numbers(seen["values"]).reshape(seen["size"]), expected)


@pytest.mark.parametrize("name", [name for name in NEWEST if EVERY[name]["meshes"]])
def test_both_readers_see_the_same_meshes_bit_for_bit(answers, name):
    meshes, seen = read_pack(VECTORS / name / PACK).meshes, answers[name]["meshes"]
    layout = numbers(seen["uv"]).reshape(-1, 2)[numbers(seen["uvTriangles"], np.uint32)]
    assert np.array_equal(numbers(seen["neutral"]), meshes.neutral.ravel())
    assert np.array_equal([numbers(shape) for shape in seen["expressions"]], meshes.vertices.reshape(2, -1))
    assert np.array_equal(numbers(seen["triangles"], np.uint32), meshes.topology.faces.ravel())
    assert np.array_equal(layout, meshes.topology.uv[meshes.topology.face_uv.ravel()])


@pytest.mark.parametrize("longer", [0, 1])
def test_a_manifest_of_more_than_2_mebibytes_is_refused_by_both(tmp_path, longer):
    """Too long to be kept as a vector."""
    write_pack(model(), tmp_path / PACK)
    sign(tmp_path / PACK, {"made_with": {"x": ""}})
    room = MAX_BYTES - (tmp_path / PACK / "manifest.json").stat().st_size
    sign(tmp_path / PACK, {"made_with": {"x": "x" * (room + longer)}})
    (tmp_path / EXPECTED).write_text("{}")
    expected = "bad-pack" if longer else None
    assert code_of(tmp_path / PACK) == expected
    assert _answers(tmp_path)[0]["code"] == expected


def test_the_vectors_are_what_the_script_makes(tmp_path):
    make(tmp_path / "vectors")
    assert _contents(tmp_path / "vectors") == _contents(VECTORS)


def _contents(folder: Path):
    """Every file by its path; of links where they point, of what is expected the statement without its numbers."""
    return {
        str(path.relative_to(folder)): os.readlink(path) if path.is_symlink() else _content(path)
        for path in folder.rglob("*")
        if path.is_symlink() or path.is_file()
    }


def _content(path):
    # Other processors round the last digit of a blend otherwise; the tests above compare those.
    return _without_numbers(json.loads(path.read_bytes())) if path.name == EXPECTED else path.read_bytes()


def _without_numbers(value):
    if isinstance(value, dict):
        return {key: _without_numbers(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_without_numbers(item) for item in value]
    return None if isinstance(value, float) else value


def test_all_vectors_together_are_small():
    assert sum(path.lstat().st_size for path in VECTORS.rglob("*") if not path.is_dir()) < 2**20
