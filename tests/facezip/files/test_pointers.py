"""Files that Git LFS has not fetched are called that, whatever reads them."""

import os
from pathlib import Path

import pytest

from facezip.character.loading import load_character, save_character
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.images import read_texture
from facezip.files.obj import read_obj
from facezip.files.reading import is_pointer
from facezip.fit.methods import compress
from facezip.pack.read import read_pack
from facezip.pack.verification import verify_pack
from facezip.pack.write import write_pack
from scenes.character import make_character

POINTER = """version https://git-lfs.github.com/spec/v1
oid sha256:4d7a214614ab2935c943f9e0ff69d22eadbb8f32b1258daaa5e2ca24d17e2393
size 12345
"""


@pytest.fixture(scope="module")
def character():
    return make_character(64, 3)


def unfetched(path: Path) -> Path:
    path.write_text(POINTER)
    return path


def says_so(read, path: Path) -> None:
    with pytest.raises(FaceZipError) as caught:
        read()
    assert caught.value.code is ErrorCode.CANNOT_READ
    assert str(caught.value).endswith("git lfs pull'")
    assert str(path) in str(caught.value)


@pytest.mark.parametrize("name", ["a.png", "a.exr", "a.tga", "a.jpg", "a.tif"])
def test_an_image(tmp_path, name):
    path = unfetched(tmp_path / name)
    says_so(lambda: read_texture(path), path)


@pytest.mark.parametrize(("name", "read"), [("a.obj", read_obj), ("a.glb", load_character), ("a.gltf", load_character)])
def test_a_mesh(tmp_path, name, read):
    path = unfetched(tmp_path / name)
    says_so(lambda: read(path), path)


def test_a_file_of_scans(tmp_path, character):
    save_character(character, tmp_path / "scans")
    for path in sorted((tmp_path / "scans").iterdir()):
        before = path.read_bytes()
        unfetched(path)
        says_so(lambda: load_character(tmp_path / "scans"), path)
        path.write_bytes(before)


@pytest.mark.parametrize("read", [read_pack, verify_pack])
def test_a_file_of_a_pack(tmp_path, character, read):
    pack = tmp_path / "a.facezip"
    write_pack(compress(character), pack)
    for path in sorted(pack.iterdir()):
        before = path.read_bytes()
        unfetched(path)
        says_so(lambda: read(pack), path)
        path.write_bytes(before)


def test_a_pipe_in_the_place_of_a_file_is_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    assert not is_pointer(tmp_path / "pipe")
