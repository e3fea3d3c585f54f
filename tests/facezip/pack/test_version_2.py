"""Version 2 of the format: what is written is read, nothing else is, and the ordinary case is still version 1."""

import json
from hashlib import sha256

import numpy as np
import pytest

from facezip import ErrorCode, FaceZipError
from facezip.character.maps import angles
from facezip.character.scans import Character
from facezip.files.images import read_texture_exactly
from facezip.fit.methods import compress
from facezip.pack.manifest import FILE_NAME
from facezip.pack.parsing import read_manifest
from facezip.pack.read import read_pack
from facezip.pack.verification import verify_pack
from facezip.pack.write import write_pack
from tests.facezip.conftest import random_character
from tests.facezip.surfaces import random_surface


@pytest.fixture(scope="module", params=["refined", "pca"])
def written(request, tmp_path_factory):
    surface = random_surface(tiles=(2, 1))
    model = compress(surface, request.param, differences=5)
    path = tmp_path_factory.mktemp("packs") / "me.facezip"
    write_pack(model, path, neutral_bits=surface.neutral_bits)
    return surface, model, path


@pytest.fixture
def pack(tmp_path, small):
    write_pack(small, tmp_path / "me.facezip")
    return tmp_path / "me.facezip"


@pytest.fixture(scope="module")
def small():
    return compress(random_surface(maps=("normal",), side=32, expressions=3, tiles=(2, 1)), differences=2)


def test_a_pack_reads_back_as_it_was_quantised(written):
    _, model, path = written
    back = read_pack(path)
    assert back.maps == model.maps
    assert back.tiles == (1001, 1002)
    assert back.footprint == model.footprint == read_manifest(path).footprint
    for key, part in model.parts.items():
        steps = np.abs(part.differences).max(axis=(1, 2), keepdims=True) / 127
        assert (np.abs(back.parts[key].differences - part.differences) <= 0.51 * steps + 1e-6).all()
        np.testing.assert_allclose(back.parts[key].weights, part.weights, atol=2e-6)
    meshes = back.meshes
    np.testing.assert_array_equal(meshes.topology.uv, model.meshes.topology.uv)
    np.testing.assert_array_equal(meshes.deltas, model.meshes.deltas)


def test_maps_of_a_tile_share_one_array_of_weights(written):
    back = read_pack(written[2])
    assert back.parts["albedo", 1002].weights is back.parts["normal", 1002].weights


def test_a_neutral_is_the_map_that_it_was(written):
    surface, _, path = written
    albedo = read_texture_exactly(path / "albedo.1002.neutral.png")
    np.testing.assert_array_equal(albedo, surface.parts["albedo", 1002].neutral)
    stored = read_texture_exactly(path / "normal.1002.neutral.png") / np.float32(127.5) - 1
    kind = surface.maps[1]
    np.testing.assert_allclose(np.linalg.norm(stored, axis=2), 1, atol=0.02)
    assert angles(kind.values(read_pack(path).parts["normal", 1002].neutral), stored).max() < 1


def test_differences_are_in_units_of_the_map(written):
    """As an engine reads them, without our code: slopes of normals, values of data."""
    surface, model, path = written
    manifest = json.loads((path / FILE_NAME).read_bytes())
    tile = manifest["tiles"][1]
    for k, kind in enumerate(surface.maps):
        texture = read_texture_exactly(path / f"{kind.name}.1002.difference_3.png")[..., : 2 if kind.is_normal else 3]
        scale = np.array(tile["textures"][k]["difference_scale"][3])
        expected = model.parts[kind.name, 1002].differences[3] * kind.unit
        assert np.abs((texture / 255 - 128 / 255) * scale - expected).max() <= 0.51 * scale.max() / 255


def test_the_third_channel_of_normal_differences_differs_nowhere(written):
    assert (read_texture_exactly(written[2] / "normal.1001.difference_0.png")[..., 2] == 128).all()


def test_one_albedo_on_one_tile_is_version_1_byte_for_byte(tmp_path):
    character = random_character(side=64)
    write_pack(compress(character), tmp_path / "a", name="me")
    write_pack(compress(Character.of(character)), tmp_path / "b", name="me")
    assert sorted(file.name for file in (tmp_path / "a").iterdir()) == sorted(
        f.name for f in (tmp_path / "b").iterdir()
    )
    for file in (tmp_path / "a").iterdir():
        assert file.read_bytes() == (tmp_path / "b" / file.name).read_bytes()


def test_both_versions_are_read_by_one_function(tmp_path, pack):
    character = random_character(side=64)
    model = compress(character)
    write_pack(model, tmp_path / "one")
    assert read_pack(tmp_path / "one").ordinary
    assert not read_pack(pack).ordinary
    np.testing.assert_array_equal(
        read_pack(tmp_path / "one").whole.differences, read_pack(tmp_path / "one").differences
    )


@pytest.mark.parametrize("read", [read_pack, verify_pack])
def test_a_reader_of_one_albedo_says_what_it_was_given(pack, read):
    with pytest.raises(FaceZipError, match="several maps or tiles") as caught:
        read(pack)
    assert caught.value.code is ErrorCode.OTHER_FORMAT


def test_the_same_model_gives_the_same_bytes(pack, tmp_path, small):
    write_pack(small, tmp_path / "again.facezip")
    for file in pack.iterdir():
        assert file.read_bytes() == (tmp_path / "again.facezip" / file.name).read_bytes()


def refused(pack, code):
    with pytest.raises(FaceZipError) as caught:
        read_pack(pack)
    assert caught.value.code is code
    assert "\n" not in str(caught.value)


def test_every_flipped_bit_is_found(pack):
    rng = np.random.default_rng(0)
    for file in sorted(pack.iterdir()):
        content = file.read_bytes()
        for bit in rng.integers(0, 8 * len(content), 8):
            damaged = bytearray(content)
            damaged[bit // 8] ^= 1 << (bit % 8)
            file.write_bytes(damaged)
            refused(pack, ErrorCode.DAMAGED_PACK)
        file.write_bytes(content)
    verify_pack(pack)


def changed(path, value):
    def change(document):
        *way, last = path
        for key in way:
            document = document[key]
        document[last] = value

    return change


WRONG = [
    changed(["maps"], []),
    changed(["maps"], "albedo"),
    changed(["maps", 0, "name"], "../albedo"),
    changed(["maps", 0, "name"], "normal"),
    changed(["maps", 0, "encoding"], "linear"),
    changed(["maps", 0, "encoding"], []),
    changed(["maps", 0, "range"], [1, 0]),
    changed(["maps", 0, "range"], [0, 1e999]),
    changed(["maps", 0, "channels"], 5),
    changed(["maps", 1, "channels"], 3),
    changed(["maps", 1, "range"], [0, 1]),
    changed(["maps", 0, "surprise"], 1),
    changed(["maps", 0], ["albedo", "srgb", [0, 1], 3]),
    changed(["tiles"], []),
    changed(["tiles", 0, "number"], 1002),
    changed(["tiles", 0, "number"], 1000),
    changed(["tiles", 0, "number"], True),
    changed(["tiles", 0, "weight_size"], [1, 1]),
    changed(["tiles", 0, "weight_size"], [4, 4000]),
    changed(["tiles", 0, "weight_columns"], 0),
    changed(["tiles", 0, "weight_scale"], []),
    changed(["tiles", 0, "weight_scale"], [1, 1, 1]),
    changed(["tiles", 1, "weight_offset"], [0]),
    changed(["tiles", 0, "textures"], []),
    changed(["tiles", 0, "textures", 0, "size"], [32, 40000]),
    changed(["tiles", 0, "textures", 0, "size"], [32, 17]),
    changed(["tiles", 0, "textures", 0, "neutral_bits"], 12),
    changed(["tiles", 0, "textures", 1, "difference_scale"], [[1, 1, 1]] * 2),
    changed(["tiles", 0, "textures", 1, "difference_scale"], [[-1, 1]] * 2),
    changed(["uniform_weights"], [[1, 1]] * 3),
    changed(["expressions"], ["../../etc", "a", "b"]),
    changed(["vertices"], 2**24),
    changed(["files"], {}),
    changed(["surprise"], 1),
]


@pytest.mark.parametrize("change", WRONG, ids=range(len(WRONG)))
def test_a_well_signed_manifest_with_a_wrong_field_is_refused(pack, change):
    document = json.loads((pack / FILE_NAME).read_bytes())
    change(document)
    document["sha256"] = "0" * 64
    blank = json.dumps(document, indent=1).encode()
    (pack / FILE_NAME).write_bytes(blank.replace(b"0" * 64, sha256(blank).hexdigest().encode(), 1))
    refused(pack, ErrorCode.BAD_PACK)


def test_a_failed_write_leaves_the_old_pack_and_nothing_else(pack, small, monkeypatch):
    before = {file.name: file.read_bytes() for file in pack.iterdir()}

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("facezip.pack.version_2.write_meshes", full)
    with pytest.raises(FaceZipError, match="No space left"):
        write_pack(small, pack, overwrite=True)
    assert {file.name: file.read_bytes() for file in pack.iterdir()} == before
    assert [path.name for path in pack.parent.iterdir()] == [pack.name]
