import numpy as np
import OpenImageIO as oiio
import pytest

from facezip import FaceZipError
from facezip.files.images import as_texels, read_texture, to_float, write_texture
from facezip.files.srgb import decode_srgb, encode_srgb

RNG = np.random.default_rng(0)


@pytest.mark.parametrize("suffix", [".png", ".tif"])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
@pytest.mark.parametrize("channels", [1, 3])
def test_integer_texels_come_back_as_they_were(tmp_path, suffix, dtype, channels):
    texels = RNG.integers(0, np.iinfo(dtype).max, (9, 13, channels)).astype(dtype)
    write_texture(tmp_path / f"a{suffix}", texels)
    np.testing.assert_array_equal(read_texture(tmp_path / f"a{suffix}"), texels)


def test_a_png_takes_what_its_texels_say_beside_those_above(tmp_path):
    texels = 100 + RNG.integers(0, 16, (256, 256, 3)).astype(np.uint8)
    write_texture(tmp_path / "noise.png", texels)
    share = np.unique(np.diff(texels, axis=0), return_counts=True)[1] / np.diff(texels, axis=0).size
    entropy = -(share * np.log2(share)).sum() / 8 * texels.size
    assert entropy < (tmp_path / "noise.png").stat().st_size < 1.03 * entropy


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_a_png_of_one_colour_is_nothing(tmp_path, dtype):
    texels = np.full((256, 256, 3), 100, dtype)
    write_texture(tmp_path / "flat.png", texels)
    assert (tmp_path / "flat.png").stat().st_size < texels.nbytes / 200


def test_float_texels_are_stored_linear_and_come_back_encoded(tmp_path):
    texels = RNG.random((9, 13, 3)).astype(np.float32)
    write_texture(tmp_path / "a.exr", texels)
    np.testing.assert_allclose(read_texture(tmp_path / "a.exr"), texels, atol=1e-6)


def test_colour_under_transparent_texels_survives_and_alpha_is_dropped(tmp_path):
    rgba = RNG.integers(0, 255, (8, 8, 4)).astype(np.uint8)
    rgba[..., 3] = 0
    write_texture(tmp_path / "a.png", rgba)
    np.testing.assert_array_equal(read_texture(tmp_path / "a.png"), rgba[..., :3])


def test_srgb_curves_are_inverse_and_meet_the_standard():
    values = np.linspace(0, 1, 1001, dtype=np.float32)
    np.testing.assert_allclose(encode_srgb(decode_srgb(values)), values, atol=2e-6)
    np.testing.assert_allclose(decode_srgb(np.float32([0.5])), [0.21404114], atol=1e-6)


@pytest.mark.parametrize(("dtype", "top"), [(np.uint8, 255), (np.uint16, 65535), (np.float32, 1)])
def test_every_type_spans_zero_to_one(dtype, top):
    np.testing.assert_allclose(to_float(np.array([0, top], dtype)), [0, 1], atol=1e-7)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_values_become_the_texels_again_that_they_were(dtype):
    top = 1 if dtype is np.float32 else np.iinfo(dtype).max
    texels = np.linspace(0, top, 2**16).reshape(256, 256, 1).astype(dtype)
    again = as_texels(to_float(texels), texels.dtype)
    assert again.dtype == dtype
    np.testing.assert_array_equal(again, texels)


@pytest.mark.parametrize("value", [np.nan, np.inf, -0.25, 1.5])
def test_texels_that_are_no_albedo_are_refused(tmp_path, value):
    texels = np.full((8, 8, 3), 0.5, np.float32)
    write_texture(tmp_path / "bad.exr", texels)
    import OpenImageIO as oiio

    texels[3, 5, 1] = value
    oiio.ImageBuf(texels).write(str(tmp_path / "bad.exr"), "float")
    with pytest.raises(FaceZipError, match="bad.exr"):
        read_texture(tmp_path / "bad.exr")


@pytest.mark.parametrize("suffix", [".png", ".tif", ".exr"])
def test_a_truncated_image_is_refused_quietly(tmp_path, capfd, suffix):
    path = tmp_path / f"bad{suffix}"
    texels = RNG.random((64, 64, 3)).astype(np.float32) if suffix == ".exr" else RNG.integers(0, 255, (64, 64, 3))
    write_texture(path, texels.astype(np.float32 if suffix == ".exr" else np.uint8))
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    with pytest.raises(FaceZipError, match="not a readable image"):
        read_texture(path)
    assert capfd.readouterr().err == ""


def test_a_tiff_does_not_say_when_it_was_written(tmp_path):
    """The same texels are the same bytes on any day."""
    write_texture(tmp_path / "a.tif", np.zeros((2, 3, 4), np.uint8))
    assert oiio.ImageBuf(str(tmp_path / "a.tif")).spec().getattribute("DateTime") == "1970:01:01 00:00:00"
