import json
import os
import shutil

import numpy as np
import pytest

from facezip import FaceZipError
from facezip.errors import ErrorCode
from facezip.pack.manifest import FILE_NAME
from facezip.pack.quantise import dequantise, quantise
from facezip.pack.read import read_pack
from facezip.pack.verification import verify_pack
from facezip.pack.write import write_pack
from tests.facezip.conftest import random_model


@pytest.fixture
def pack(tmp_path, model):
    write_pack(model, tmp_path / "me.facezip")
    return tmp_path / "me.facezip"


def same(a, b):
    return all(np.array_equal(getattr(a, name), getattr(b, name)) for name in ("neutral", "differences", "weights"))


@pytest.mark.parametrize("slots", [1, 3, 4, 5, 8])
@pytest.mark.parametrize("weights", [(1, 1), (3, 5)])
@pytest.mark.parametrize("expressions", [2, 7])
def test_a_pack_reads_back_as_it_was_quantised(tmp_path, slots, weights, expressions):
    model = random_model(slots=slots, weights=weights, expressions=expressions)
    write_pack(model, tmp_path / "me.facezip")
    back = read_pack(tmp_path / "me.facezip")
    assert same(back, dequantise(quantise(model), model.expressions, model.method, None))
    assert back.expressions == model.expressions
    assert back.footprint == model.footprint


def test_quantising_again_changes_nothing(pack):
    first = read_pack(pack)
    again = dequantise(quantise(first), first.expressions, first.method, first.meshes)
    np.testing.assert_allclose(again.differences, first.differences, atol=1e-6)
    np.testing.assert_allclose(again.weights, first.weights, atol=1e-5)


def test_rounding_is_at_most_half_a_step(model):
    back = dequantise(quantise(model), model.expressions, model.method, None)
    steps = np.abs(model.differences).max(axis=(1, 2), keepdims=True) / 127
    assert (np.abs(back.differences - model.differences) <= 0.5001 * steps).all()
    assert np.abs(back.weights - model.weights).max() <= 0.5001 * np.ptp(model.weights, axis=(0, 1, 2)).max() / 255


def test_a_difference_of_zero_stays_zero():
    model = random_model()
    model.differences[:, :5] = 0
    model.differences[1] = 0
    back = dequantise(quantise(model), model.expressions, model.method, None)
    assert (back.differences[:, :5] == 0).all()
    assert (back.differences[1] == 0).all()


def test_the_neutral_keeps_its_bytes_at_8_and_16_bits(tmp_path):
    model = random_model()
    wide = np.random.default_rng(0).integers(0, 65536, model.neutral.shape)
    model.neutral[:] = wide / 65535
    write_pack(model, tmp_path / "me.facezip", neutral_bits=16)
    np.testing.assert_array_equal(np.rint(read_pack(tmp_path / "me.facezip").neutral * 65535), wide)


def test_meshes_come_back_bit_for_bit(pack, model):
    meshes = read_pack(pack).meshes
    np.testing.assert_array_equal(meshes.neutral, model.meshes.neutral)
    np.testing.assert_array_equal(meshes.deltas, model.meshes.deltas)
    assert meshes.topology.same_as(model.meshes.topology)


def test_the_same_model_gives_the_same_bytes(tmp_path, model):
    for name in ("a", "b"):
        write_pack(model, tmp_path / name, name="me")
    for file in (tmp_path / "a").iterdir():
        assert file.read_bytes() == (tmp_path / "b" / file.name).read_bytes()


def refused(pack, code=ErrorCode.DAMAGED_PACK):
    with pytest.raises(FaceZipError) as caught:
        read_pack(pack)
    assert caught.value.code is code
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_every_flipped_bit_is_found(pack):
    rng = np.random.default_rng(0)
    for file in sorted(pack.iterdir()):
        content = file.read_bytes()
        for bit in rng.integers(0, 8 * len(content), 12):
            damaged = bytearray(content)
            damaged[bit // 8] ^= 1 << (bit % 8)
            file.write_bytes(damaged)
            refused(pack)
        file.write_bytes(content)
    verify_pack(pack)


def test_every_prefix_of_the_manifest_is_refused(pack):
    content = (pack / FILE_NAME).read_bytes()
    for length in range(0, len(content), 7):
        (pack / FILE_NAME).write_bytes(content[:length])
        refused(pack)


def test_files_added_missing_or_linked_are_named(pack):
    (pack / "notes.txt").write_text("hello")
    assert "notes.txt" in refused(pack)
    (pack / "notes.txt").unlink()
    shutil.move(pack / "weights.png", pack.parent / "elsewhere.png")
    assert "weights.png" in refused(pack)
    os.symlink(pack.parent / "elsewhere.png", pack / "weights.png")
    assert "link" in refused(pack)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("size", [24, 40000]),
        ("size", "24x40"),
        ("channels", 99),
        ("expressions", ["../../etc", "a", "b"]),
        ("expressions", ["a", "a", "b"]),
        ("difference_scale", [[1e999, 1, 1]] * 4),
        ("weight_offset", [0]),
        ("weight_columns", 0),
        ("uniform_weights", [[1, 1, 1, 1]] * 3),
        ("encoding", "linear"),
        ("files", {"../secret": {"bytes": 1, "sha256": "0"}}),
        ("surprise", 1),
    ],
)
def test_a_well_signed_manifest_with_a_wrong_field_is_refused(pack, field, value):
    from hashlib import sha256

    document = json.loads((pack / FILE_NAME).read_bytes())
    document |= {field: value, "sha256": "0" * 64}
    blank = json.dumps(document, indent=1).encode()
    (pack / FILE_NAME).write_bytes(blank.replace(b"0" * 64, sha256(blank).hexdigest().encode(), 1))
    refused(pack, ErrorCode.BAD_PACK)


def test_an_existing_pack_is_replaced_only_when_asked(pack, model):
    with pytest.raises(FaceZipError, match="exists already"):
        write_pack(model, pack)
    other = random_model(seed=1)
    write_pack(other, pack, overwrite=True)
    assert read_pack(pack).meshes is None


def test_a_folder_that_is_no_pack_is_never_replaced(tmp_path, model):
    (tmp_path / "photos").mkdir()
    (tmp_path / "photos" / "me.jpg").write_bytes(b"precious")
    with pytest.raises(FaceZipError, match="not made by facezip"):
        write_pack(model, tmp_path / "photos", overwrite=True)
    assert (tmp_path / "photos" / "me.jpg").read_bytes() == b"precious"


def test_a_failed_write_leaves_the_old_pack_and_nothing_else(pack, model, monkeypatch):
    before = {file.name: file.read_bytes() for file in pack.iterdir()}

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("facezip.pack.version_1.write_meshes", full)
    with pytest.raises(FaceZipError, match="No space left") as caught:
        write_pack(model, pack, overwrite=True)
    assert caught.value.code is ErrorCode.CANNOT_WRITE
    assert {file.name: file.read_bytes() for file in pack.iterdir()} == before
    assert [path.name for path in pack.parent.iterdir()] == [pack.name]
