"""Reading in a process of its own: decoders that crash, hang and take all memory cost their image alone."""

import signal
import tempfile

import numpy as np
import pytest

from facezip.character.examination import examine_character
from facezip.character.loading import save_character
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.apart import apart
from facezip.files.images import read_texture, write_texture
from tests.facezip.conftest import random_character
from tests.facezip.files.broken import end_at, mark, sums, surroundings

# Looks at a process that says nothing, of a second each: a busy machine takes longer than a decoder.
PATIENCE = 4
# Of addresses: Python with the image library takes a fifth of it.
ROOM = 3 * 2**30

WORDS = {b"crash": "crashed (SIGSEGV)", b"hangs": f"did not go on for {PATIENCE} s", b"grows": "crashed (SIGABRT)"}


@pytest.fixture
def images(tmp_path):
    files = [tmp_path / f"{n}.png" for n in range(5)]
    for n, file in enumerate(files):
        write_texture(file, np.full((8, 8, 3), n, np.uint8))
    return files


@pytest.fixture
def broken(tmp_path, monkeypatch):
    """Decoders of processes to come are broken, and what those leave behind is gone at the end."""
    for name, value in surroundings(tmp_path).items():
        monkeypatch.setenv(name, value)
    (tmp_path / "scratch").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "scratch"))
    yield
    assert [*(tmp_path / "scratch").iterdir()] == []


# Processes start one after the other, and two of those that hang are waited for.
@pytest.mark.parametrize("way", WORDS)
def test_an_image_that_ends_its_decoder_is_refused_alone(images, broken, way):
    mark(images[2], way)
    found = apart(sums, images, patience=PATIENCE, room=ROOM)
    assert found.pop("2.png") == f"{images[2]}: not a readable image (its decoder {WORDS[way]}); export it again"
    assert found == {f"{n}.png": 8 * 8 * 3 * n for n in (0, 1, 3, 4)}


def test_the_same_bytes_under_another_name_are_not_tried_again(images, broken):
    mark(images[1], b"crash")
    images[3].write_bytes(images[1].read_bytes())
    found = apart(sums, images)
    assert [name for name, said in found.items() if isinstance(said, str)] == ["1.png", "3.png"]


@pytest.mark.parametrize(
    ("number", "words"), [(signal.SIGKILL, "for memory"), (signal.SIGSEGV, r"SIGSEGV\), at .*0.png")]
)
def test_an_image_that_can_be_read_is_not_blamed(images, number, words):
    with pytest.raises(FaceZipError, match=words) as caught:
        apart(end_at, images[0], number)
    assert caught.value.code is ErrorCode.WORKER_LOST


def test_what_is_raised_comes_through(images):
    with pytest.raises(FaceZipError) as caught:
        apart(read_texture, images[0].with_name("none.png"))
    assert caught.value.code is ErrorCode.MISSING_FILE
    with pytest.raises(MemoryError, match="allocate"):
        apart(np.ones, (2**40,), room=ROOM)


# Four processes import all that reads a character.
def test_the_rest_of_a_character_is_examined_all_the_same(tmp_path, broken):
    scans = tmp_path / "scans"
    save_character(random_character(side=16, grid=3, expressions=4), scans)
    sound = examine_character(scans)
    assert apart(examine_character, scans) == sound
    mark(scans / "neutral.png", b"crash")
    mark(scans / "expr_1.png", b"crash")
    (scans / "expr_2.obj").write_bytes((scans / "expr_2.obj").read_bytes()[:100])
    found = apart(examine_character, scans)
    lost = ("neutral.png", "expr_1.png", "expr_2.obj")
    said = [refusal.words for refusal in found.refusals]
    assert [sum(name in words for words in said) for name in lost] == [1, 1, 1], said
    assert {row.file for row in found.rows} == {row.file for row in sound.rows} - {*lost}


def test_an_image_within_a_gltf_is_named_by_its_place(tmp_path, broken):
    head = tmp_path / "head.glb"
    save_character(random_character(side=16, grid=3, expressions=2), head)
    # The last five bytes of an image are a part of a checksum that no reader needs.
    head.write_bytes(head.read_bytes().replace(b"D\xaeB`\x82", b"crash", 1))
    (refusal,) = apart(examine_character, head).refusals
    assert refusal.words.startswith(f"{head}: image ")
    assert "its decoder crashed (SIGSEGV)" in refusal.words
