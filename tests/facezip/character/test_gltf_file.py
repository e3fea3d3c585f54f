"""A character as one GLB: what is written reads back, what others write is found, what is damaged is refused."""

import json
import struct
from dataclasses import replace

import numpy as np
import pytest

from facezip import FaceZipError
from facezip.character.gltf import add_mesh, start
from facezip.character.gltf_textures import VARIANTS
from facezip.character.loading import load_character, save_character
from facezip.character.meshes import Meshes
from facezip.files.glb import Glb
from facezip.files.obj import Topology
from tests.facezip.conftest import grid_topology, random_character, with_albedo


@pytest.fixture
def scans():
    character = random_character(side=16, grid=5, expressions=3)
    mask = np.zeros((16, 16), np.float32)
    mask[2:14, 3:12] = 1
    return with_albedo(character, mask=mask)


@pytest.fixture
def file(scans, tmp_path):
    save_character(scans, tmp_path / "sheet.glb")
    return tmp_path / "sheet.glb"


def rewrite(file, change):
    """The same file with another JSON chunk."""
    glb = Glb.parse(file.read_bytes())
    change(glb.document)
    file.write_bytes(glb.to_bytes())


def same(a, b):
    np.testing.assert_array_equal(a.first.neutral, b.first.neutral)
    np.testing.assert_array_equal(a.first.textures, b.first.textures)
    np.testing.assert_array_equal(a.meshes.neutral, b.meshes.neutral)
    np.testing.assert_allclose(a.meshes.vertices, b.meshes.vertices, atol=1e-5)
    one, other = a.meshes.topology, b.meshes.topology
    np.testing.assert_array_equal(one.faces, other.faces)
    corners = one.uv[one.face_uv], other.uv[other.face_uv]
    np.testing.assert_allclose(*corners, atol=1e-6)
    assert a.expressions == b.expressions


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_a_character_reads_back(scans, tmp_path, dtype):
    wide = random_character(side=16, grid=5, expressions=3, dtype=dtype)
    scans = with_albedo(wide, mask=scans.first.mask)
    save_character(scans, tmp_path / "sheet.glb")
    back = load_character(tmp_path / "sheet.glb")
    same(back, scans)
    np.testing.assert_array_equal(back.first.mask, scans.first.mask)
    assert back.name == "sheet"
    assert [entry.name for entry in tmp_path.iterdir()] == ["sheet.glb"]


def test_float_textures_are_kept_to_16_bits(tmp_path):
    scans = random_character(side=16, grid=5, expressions=3, dtype=np.float32)
    save_character(scans, tmp_path / "sheet.glb")
    back = load_character(tmp_path / "sheet.glb")
    assert back.first.textures.dtype == np.uint16
    np.testing.assert_allclose(back.first.textures / 65535, scans.first.textures, atol=1 / 65535)


def test_seams_are_welded_again(scans, tmp_path):
    seam = scans.meshes.topology.face_uv.copy()
    seam[0, 0] = 24
    topology = replace(scans.meshes.topology, face_uv=seam)
    scans = replace(scans, meshes=replace(scans.meshes, topology=topology))
    save_character(scans, tmp_path / "sheet.glb")
    back = load_character(tmp_path / "sheet.glb")
    assert len(back.meshes.neutral) == len(scans.meshes.neutral)
    same(back, scans)


def test_gltf_transform_keeps_the_character_and_the_validator_finds_nothing(file, scans, tmp_path, node):
    assert node("validate.mjs", file)["messages"] == []
    node("transform.mjs", file, tmp_path / "out.glb")
    same(load_character(tmp_path / "out.glb"), scans)


def without_variants(document):
    del document["extensions"], document["extensionsUsed"]
    del document["meshes"][0]["primitives"][0]["extensions"]


@pytest.mark.parametrize("kind", ["materials", "textures", "images"])
def test_textures_are_found_by_the_names_of(file, scans, kind):
    def change(document):
        without_variants(document)
        for other in ("materials", "textures", "images"):
            for entry in document[other]:
                if other != kind:
                    entry.pop("name")
                elif kind == "images":
                    entry["name"] += ".png"

    rewrite(file, change)
    same(load_character(file), scans)


def test_textures_are_found_beside_the_file(file, scans, tmp_path):
    save_character(scans, tmp_path / "folder")
    for texture in (tmp_path / "folder").glob("*.png"):
        texture.rename(tmp_path / texture.name)

    def change(document):
        without_variants(document)
        for kind in ("materials", "textures", "images"):
            document.pop(kind)
        document["meshes"][0]["primitives"][0].pop("material")

    rewrite(file, change)
    same(load_character(file), scans)


def test_targets_may_be_whole_or_normalised_integers(file, scans):
    glb = Glb.parse(file.read_bytes())
    accessor = glb.document["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"]
    uv = glb.array(accessor)
    glb.document["accessors"][accessor] |= {"componentType": 5123, "normalized": True}
    view = glb.document["bufferViews"][glb.document["accessors"][accessor]["bufferView"]]
    short = np.rint(uv * 65535).astype("<u2").tobytes()
    content = bytearray(glb.binary)
    content[view["byteOffset"] : view["byteOffset"] + len(short)] = short
    file.write_bytes(Glb(glb.document, bytes(content)).to_bytes())
    back = load_character(file)
    corners = (
        back.meshes.topology.uv[back.meshes.topology.face_uv],
        scans.meshes.topology.uv[scans.meshes.topology.face_uv],
    )
    np.testing.assert_allclose(*corners, atol=1e-4)


def refused(file):
    with pytest.raises(FaceZipError) as caught:
        load_character(file)
    message = str(caught.value)
    assert "\n" not in message
    assert str(file) in message
    return message


def primitive(document):
    return document["meshes"][0]["primitives"][0]


FAULTS = {
    "no names": (lambda d: d["meshes"][0].pop("extras"), "no names"),
    "a name twice": (lambda d: d["meshes"][0]["extras"].update(targetNames=["a"] * 3), "no names"),
    "no targets": (lambda d: primitive(d).pop("targets"), "no mesh of it has morph targets"),
    "two meshes": (lambda d: d["meshes"].append(d["meshes"][0]), "'0/0', '1/0' may be the face"),
    "lines": (lambda d: primitive(d).update(mode=1), "triangles"),
    "compression": (lambda d: d.update(extensionsRequired=["KHR_draco_mesh_compression"]), "KHR_draco"),
    "a variant of another name": (
        lambda d: (without_variants(d), [d[kind][1].update(name="x") for kind in ("materials", "textures", "images")]),
        "'expr_0' has no texture",
    ),
    "a huge view": (lambda d: d["bufferViews"][0].update(byteLength=2**31), "past the end"),
    "a negative offset": (lambda d: d["bufferViews"][0].update(byteOffset=-4), "no count"),
    "a huge accessor": (lambda d: d["accessors"][0].update(count=2**31), "past the end"),
    "zeros without end": (
        lambda d: (d["accessors"][0].update(count=2**31), d["accessors"][0].pop("bufferView")),
        "holds none",
    ),
    "another file": (lambda d: d["buffers"][0].update(uri="../../secret.bin"), "outside of its folder"),
    "an image elsewhere": (lambda d: d["images"][0].update(uri="/etc/passwd", bufferView=None), "only files beside it"),
    "indices of no vertex": (lambda d: primitive(d).update(indices=0), "triangles"),
    "no material": (lambda d: d.update(materials=3), "materials"),
    "a flat node": (lambda d: d["nodes"][0].update(scale=[0, 0, 0]), "flattens"),
    "an image of text": (lambda d: d["images"][1].update(bufferView=0), "image"),
    "no UVs": (lambda d: primitive(d)["attributes"].pop("TEXCOORD_0"), "UV"),
    "a list": (lambda d: d.update(meshes="none"), ""),
}


@pytest.mark.parametrize("case", FAULTS)
def test_a_wrong_document_is_refused_in_one_line(file, case):
    change, words = FAULTS[case]
    rewrite(file, change)
    assert words in refused(file)


def test_every_damaged_file_reads_back_or_is_refused_in_one_line(file):
    """Bytes of geometry and of pictures may change unseen; whatever is changed, one kind of error is raised."""
    content, rng = file.read_bytes(), np.random.default_rng(0)
    length = 20 + struct.unpack_from("<I", content, 12)[0]
    messages = []
    for _ in range(150):
        damaged = bytearray(content)
        damaged[rng.integers(0, length)] = rng.integers(0, 256)
        file.write_bytes(damaged)
        try:
            load_character(file)
        except FaceZipError as error:
            messages.append(str(error))
    assert len(messages) > 10
    assert not any("\n" in message for message in messages)
    for cut in rng.integers(0, len(content), 50):
        file.write_bytes(content[:cut])
        refused(file)


def test_a_missing_file_and_json_of_the_wrong_kind(tmp_path):
    refused(tmp_path / "nobody.glb")
    text = json.dumps([1, 2]).encode().ljust(8)
    chunk = struct.pack("<I4s", len(text), b"JSON") + text
    (tmp_path / "list.glb").write_bytes(b"glTF" + struct.pack("<II", 2, 12 + len(chunk)) + chunk)
    assert "no object" in refused(tmp_path / "list.glb")


def test_a_failed_write_leaves_nothing(scans, tmp_path):
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(FaceZipError, match="cannot write"):
        save_character(scans, tmp_path / "file" / "sheet.glb")
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_variants_are_named_as_the_expressions(file, scans):
    document = Glb.parse(file.read_bytes()).document
    names = [variant["name"] for variant in document["extensions"][VARIANTS]["variants"]]
    assert names == [*scans.expressions, "mask"]


def test_a_tile_that_no_face_uses_has_no_primitive():
    topology = grid_topology(4)
    unused = Topology(topology.faces[:0], topology.uv, topology.face_uv[:0])
    vertices = np.random.default_rng(0).normal(size=(16, 3)).astype(np.float32)
    meshes = Meshes(topology, vertices, 1.1 * vertices[None])
    primitives = add_mesh(start("head"), "head", meshes, ("smile",), [unused, topology])
    assert [one["material"] for one in primitives] == [1]
