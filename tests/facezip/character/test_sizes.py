"""Sizes: a placeholder is the constant that it is, and everything else has to be of one size."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facezip import ErrorCode, FaceZipError
from facezip.character.loading import load_character, save_character
from facezip.character.maps import angles
from facezip.character.sizes import LEAST_SIDE
from facezip.files.images import write_texture
from tests.facezip.conftest import random_character
from tests.facezip.surfaces import random_surface

SIDES = st.tuples(st.integers(1, 9), st.integers(1, 9))
NAMES = ("neutral", "expr_0", "expr_1")


@pytest.fixture(scope="module")
def scans(tmp_path_factory):
    """A function that writes a character of albedo and roughness of 16 texels into a new folder."""
    character = random_surface(expressions=2, side=16, maps=("roughness",))

    def write():
        folder = tmp_path_factory.mktemp("scans") / "scans"
        save_character(character, folder)
        return folder

    return write


def refused(folder):
    with pytest.raises(FaceZipError) as caught:
        load_character(folder)
    assert caught.value.code is ErrorCode.SIZE_MISMATCH
    return str(caught.value)


@settings(max_examples=12, deadline=None)
@given(SIDES, st.sets(st.sampled_from(NAMES), min_size=1), st.integers(0, 255), st.sampled_from([1, 3]), st.booleans())
def test_placeholders_of_any_size_are_constants_of_the_right_size(scans, size, names, value, channels, is_wide):
    folder = scans()
    kind, most = (np.uint16, 65535) if is_wide else (np.uint8, 255)
    for name in names:
        write_texture(folder / f"{name}.roughness.png", np.full((*size, channels), value * most // 255, kind))
    found = load_character(folder)
    plain = load_character(scans())
    stack = found.stacks["roughness", 1001]
    # A whole map that is small, and large enough to be one, is no placeholder.
    is_map = len(names) == len(NAMES) and min(size) >= LEAST_SIDE
    assert stack.resolution == (size if is_map else (16, 16))
    for name in NAMES:
        texture = found.texture(name, "roughness")
        expected = value / 255 if name in names else plain.texture(name, "roughness")
        np.testing.assert_allclose(texture, np.broadcast_to(expected, texture.shape), atol=1e-4)
    assert {note.file for note in found.notes} == {f"{name}.roughness.png" for name in names if not is_map}
    assert all(note.asks == (len(names) < 3) for note in found.notes)


@settings(max_examples=10, deadline=None)
@given(SIDES, st.sampled_from(NAMES))
def test_a_placeholder_of_the_albedo_has_its_channels_and_asks(scans, size, name):
    folder = scans()
    write_texture(folder / f"{name}.png", np.full((*size, 1), 51, np.uint8))
    found = load_character(folder)
    np.testing.assert_allclose(found.texture(name), np.full((16, 16, 3), 0.2), atol=1e-6)
    assert [(note.file, note.asks) for note in found.notes] == [(f"{name}.png", True)]


def test_flat_normals_of_a_texel_are_flat_everywhere(scans):
    folder = scans()
    for name in NAMES:
        write_texture(folder / f"{name}.normal.png", np.array([[[128, 128, 255]]], np.uint8))
    found = load_character(folder).texture("expr_1", "normal")
    assert found.shape == (16, 16, 3)
    assert angles(found, np.broadcast_to(np.float32([0, 0, 1]), found.shape)).max() < 0.5


@settings(max_examples=15, deadline=None)
@given(SIDES.filter(lambda size: size[0] * size[1] > 1), st.sampled_from(NAMES), st.sampled_from([".roughness", ""]))
def test_a_texture_of_another_size_that_is_none_is_refused_by_its_name(scans, size, name, map):
    folder = scans()
    write_texture(folder / f"{name}{map}.png", np.arange(size[0] * size[1], dtype=np.uint8).reshape(*size, 1))
    message = refused(folder)
    assert ".png" in message
    assert f"{size[1]}x{size[0]}" in message


@pytest.mark.parametrize("size", [(1, 1), (2, 2), (1, 3), (3, 64)])
def test_an_albedo_of_a_few_texels_is_no_texture(scans, size):
    folder = scans()
    for name in NAMES:
        write_texture(folder / f"{name}.png", np.full((*size, 3), 100, np.uint8))
    assert f"neutral.png: {size[1]}x{size[0]} texels, too small" in refused(folder)


def test_a_mask_of_a_texel_is_that_everywhere(tmp_path):
    save_character(random_character(expressions=2, side=16), tmp_path / "scans")
    write_texture(tmp_path / "scans" / "mask.png", np.full((1, 1, 1), 255, np.uint8))
    found = load_character(tmp_path / "scans")
    assert (found.first.mask == 1).all()
    assert [note.file for note in found.notes] == ["mask.png"]


def test_what_is_done_to_an_image_is_in_the_notes(scans):
    from PIL import Image

    folder = scans()
    for name in NAMES:
        texels = np.asarray(Image.open(folder / f"{name}.png"))
        (folder / f"{name}.png").unlink()
        exif = Image.Exif()
        exif[274] = 3
        Image.fromarray(np.ascontiguousarray(texels[::-1, ::-1])).save(folder / f"{name}.tif", exif=exif)
    found = load_character(folder)
    np.testing.assert_array_equal(found.first.textures, load_character(scans()).first.textures)
    assert {(note.file, note.words, note.asks) for note in found.notes} == {
        (f"{name}.tif", "turned upright (orientation 3)", False) for name in NAMES
    }
