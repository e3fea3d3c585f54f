"""One scene is one character, in whatever form a glTF is stored; and what it refers to stays in its folder."""

import base64
import io
import json
from urllib.parse import quote_from_bytes

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from facezip import FaceZipError, load_character
from facezip.batch.finished import digest_of
from facezip.batch.jobs import find_jobs
from facezip.character.gltf_files import files_beside
from facezip.files.accessors import GlbFault
from facezip.files.links import Links, without_data
from tests.facezip.character.gltfs import FORMS, Scene, assert_same, corners, scans, words, write


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    return tmp_path_factory.mktemp("gltf")


@settings(deadline=None, max_examples=20)
@given(seed=st.integers(0, 1000), form=st.sampled_from(FORMS), dtype=st.sampled_from([np.uint8, np.uint16]))
def test_a_scene_is_the_same_character_in_every_form(place, seed, form, dtype):
    character = scans(seed, dtype=dtype)
    read = load_character(Scene(character).write(place, form))
    assert_same(read, character)
    assert not read.notes


@pytest.mark.parametrize("name", ["face.glb", "face.gltf", "face.vrm", "face.bin"])
def test_content_tells_a_binary_file_whatever_it_is_called(tmp_path, name):
    path = Scene(scans()).write(tmp_path).rename(tmp_path / name)
    assert_same(load_character(path), scans())


def test_a_byte_order_mark_and_escaped_slashes_change_nothing(tmp_path):
    path = Scene(scans()).write(tmp_path, "gltf, data in URIs")
    path.write_text("\ufeff" + path.read_text().replace("/", "\\/"), encoding="utf-8")
    assert_same(load_character(path), scans())


@settings(max_examples=50)
@given(st.recursive(st.text() | st.integers(), lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner)))
def test_documents_without_data_uris_are_left_alone(document):
    text = json.dumps(document).encode()
    assert '"data:' in text.decode() or without_data(text) == (text, [])


@given(st.binary(max_size=200), st.booleans())
def test_data_in_a_uri_comes_back(content, escaped):
    for uri in (f"data:;base64,{base64.b64encode(content).decode()}", f"data:x/y,{quote_from_bytes(content)}"):
        text = json.dumps({"uri": uri})
        rest, data = without_data((text.replace("/", "\\/") if escaped else text).encode())
        assert Links(None, data).content(json.loads(rest)["uri"]) == content


HOSTILE = [
    *("../secret.png", "%2e%2e/secret.png", "a/../../secret.png", "..\\secret.png", "link.png", "/etc/passwd"),
    *("file:///etc/passwd", "https://example.org/a.png", "C:\\secret.png", "", ".", "a%00.png", "missing.png"),
]


@pytest.mark.parametrize("uri", HOSTILE)
@pytest.mark.parametrize("what", ["images", "buffers"])
def test_nothing_outside_of_the_folder_is_read(tmp_path, uri, what):
    folder = tmp_path / "inside"
    folder.mkdir()
    path = Scene(scans()).write(folder, "gltf, files beside")
    secret = tmp_path / "secret.png"
    (folder / "picture 0.png").rename(secret)
    (folder / "link.png").symlink_to(secret)
    document = json.loads(path.read_text())
    document[what][0]["uri"] = uri
    path.write_text(json.dumps(document))
    with pytest.raises(FaceZipError, match=r"one \.glb with everything in it") as caught:
        load_character(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_pack_refers_to_no_file():
    with pytest.raises(GlbFault, match="another file"):
        Links().content("head.bin")


def test_a_folder_with_one_gltf_is_that_character(tmp_path):
    Scene(scans()).write(tmp_path, "gltf, files beside")
    read = load_character(tmp_path)
    assert_same(read, scans())
    assert read.name == tmp_path.name


def test_a_folder_with_several_asks_for_one(tmp_path):
    path = Scene(scans()).write(tmp_path)
    path.with_name("other.glb").write_bytes(path.read_bytes())
    with pytest.raises(FaceZipError, match=r"holds 'head\.glb', 'other\.glb'; give one of them"):
        load_character(tmp_path)


def test_another_file_is_no_missing_folder(tmp_path):
    (tmp_path / "face.fbx").write_bytes(b"Kaydara FBX Binary")
    with pytest.raises(FaceZipError, match=r"face\.fbx: \.fbx is no character; give a folder"):
        load_character(tmp_path / "face.fbx")


def test_a_batch_takes_every_gltf_and_no_pack(tmp_path):
    glb = Scene(scans()).glb()
    for name in ("anna", "bert", "cleo", "dora"):
        (tmp_path / name).mkdir()
    write(glb, tmp_path / "anna", "glb")
    write(glb, tmp_path / "bert", "gltf, files beside")
    write(glb, tmp_path / "cleo", "glb")
    (tmp_path / "cleo" / "manifest.json").touch()
    write(glb, tmp_path / "dora", "glb").rename(tmp_path / "emil.gltf")
    assert [job.name for job in find_jobs([tmp_path])] == ["anna", "bert", "emil"]
    (tmp_path / "character.toml").write_text('part = "head"')
    assert [job.name for job in find_jobs([tmp_path])] == ["anna", "bert", "emil"]


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("extra", ["neutral.png", "expr_1.jpg", "character.toml"])
def test_what_a_batch_takes_for_new_are_all_files_that_a_character_is_read_from(tmp_path, form, extra):
    path = Scene(scans()).write(tmp_path, form)
    (tmp_path / "notes.txt").write_text("of no effect")
    files = {file.name for file in tmp_path.iterdir()} - {path.name, "notes.txt"}
    assert {file.name for file in files_beside(path)} == files
    seen = {digest_of(path, {})}
    for name in (*files, extra, path.name):
        with open(tmp_path / name, "ab") as file:
            file.write(b" ")
        seen.add(digest_of(path, {}))
    assert len(seen) == 3 + len(files)


def test_an_image_that_is_called_otherwise_than_it_is(tmp_path):
    scene = Scene(scans())
    for image in scene.document["images"]:
        image["mimeType"] = "image/jpeg"
    assert_same(scene.read(tmp_path), scans())


@pytest.mark.parametrize("fallback", [False, True])
def test_webp_is_read(tmp_path, fallback):
    character, scene = scans(mask=False), Scene(scans(mask=False))
    every = [character.first.neutral, *character.first.textures]
    for texture, texels in zip(scene.document["textures"], every, strict=True):
        content = io.BytesIO()
        Image.fromarray(texels).save(content, "WEBP", lossless=True)
        source = scene.builder.image("", content.getvalue(), "image/webp")
        texture["extensions"] = {"EXT_texture_webp": {"source": source}}
        if not fallback:
            texture.pop("source")
    scene.document["extensionsRequired"] = ["EXT_texture_webp"]
    assert_same(scene.read(tmp_path), character)


def unread(scene, name):
    for texture in scene.document["textures"]:
        texture["extensions"] = {name: {"source": texture.pop("source")}}


def packed(scene, name):
    for view in scene.document["bufferViews"]:
        view["extensions"] = {name: {"buffer": 0}}
        view["buffer"] = 1


def draco(scene, name):
    scene.face["extensions"] = {name: {"bufferView": 0}}
    scene.document["accessors"][scene.face["attributes"]["POSITION"]].pop("bufferView")


REFUSED = {
    "KHR_texture_basisu": (unread, "PNG or JPEG"),
    "MSFT_texture_dds": (unread, "PNG or JPEG"),
    "EXT_meshopt_compression": (packed, "uncompressed"),
    "KHR_draco_mesh_compression": (draco, "uncompressed"),
    "KHR_unheard_of": (lambda scene, name: None, "export it without"),
}


@pytest.mark.parametrize("name", REFUSED)
@pytest.mark.parametrize("required", [False, True])
def test_what_is_not_read_is_refused_by_its_name(tmp_path, name, required):
    change, remedy = REFUSED[name]
    scene = Scene(scans())
    change(scene, name)
    scene.document["extensionsUsed"] = [name]
    if required:
        scene.document["extensionsRequired"] = [name]
    elif name == "KHR_unheard_of":
        return
    glb = scene.glb()
    glb.document["buffers"].append({"byteLength": 2**20})
    path = write(glb, tmp_path, "glb")
    with pytest.raises(FaceZipError, match=f"{name}.*{remedy}"):
        load_character(path)


def test_the_first_version_is_refused_by_its_number(tmp_path):
    scene = Scene(scans())
    scene.document["asset"]["version"] = "1.0"
    with pytest.raises(FaceZipError, match=r"glTF 1\.0; 2\.0 is read"):
        scene.read(tmp_path)


@pytest.mark.parametrize("mode", [5, 6])
def test_strips_and_fans_are_the_triangles_that_they_are(tmp_path, mode):
    scene = Scene(scans())
    count = scene.document["accessors"][scene.face["attributes"]["POSITION"]]["count"]
    scene.face.update(mode=mode, indices=scene.builder.array(np.arange(count, dtype=np.uint16)[:, None]))
    expected = [(i, i + 1 + i % 2, i + 2 - i % 2) if mode == 5 else (i + 1, i + 2, 0) for i in range(count - 2)]
    whole = corners(scans())[0].reshape(3, -1, 3)
    read = scene.read(tmp_path)
    np.testing.assert_allclose(corners(read)[0], whole[:, expected], rtol=0, atol=1e-6)
    assert not words(read)
