"""Masks that somebody gives: how they come to the grid of the weight maps, and how a folder holds them."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given as examples
from hypothesis import settings
from hypothesis import strategies as st

from facezip import ErrorCode, FaceZipError
from facezip.files.images import write_texture, write_values
from facezip.fit.given import GivenMasks, resampled
from facezip.fit.mask_folder import read_masks
from tests.facezip.surfaces import write_floats

sides = st.integers(1, 40)
RANDOM = np.random.default_rng(0).integers(0, 256, (6, 10, 4), np.uint8)


def of_images(**images):
    return GivenMasks(tuple(images), {(name, 1001): image.astype(np.float32) for name, image in images.items()})


def write(folder, **images):
    folder.mkdir(exist_ok=True)
    for name, texels in images.items():
        write_texture(folder / f"{name.replace('__', '.')}.png", texels)
    return folder


@settings(deadline=None, max_examples=50)
@examples(height=sides, width=sides, h=sides, w=sides, value=st.floats(0, 1, width=32))
def test_a_constant_mask_stays_so_at_any_size(height, width, h, w, value):
    np.testing.assert_allclose(resampled(np.full((height, width), value, np.float32), (h, w)), value, atol=1e-6)


def test_a_mask_of_the_grids_own_size_stays_as_it_is():
    mask = RANDOM[..., 0] / np.float32(255)
    grids = of_images(a=mask).on_grids({1001: (6, 10)})
    np.testing.assert_array_equal(grids[1001][0], RANDOM[..., 0])


def test_a_larger_mask_is_averaged_over_each_texel():
    mask = np.random.default_rng(1).random((24, 40)).astype(np.float32)
    means = mask.reshape(6, 4, 10, 4).mean(axis=(1, 3))
    np.testing.assert_allclose(resampled(mask, (6, 10)), means, atol=1e-6)


def test_masks_may_be_made_to_sum_to_one_and_are_left_as_they_are_otherwise():
    overlapping = of_images(a=np.full((4, 4), 0.8), b=np.eye(4), c=np.full((4, 4), 0.2))
    plain, shared = (replace(overlapping, sum_to_one=one).on_grids({1001: (4, 4)})[1001] for one in (False, True))
    np.testing.assert_array_equal(plain[0], np.rint(0.8 * 255))
    np.testing.assert_allclose(shared.sum(axis=0, dtype=int), 255, atol=2)
    np.testing.assert_array_equal(shared[1] > 0, np.eye(4) > 0)


def test_a_mask_is_black_on_tiles_that_have_none_of_it():
    images = {("a", 1001): np.ones((2, 2), np.float32), ("b", 1002): np.ones((2, 2), np.float32)}
    grids = GivenMasks(("a", "b"), images).on_grids({1001: (2, 2), 1002: (3, 3)})
    assert (grids[1001][0] == 255).all()
    assert (grids[1001][1] == 0).all()
    assert grids[1002].shape == (2, 3, 3)


@pytest.mark.parametrize(
    ("masks", "words", "code"),
    [
        (of_images(a=np.zeros((4, 4))), "black", ErrorCode.BAD_TEXELS),
        (GivenMasks(("a",), {("a", 1003): np.ones((2, 2), np.float32)}), "1003", ErrorCode.UNKNOWN_NAME),
    ],
    ids=["black", "another tile"],
)
def test_masks_that_fit_no_grid_are_refused(masks, words, code):
    with pytest.raises(FaceZipError, match=words) as caught:
        masks.on_grids({1001: (2, 2)})
    assert caught.value.code is code


@pytest.mark.parametrize("layers", [{"a": (3,)}, {"a": (-1,)}, {"a": ()}, {"a": (0,), "b": (0, 1)}])
def test_layers_have_to_be_there_and_to_be_used(layers):
    masks = replace(of_images(a=np.ones((2, 2)), b=np.ones((2, 2))), layers=layers)
    with pytest.raises(FaceZipError, match="layer"):
        masks.allowed(3)


def test_a_mask_that_no_layer_is_named_for_acts_in_all():
    masks = replace(of_images(a=np.ones((2, 2)), b=np.ones((2, 2))), layers={"a": (1,)})
    np.testing.assert_array_equal(masks.allowed(2), [[False, True], [True, True]])


def test_a_folder_holds_one_image_a_mask_by_name_and_tile(tmp_path):
    one, other, third = RANDOM[..., :1], RANDOM[..., 1:2], RANDOM[:3, :5, 2:3]
    folder = write(tmp_path / "masks", brow__l=one, cheek__1002=other, cheek=third)
    (folder / "notes.txt").write_text("hello")
    (folder / ".hidden.png").write_bytes(b"no image")
    masks = read_masks(folder)
    assert masks.names == ("brow.l", "cheek")
    assert {*masks.images} == {("brow.l", 1001), ("cheek", 1001), ("cheek", 1002)}
    np.testing.assert_allclose(masks.images["cheek", 1002], other[..., 0] / 255, atol=1e-6)
    assert not masks.nonnegative
    assert not masks.sum_to_one


@pytest.mark.parametrize("suffix", ["png", "tif", "exr"])
def test_any_format_holds_a_mask(tmp_path, suffix):
    (tmp_path / "masks").mkdir()
    file = tmp_path / "masks" / f"a.{suffix}"
    if suffix == "exr":
        write_values(file, RANDOM[..., 0] / np.float32(255))
    else:
        write_texture(file, RANDOM[..., :1])
    np.testing.assert_allclose(read_masks(file.parent).images["a", 1001], RANDOM[..., 0] / 255, atol=1e-6)


def test_channels_of_an_image_are_masks_where_they_are_named(tmp_path):
    folder = write(tmp_path / "masks", regions=RANDOM, regions__1002=RANDOM[::-1])
    (folder / "masks.toml").write_text('[channels]\nregions = ["brow", "", "lip", "chin"]\n')
    masks = read_masks(folder)
    assert masks.names == ("brow", "lip", "chin")
    for name, channel in (("brow", 0), ("lip", 2), ("chin", 3)):
        np.testing.assert_allclose(masks.images[name, 1001], RANDOM[..., channel] / 255, atol=1e-6)
        np.testing.assert_allclose(masks.images[name, 1002], RANDOM[::-1, :, channel] / 255, atol=1e-6)


def test_what_masks_toml_says_holds(tmp_path):
    folder = write(tmp_path / "masks", a=RANDOM[..., :1], b=RANDOM[..., 1:2])
    (folder / "masks.toml").write_text('activations = "0..1"\nsum_to_one = true\n[layers]\nb = [0, 2]\n')
    masks = read_masks(folder)
    assert masks.nonnegative
    assert masks.sum_to_one
    assert masks.layers == {"b": (0, 2)}


def test_the_order_of_masks_does_not_depend_on_the_file_system(tmp_path):
    one = write(tmp_path / "one", b=RANDOM[..., :1], a=RANDOM[..., 1:2])
    other = write(tmp_path / "other", a=RANDOM[..., 1:2], b=RANDOM[..., :1])
    assert read_masks(one).names == read_masks(other).names == ("a", "b")


SAID = {
    "no TOML": ("activations =", "TOML"),
    "an unknown field": ("clamp = true", "clamp"),
    "an unknown range": ('activations = "0..2"', "activations"),
    "a number for a truth": ("sum_to_one = 1", "sum_to_one"),
    "a list for a table": ("layers = [0]", "layers"),
    "a layer that is no number": ('[layers]\na = ["0"]', "layers"),
    "a truth for a layer": ("[layers]\na = [true]", "layers"),
    "layers of a mask that there is not": ("[layers]\nz = [0]", "no mask 'z'"),
    "more channels than there are": ('[channels]\na = ["r", "g"]', "names 2"),
    "a name twice": ('[channels]\na = ["b"]', "second image"),
    "a name that no file may have": ('[channels]\na = ["../x"]', "rename"),
}


@pytest.mark.parametrize(("said", "words"), SAID.values(), ids=SAID)
def test_what_masks_toml_may_not_say_is_refused_in_one_line(tmp_path, said, words):
    folder = write(tmp_path / "masks", a=RANDOM[..., :1], b=RANDOM[..., 1:2])
    (folder / "masks.toml").write_text(said + "\n")
    with pytest.raises(FaceZipError, match=words) as caught:
        read_masks(folder)
    assert str(folder) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_folders_that_hold_no_masks_are_refused(tmp_path):
    for folder in (tmp_path / "nowhere", write(tmp_path / "empty")):
        with pytest.raises(FaceZipError) as caught:
            read_masks(folder)
        assert caught.value.code is ErrorCode.MISSING_FILE


def test_channels_that_differ_need_names(tmp_path):
    folder = write(tmp_path / "masks", regions=RANDOM[..., :3])
    with pytest.raises(FaceZipError, match=r"\[channels\] in masks\.toml"):
        read_masks(folder)


def test_an_image_of_a_kind_that_is_not_read_is_named(tmp_path):
    folder = write(tmp_path / "masks", a=RANDOM[..., :1])
    (folder / "b.psd").write_bytes(b"8BPS")
    with pytest.raises(FaceZipError, match=r"b\.psd"):
        read_masks(folder)


def test_values_beyond_1_are_refused(tmp_path):
    (tmp_path / "masks").mkdir()
    write_floats(tmp_path / "masks" / "a.exr", np.full((4, 4, 3), 1.5, np.float32))
    (tmp_path / "masks" / "masks.toml").write_text('[channels]\na = ["x", "y"]\n')
    with pytest.raises(FaceZipError, match=r"0\.\.1") as caught:
        read_masks(tmp_path / "masks")
    assert caught.value.code is ErrorCode.BAD_TEXELS


def test_channels_that_are_multiplied_by_alpha_are_refused(tmp_path):
    (tmp_path / "masks").mkdir()
    write_floats(tmp_path / "masks" / "a.exr", np.full((4, 4, 4), 0.5, np.float32))
    (tmp_path / "masks" / "masks.toml").write_text('[channels]\na = ["x", "y", "z", "w"]\n')
    with pytest.raises(FaceZipError, match="alpha"):
        read_masks(tmp_path / "masks")
