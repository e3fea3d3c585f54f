"""Packs on disk: what is written reads back, whole or not at all, and nothing else is read."""

import json
import os
import shutil

import numpy as np
import pytest

from facezip import ErrorCode, FaceZipError, compress
from facezip.character.maps import angles
from facezip.files.images import read_texture_exactly
from facezip.files.packs import MANIFEST, is_pack
from facezip.pack.manifest import HEAD_FILE
from facezip.pack.parsing import read_manifest
from facezip.pack.quantise import quantise
from facezip.pack.read import read_pack
from facezip.pack.verification import bytes_on_disk, verify_pack
from facezip.pack.write import write_pack
from tests.facezip.conftest import one_part, part_of, random_model, weights_of
from tests.facezip.surfaces import random_surface


@pytest.fixture
def pack(tmp_path, model):
    write_pack(model, tmp_path / "me.facezip")
    return tmp_path / "me.facezip"


@pytest.fixture(scope="module", params=["refined", "pca"])
def written(request, tmp_path_factory):
    """Several maps on two tiles, the model that was fitted, and its pack."""
    surface = random_surface(tiles=(2, 1))
    model = compress(surface, request.param, differences=5)
    path = tmp_path_factory.mktemp("packs") / "me.facezip"
    write_pack(model, path)
    return surface, model, path


def assert_same(one, other):
    assert one.maps == other.maps
    assert one.expressions == other.expressions
    for key, part in one.parts.items():
        np.testing.assert_array_equal(part.neutral, other.parts[key].neutral)
        np.testing.assert_array_equal(part.differences, other.parts[key].differences)
        assert part.bits == other.parts[key].bits
    for tile, weights in one.weights.items():
        np.testing.assert_array_equal(weights, other.weights[tile])


@pytest.mark.parametrize("slots", [1, 3, 4, 5, 8])
@pytest.mark.parametrize("weights", [(1, 1), (3, 5)])
@pytest.mark.parametrize("expressions", [2, 7])
def test_a_pack_reads_back_as_it_was_quantised(tmp_path, slots, weights, expressions):
    model = random_model(slots=slots, weights=weights, expressions=expressions)
    write_pack(model, tmp_path / "me.facezip")
    back = read_pack(tmp_path / "me.facezip")
    assert_same(back, quantise(model).dequantised())
    assert back.footprint == model.footprint


def test_a_pack_of_maps_and_tiles_reads_back_as_it_was_quantised(written):
    _, model, path = written
    back, expected = read_pack(path), quantise(model).dequantised()
    assert back.tiles == (1001, 1002)
    for key, part in expected.parts.items():
        np.testing.assert_array_equal(back.parts[key].neutral, part.neutral)
        np.testing.assert_allclose(back.parts[key].differences, part.differences, atol=1e-6)
    for tile, weights in expected.weights.items():
        np.testing.assert_array_equal(back.weights[tile], weights)


def test_the_manifest_alone_tells_what_it_costs(written):
    _, model, path = written
    cost = read_manifest(path).footprint
    assert cost.geometry == (path / HEAD_FILE).stat().st_size
    assert (cost.bytes_on_gpu, cost.fetches) == (model.footprint.bytes_on_gpu, model.footprint.fetches)


def test_quantising_again_changes_nothing(pack):
    first = read_pack(pack)
    again = quantise(first).dequantised()
    np.testing.assert_allclose(part_of(again).differences, part_of(first).differences, atol=1e-6)
    np.testing.assert_allclose(weights_of(again), weights_of(first), atol=1e-5)


def test_rounding_is_at_most_half_a_step(model):
    back = quantise(model).dequantised()
    differences, weights = part_of(model).differences, weights_of(model)
    steps = np.abs(differences).max(axis=(1, 2), keepdims=True) / 127
    assert (np.abs(part_of(back).differences - differences) <= 0.5001 * steps).all()
    assert np.abs(weights_of(back) - weights).max() <= 0.5001 * np.ptp(weights, axis=(0, 1, 2)).max() / 255


def test_a_difference_of_zero_stays_zero():
    model = random_model()
    part_of(model).differences[:, :5] = 0
    part_of(model).differences[1] = 0
    back = part_of(quantise(model).dequantised())
    assert (back.differences[:, :5] == 0).all()
    assert (back.differences[1] == 0).all()


def test_the_neutral_keeps_its_bytes_at_16_bits(tmp_path):
    from dataclasses import replace

    model = random_model()
    wide = np.random.default_rng(0).integers(0, 65536, part_of(model).neutral.shape)
    part = replace(part_of(model), neutral=(wide / 65535).astype(np.float32), bits=16)
    write_pack(one_part(part, weights_of(model)), tmp_path / "me.facezip")
    back = part_of(read_pack(tmp_path / "me.facezip"))
    np.testing.assert_array_equal(np.rint(back.neutral * 65535), wide)
    assert back.bits == 16


def test_a_neutral_is_the_map_that_it_was(written):
    surface, _, path = written
    albedo = read_texture_exactly(path / "albedo.1002.neutral.png")
    np.testing.assert_array_equal(albedo, surface.stacks["albedo", 1002].neutral)
    stored = read_texture_exactly(path / "normal.1002.neutral.png") / np.float32(127.5) - 1
    np.testing.assert_allclose(np.linalg.norm(stored, axis=2), 1, atol=0.02)
    assert angles(read_pack(path).reconstruct("neutral", "normal", 1002), stored).max() < 1


def test_bytes_become_values_as_the_manifest_says(written):
    """As an engine reads them, without our code: slopes of normals, values of data, weights."""
    surface, model, path = written
    manifest = json.loads((path / MANIFEST).read_bytes())
    tile = manifest["tiles"][1]
    for kind, entry in zip(surface.maps, tile["textures"], strict=True):
        texture = read_texture_exactly(path / entry["differences"][3])[..., : 2 if kind.is_normal else 3]
        span = np.array(entry["difference_span"][3])
        expected = model.parts[kind.name, 1002].differences[3] * kind.unit
        assert np.abs((texture / 255 - 128 / 255) * span - expected).max() <= 0.51 * span.max() / 255
    if tile["weights"]:
        h, w = tile["weight_size"]
        second = read_texture_exactly(path / tile["weights"][0])[:h, w : 2 * w]
        values = second / 255 * tile["weight_span"][:4] + tile["weight_offset"][:4]
        np.testing.assert_allclose(values, model.weights[1002][1, ..., :4], atol=max(tile["weight_span"]) / 500)
    else:
        np.testing.assert_allclose(manifest["uniform_weights"], model.weights[1002][:, 0, 0], rtol=1e-6)


def test_the_third_channel_of_normal_differences_differs_nowhere(written):
    assert (read_texture_exactly(written[2] / "normal.1001.difference_0.png")[..., 2] == 128).all()


def test_meshes_come_back_within_a_hundred_thousandth_of_the_head(pack, model):
    meshes, height = read_pack(pack).meshes, np.ptp(model.meshes.neutral, axis=0).max()
    np.testing.assert_array_equal(meshes.neutral, model.meshes.neutral)
    np.testing.assert_allclose(meshes.vertices, model.meshes.vertices, atol=1e-5 * height)
    one, other = meshes.topology, model.meshes.topology
    np.testing.assert_array_equal(one.faces, other.faces)
    np.testing.assert_array_equal(one.uv[one.face_uv], other.uv[other.face_uv])


def test_a_model_without_meshes_makes_a_pack_without(tmp_path):
    write_pack(random_model(), tmp_path / "me.facezip")
    assert read_pack(tmp_path / "me.facezip").meshes is None
    assert not (tmp_path / "me.facezip" / HEAD_FILE).exists()


@pytest.mark.parametrize("name", ["", "me"])
def test_the_same_model_gives_the_same_bytes(tmp_path, model, name):
    for folder in ("a", "b"):
        write_pack(model, tmp_path / folder, name=name)
    one, other = ({file.name: file.read_bytes() for file in (tmp_path / folder).iterdir()} for folder in ("a", "b"))
    assert one == other


def refused(pack, code=ErrorCode.DAMAGED_PACK):
    with pytest.raises(FaceZipError) as caught:
        read_pack(pack)
    assert caught.value.code is code
    assert "\n" not in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize("several", [False, True])
def test_every_flipped_bit_is_found(tmp_path, model, several):
    if several:
        surface = random_surface(maps=("normal",), side=32, expressions=3, tiles=(2, 1))
        model = compress(surface, differences=2)
    pack = tmp_path / "me.facezip"
    write_pack(model, pack)
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
    content = (pack / MANIFEST).read_bytes()
    for length in range(0, len(content), 7):
        (pack / MANIFEST).write_bytes(content[:length])
        refused(pack)


def test_files_added_missing_or_linked_are_named(pack):
    (pack / "notes.txt").write_text("hello")
    assert "notes.txt" in refused(pack)
    (pack / "notes.txt").unlink()
    shutil.move(pack / "weights.1001.png", pack.parent / "elsewhere.png")
    assert "weights.1001.png" in refused(pack)
    os.symlink(pack.parent / "elsewhere.png", pack / "weights.1001.png")
    assert "link" in refused(pack)


def test_an_existing_pack_is_replaced_only_when_asked(pack, model):
    with pytest.raises(FaceZipError, match="exists already"):
        write_pack(model, pack)
    write_pack(random_model(seed=1), pack, overwrite=True)
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

    monkeypatch.setattr("facezip.pack.write.head_bytes", full)
    with pytest.raises(FaceZipError, match="No space left") as caught:
        write_pack(model, pack, overwrite=True)
    assert caught.value.code is ErrorCode.CANNOT_WRITE
    assert {file.name: file.read_bytes() for file in pack.iterdir()} == before
    assert [path.name for path in pack.parent.iterdir()] == [pack.name]


def test_meshes_that_no_file_holds_are_refused_and_nothing_is_written(tmp_path, model):
    model.meshes.vertices[0, 0, 0] = np.nan
    with pytest.raises(FaceZipError) as caught:
        write_pack(model, tmp_path / "me.facezip")
    assert caught.value.code is ErrorCode.BAD_VALUE
    assert not [*tmp_path.iterdir()]


@pytest.mark.parametrize("value", [float("nan"), {1, 2}, "\ud800"], ids=["no number", "a set", "half a pair"])
def test_what_json_does_not_hold_is_refused_and_nothing_is_written(tmp_path, model, value):
    with pytest.raises(FaceZipError, match="made_with") as caught:
        write_pack(model, tmp_path / "me.facezip", made_with={"steps": [value]})
    assert caught.value.code is ErrorCode.BAD_VALUE
    assert not [*tmp_path.iterdir()]


def test_bytes_on_disk_are_those_that_the_manifest_states_and_its_own(pack):
    stated = sum(file.bytes for file in read_manifest(pack).files.values())
    assert bytes_on_disk(pack) == stated + (pack / MANIFEST).stat().st_size


def test_what_the_system_does_not_let_one_look_at_is_no_pack(pack):
    assert is_pack(pack) is True
    assert is_pack(pack.parent / ("x" * 300)) is False
