"""What lies on the disk is what was written: a hole, a cut or another byte is found."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from facezip.errors import ErrorCode, FaceZipError
from facezip.files.arrival import has_arrived
from facezip.files.images import read_texture, write_texture, write_values

TEXELS = np.random.default_rng(0).integers(0, 256, (24, 40, 3), np.uint8)
VALUES = np.random.default_rng(1).normal(size=(24, 40)).astype(np.float32)


def rows(texels):
    return lambda top, bottom: texels[top:bottom]


@pytest.fixture(scope="module", params=["png", "tif", "exr"])
def written(request, tmp_path_factory):
    path = tmp_path_factory.mktemp("written") / f"image.{request.param}"
    if request.param == "exr":
        write_values(path, VALUES)
        return path, rows(VALUES[:, :, None])
    write_texture(path, TEXELS)
    return path, rows(TEXELS)


def test_a_whole_image_has_arrived(written):
    assert has_arrived(*written)


@given(where=st.floats(0, 1, exclude_max=True))
def test_an_image_that_was_cut_off_has_not(written, tmp_path_factory, where):
    path, band = written
    content = path.read_bytes()
    cut = tmp_path_factory.mktemp("cut") / path.name
    cut.write_bytes(content[: int(where * len(content))])
    assert not has_arrived(cut, band)


@given(where=st.floats(0, 1, exclude_max=True), length=st.integers(1, 4096))
def test_a_png_without_some_of_its_bytes_has_not(tmp_path_factory, where, length):
    path = tmp_path_factory.mktemp("hole") / "image.png"
    write_texture(path, TEXELS)
    content = path.read_bytes()
    start = int(where * len(content))
    path.write_bytes(content[:start] + content[start + length :])
    # Chunks that hold no pixels may be missed.
    assert not has_arrived(path, rows(TEXELS)) or np.array_equal(read_texture(path), TEXELS)


def test_a_fourth_number_is_no_alpha(tmp_path):
    values = np.random.default_rng(2).normal(size=(24, 40, 4)).astype(np.float32)
    write_values(tmp_path / "four.exr", values)
    assert has_arrived(tmp_path / "four.exr", rows(values))


def test_floats_that_are_none_arrive_too(tmp_path):
    values = np.full((4, 4), np.nan, np.float32)
    write_values(tmp_path / "nan.exr", values)
    assert has_arrived(tmp_path / "nan.exr", rows(values[:, :, None]))


def test_what_has_not_arrived_is_an_error(tmp_path, monkeypatch):
    monkeypatch.setattr("facezip.files.images.has_arrived", lambda *_: False)
    with pytest.raises(FaceZipError, match="the disk refused a part of it") as refused:
        write_texture(tmp_path / "image.png", TEXELS)
    assert refused.value.code is ErrorCode.CANNOT_WRITE
