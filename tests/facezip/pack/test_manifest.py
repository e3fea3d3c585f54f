"""Manifests of all versions: a field that is not as it may be is refused, however well the file is signed."""

import json
import shutil
from dataclasses import replace
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest

from facezip import ErrorCode, FaceZipError, compress
from facezip.files.packs import MANIFEST, is_pack
from facezip.pack.parsing import read_manifest
from facezip.pack.read import read_pack
from facezip.pack.verification import stored, verify_pack
from facezip.pack.write import write_pack
from tests.facezip.conftest import random_model
from tests.facezip.surfaces import random_surface

DATA = Path(__file__).parents[2] / "data"


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    surface = random_surface(maps=("normal",), side=32, expressions=3, tiles=(2, 1))
    path = tmp_path_factory.mktemp("packs") / "me.facezip"
    write_pack(compress(surface, differences=2), path)
    return path


@pytest.fixture
def pack(whole, tmp_path):
    return shutil.copytree(whole, tmp_path / "me.facezip")


def sign(pack, document):
    """Write a manifest with a right checksum of its own, and right checksums of all files that it names."""
    for name, entry in document["files"].items() if isinstance(document["files"], dict) else ():
        if (pack / name).is_file() and isinstance(entry, dict):
            entry |= vars(stored(pack / name))
    blank = json.dumps(document | {"sha256": "0" * 64}, indent=1).encode()
    (pack / MANIFEST).write_bytes(blank.replace(b"0" * 64, sha256(blank).hexdigest().encode(), 1))


def refused(pack, code=ErrorCode.BAD_PACK):
    with pytest.raises(FaceZipError) as caught:
        read_pack(pack)
    assert caught.value.code is code
    assert "\n" not in str(caught.value)
    return str(caught.value)


def changed(*path_and_value):
    *path, value = path_and_value

    def change(document):
        *way, last = path
        for key in way:
            document = document[key]
        document[last] = value

    return change


WRONG = [
    changed("name", "two\nlines"),
    changed("method", ""),
    changed("maps", []),
    changed("maps", "albedo"),
    changed("maps", 0, "name", "../albedo"),
    changed("maps", 0, "name", "normal"),
    changed("maps", 0, "encoding", "linear"),
    changed("maps", 0, "encoding", []),
    changed("maps", 0, "range", [1, 0]),
    changed("maps", 0, "range", [0, 1e999]),
    changed("maps", 0, "channels", 5),
    changed("maps", 1, "channels", 3),
    changed("maps", 1, "range", [0, 1]),
    changed("maps", 0, "surprise", 1),
    changed("maps", 0, ["albedo", "srgb", [0, 1], 3]),
    changed("tiles", []),
    changed("tiles", 0, "number", 1002),
    changed("tiles", 0, "number", 1000),
    changed("tiles", 0, "number", True),
    changed("tiles", 0, "weight_size", [1, 1]),
    changed("tiles", 0, "weight_size", [4, 4000]),
    changed("tiles", 0, "weight_columns", 0),
    changed("tiles", 0, "weight_span", []),
    changed("tiles", 0, "weight_span", [1, 1, 1]),
    changed("tiles", 0, "weight_span", [1, -1]),
    changed("tiles", 1, "weight_offset", [0]),
    changed("tiles", 0, "weights", []),
    changed("tiles", 0, "weights", ["weights.1002.png"]),
    changed("tiles", 0, "textures", []),
    changed("tiles", 0, "textures", 0, "size", [32, 40000]),
    changed("tiles", 0, "textures", 0, "size", [32, 17]),
    changed("tiles", 0, "textures", 0, "size", "24x40"),
    changed("tiles", 0, "textures", 0, "neutral_bits", 12),
    changed("tiles", 0, "textures", 0, "neutral", "../secret.png"),
    changed("tiles", 0, "textures", 0, "neutral", 3),
    changed("tiles", 0, "textures", 0, "neutral", "manifest.json"),
    changed("tiles", 0, "textures", 0, "differences", ["albedo.1001.difference_0.png"] * 2),
    changed("tiles", 0, "textures", 1, "difference_span", [[1, 1, 1]] * 2),
    changed("tiles", 0, "textures", 1, "difference_span", [[-1, 1]] * 2),
    changed("tiles", 0, "textures", 1, "difference_span", [[1e999, 1]] * 2),
    changed("uniform_weights", [[1, 1]] * 3),
    changed("expressions", ["../../etc", "a", "b"]),
    changed("expressions", ["a", "a", "b"]),
    changed("expressions", ["a", "b"]),
    changed("geometry", "vertices", 2**25),
    changed("geometry", "vertices", 80),
    changed("geometry", "triangles", 127),
    changed("geometry", "files", []),
    changed("geometry", None),
    changed("geometry", "surprise"),
    changed("made_with", 3),
    changed("files", {}),
    changed("files", {"../secret": {"bytes": 1, "sha256": "0"}}),
    changed("surprise", 1),
]


@pytest.mark.parametrize("change", WRONG, ids=range(len(WRONG)))
def test_a_well_signed_manifest_with_a_wrong_field_is_refused(pack, change):
    document = json.loads((pack / MANIFEST).read_bytes())
    change(document)
    sign(pack, document)
    refused(pack)


@pytest.mark.parametrize("field", ["name", "maps", "tiles", "geometry", "files"])
def test_a_field_that_is_missing_is_named(pack, field):
    document = json.loads((pack / MANIFEST).read_bytes())
    del document[field]
    if field != "files":
        sign(pack, document)
        assert field in refused(pack)


def test_a_key_that_stands_there_twice_is_refused(pack):
    text = (pack / MANIFEST).read_text().replace('"method":', '"method": "refined",\n "method":', 1)
    blank = text.replace(text.split('"')[3], "0" * 64, 1).encode()
    (pack / MANIFEST).write_bytes(blank.replace(b"0" * 64, sha256(blank).hexdigest().encode(), 1))
    assert "twice" in refused(pack)


def test_a_version_of_the_future_is_told_so(pack):
    document = json.loads((pack / MANIFEST).read_bytes())
    sign(pack, document | {"format": "facezip-pack/99"})
    assert "update facezip" in refused(pack, ErrorCode.OTHER_FORMAT)


OF_VERSION_1 = [
    changed("size", [24, 40000]),
    changed("channels", 99),
    changed("difference_scale", [[1e999, 1, 1]] * 4),
    changed("difference_scale", "none"),
    changed("weight_offset", [0]),
    changed("weight_columns", 0),
    changed("uniform_weights", [[1, 1, 1, 1]] * 5),
    changed("encoding", "linear"),
    changed("vertices", 0),
    changed("vertices", "many"),
    changed("texture_coordinates", 2**24),
    changed("geometry", None),
    changed("surprise", 1),
]
OF_VERSION_2 = [
    changed("maps", 0, "name", "normal"),
    changed("tiles", 0, "weight_scale", []),
    changed("tiles", 0, "weight_span", [1, 1, 1, 1]),
    changed("tiles", 0, "textures", 0, "difference_scale", [[1, 1]] * 4),
    changed("tiles", 0, "textures", 0, "neutral", "neutral.png"),
    changed("tiles", 0, "textures", []),
    changed("tiles", 3),
    changed("vertices", 2**24),
    changed("surprise", 1),
]
OLD = [*(("pack-1", change) for change in OF_VERSION_1), *(("pack-2", change) for change in OF_VERSION_2)]


@pytest.mark.parametrize(("version", "change"), OLD, ids=range(len(OLD)))
def test_a_wrong_field_of_an_old_version_is_refused(tmp_path, version, change):
    pack = shutil.copytree(DATA / version / "golden.facezip", tmp_path / "me.facezip")
    document = json.loads((pack / MANIFEST).read_bytes())
    change(document)
    sign(pack, document)
    refused(pack)


@pytest.mark.parametrize("version", ["pack-1", "pack-2"])
def test_deltas_of_an_old_version_have_to_be_finite(tmp_path, version):
    pack = shutil.copytree(DATA / version / "golden.facezip", tmp_path / "me.facezip")
    deltas = np.fromfile(pack / "deltas.f32", "<f4")
    deltas[7] = np.inf
    deltas.tofile(pack / "deltas.f32")
    sign(pack, json.loads((pack / MANIFEST).read_bytes()))
    assert "finite" in refused(pack)


@pytest.mark.parametrize("path", sorted(DATA.glob("*/*.facezip")), ids=lambda path: path.parent.name)
def test_the_footprint_counts_what_a_reader_gets(path):
    manifest, model = read_manifest(path), read_pack(path)
    footprint = manifest.footprint
    first = model.parts["albedo", manifest.tiles[0].number]
    assert footprint.differences == len(first.differences)
    assert footprint.expressions == len(model.expressions)
    assert footprint.masks == (0 if model.masked is None else len(model.masked.names))
    assert footprint.geometry == sum((path / name).stat().st_size for name in manifest.geometry.files)
    sizes = [(texture.height, texture.width, texture.channels) for texture in footprint.tiles[0]]
    assert sizes[0] == first.neutral.shape


def test_a_pack_without_meshes_costs_none(tmp_path):
    write_pack(random_model(), tmp_path / "me.facezip")
    assert read_manifest(tmp_path / "me.facezip").footprint.geometry == 0


def test_a_name_of_64_zeros_and_one_of_any_script_stand_there_as_they_are(tmp_path):
    """The field of the checksum is filled in once, and names are UTF-8."""
    made_with = {"by": "0" * 64}
    write_pack(random_model(), tmp_path / "me.facezip", name="Ærøskøbing 顔", made_with=made_with)
    manifest = verify_pack(tmp_path / "me.facezip")
    assert manifest.made_with == made_with
    assert "Ærøskøbing 顔".encode() in (tmp_path / "me.facezip" / MANIFEST).read_bytes()


def test_a_tile_that_lacks_a_map_is_no_shorter_list(whole):
    manifest = read_manifest(whole)
    tile = replace(manifest.tiles[0], textures=manifest.tiles[0].textures[:1])
    with pytest.raises(ValueError, match="shorter"):
        replace(manifest, tiles=(tile,)).entries()
    with pytest.raises(ValueError, match="shorter"):
        _ = replace(manifest, tiles=(tile,)).footprint


def seal(pack, content):
    """Write these bytes with a right checksum."""
    blank = content.replace(content.split(b'"')[3], b"0" * 64, 1)
    (pack / MANIFEST).write_bytes(blank.replace(b"0" * 64, sha256(blank).hexdigest().encode(), 1))


def test_a_manifest_of_2_mib_is_read_and_a_longer_one_is_not(pack):
    content = (pack / MANIFEST).read_bytes()
    seal(pack, content.ljust(2 * 2**20))
    verify_pack(pack)
    seal(pack, content.ljust(2 * 2**20 + 1))
    assert "larger than 2097152 bytes" in refused(pack)


@pytest.mark.parametrize("number", ["1e999", "-1e999", "NaN", "Infinity"])
def test_numbers_are_finite_also_where_nobody_reads_them(pack, number):
    content = (pack / MANIFEST).read_bytes()
    seal(pack, content.replace(b'"made_with": {}', b'"made_with": {"steps": [1, %s]}' % number.encode()))
    assert "finite" in refused(pack)


def test_half_a_pair_is_no_character_and_a_whole_one_is(pack):
    content = (pack / MANIFEST).read_bytes()
    for text, inside in ((rb"\ud83d\ude00", True), (rb"\uD83D", False), (rb"\ude00", False)):
        seal(pack, content.replace(b'"made_with": {}', b'"made_with": {"by": "%s"}' % text))
        if inside:
            assert verify_pack(pack).made_with["by"] == "😀"
        else:
            assert "surrogates" in refused(pack)


def test_a_pack_without_a_name_is_called_as_its_folder(pack):
    document = json.loads((pack / MANIFEST).read_bytes())
    sign(pack, document | {"name": ""})
    assert read_manifest(pack).name == "me"
    sign(pack, document | {"name": "you"})
    assert read_manifest(pack).name == "you"


def test_names_of_old_packs_are_read_in_one_form(pack):
    document = json.loads((pack / MANIFEST).read_bytes())
    sign(pack, document | {"expressions": ["a\N{COMBINING RING ABOVE}", "b", "c"]})
    assert read_manifest(pack).expressions == ("å", "b", "c")


def test_a_folder_looks_like_a_pack_by_the_first_bytes_of_its_manifest(pack):
    content = (pack / MANIFEST).read_bytes()
    for start, found in ((content, True), (content[:120], True), (content[:90], False), (b" " + content, False)):
        (pack / MANIFEST).write_bytes(start)
        assert is_pack(pack) is found
    (pack / MANIFEST).rename(pack / "elsewhere.json")
    assert is_pack(pack) is False
    (pack / "elsewhere.json").write_bytes(content)
    (pack / MANIFEST).symlink_to(pack / "elsewhere.json")
    assert is_pack(pack) is False


def test_a_pack_that_is_not_there_and_a_folder_without_a_manifest_are_told_apart(pack):
    refused(pack / "nowhere", ErrorCode.MISSING_FILE)
    (pack / MANIFEST).rename(pack / "elsewhere.json")
    refused(pack)
    (pack / MANIFEST).symlink_to(pack / "elsewhere.json")
    refused(pack)
    (pack / MANIFEST).unlink()
    (pack / MANIFEST).mkdir()
    refused(pack)
