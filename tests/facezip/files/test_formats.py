"""Numbers of every format, depth and kind come as others read them; what would be guessed is refused by name."""

import numpy as np
import OpenImageIO as oiio
import pytest
from PIL import Image

from facezip import FaceZipError
from facezip.files.decoding import decode
from facezip.files.images import read_texture
from facezip.files.opening import OTHER_SUFFIXES, TEXTURE_SUFFIXES
from facezip.files.srgb import decode_srgb, encode_srgb
from facezip.files.statements import stated
from tests.facezip.files import stored

RNG = np.random.default_rng(0)
RGB = RNG.integers(0, 256, (17, 11, 3)).astype(np.uint8)
RGBA = np.dstack([RGB, RNG.integers(0, 256, (17, 11, 1)).astype(np.uint8)])
LOSSLESS = {"webp": {"lossless": True, "exact": True}}


@pytest.mark.parametrize("suffix", ["png", "tif", "tga", "bmp", "webp"])
@pytest.mark.parametrize("mode", ["RGB", "RGBA", "L", "P", "1"])
def test_images_come_as_pillow_reads_them(tmp_path, suffix, mode):
    path = tmp_path / f"a.{suffix}"
    if (suffix, mode) == ("tga", "1"):
        mode = "L"
    image = Image.fromarray(RGBA).convert("RGB" if mode == "P" else mode)
    (image.quantize(16) if mode == "P" else image).save(path, **LOSSLESS.get(suffix, {}))
    with Image.open(path) as again:
        meant = np.asarray(again.convert({"RGBA": "RGBA", "L": "L", "1": "L"}.get(again.mode, "RGB")))
    meant = meant.reshape(*meant.shape[:2], -1)
    read = decode(path)
    # Grey may be unfolded, Pillow sees no alpha in a bitmap, and its palette of TIFF
    # has 256 of 16 bits for each of 255.
    read = read[..., : meant.shape[2]]
    assert np.abs(read.astype(int) - meant).max() <= ((suffix, mode) == ("tif", "P"))
    assert stated(path).applied(as_colours=True) == ()


@pytest.mark.parametrize("options", [{"compression": "tga_rle"}, {"orientation": 1}, {"orientation": -1}])
def test_targa_is_read_compressed_and_from_either_side(tmp_path, options):
    Image.fromarray(RGBA).save(tmp_path / "a.tga", **options)
    np.testing.assert_array_equal(decode(tmp_path / "a.tga"), RGBA)


@pytest.mark.parametrize(("origin", "turn"), [(0x00, (-1, 1)), (0x10, (-1, -1)), (0x20, (1, 1)), (0x30, (1, -1))])
def test_targa_begins_at_any_corner(tmp_path, origin, turn):
    (tmp_path / "a.tga").write_bytes(stored.tga(RGB[:: turn[0], :: turn[1]], origin))
    np.testing.assert_array_equal(decode(tmp_path / "a.tga"), RGB)


@pytest.mark.parametrize("interlaced", [False, True])
@pytest.mark.parametrize("channels", [1, 2, 3, 4])
def test_png_of_16_bits_keeps_them(tmp_path, channels, interlaced):
    texels = RNG.integers(0, 2**16, (19, 13, channels)).astype(np.uint16)
    if interlaced:
        spec = oiio.ImageSpec(13, 19, channels, "uint16")
        spec.attribute("oiio:UnassociatedAlpha", 1)
        spec.attribute("png:interlace", 1)
        output = oiio.ImageOutput.create(str(tmp_path / "a.png"))
        assert output.open(str(tmp_path / "a.png"), spec)
        assert output.write_image(texels)
        output.close()
    else:
        (tmp_path / "a.png").write_bytes(stored.png(texels))
    np.testing.assert_array_equal(decode(tmp_path / "a.png"), texels)


@pytest.mark.parametrize("bits", [1, 2, 4])
def test_png_of_few_bits_spans_black_to_white(tmp_path, bits):
    levels = RNG.integers(0, 2**bits, (9, 13, 1))
    (tmp_path / "a.png").write_bytes(stored.png(levels.astype(np.uint8), bits=bits))
    np.testing.assert_array_equal(decode(tmp_path / "a.png"), levels * 255 // (2**bits - 1))


def test_a_palette_and_a_colour_that_is_transparent_are_unfolded(tmp_path):
    palette = RNG.integers(0, 256, (16, 3)).astype(np.uint8)
    numbers = RNG.integers(0, 16, (7, 5, 1)).astype(np.uint8)
    (tmp_path / "a.png").write_bytes(stored.png(numbers, palette=palette, bits=4))
    np.testing.assert_array_equal(decode(tmp_path / "a.png"), palette[numbers[..., 0]])
    (tmp_path / "b.png").write_bytes(
        stored.png(RGB, [(b"tRNS", bytes([0, RGB[0, 0, 0], 0, RGB[0, 0, 1], 0, RGB[0, 0, 2]]))])
    )
    np.testing.assert_array_equal(read_texture(tmp_path / "b.png"), RGB)


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("white_is_zero", [False, True])
@pytest.mark.parametrize("bits", [1, 2, 4, 6, 8, 10, 12, 14, 16, 32])
def test_tiff_of_any_depth_spans_black_to_white(tmp_path, bits, white_is_zero, order):
    whole = 2**bits - 1
    levels = np.array([0, whole // 3, whole // 2, whole, 0, whole] * 3, np.uint64).reshape(3, 6, 1)
    (tmp_path / "a.tif").write_bytes(stored.tiff(levels, bits, 0 if white_is_zero else 1, order=order))
    read = decode(tmp_path / "a.tif")
    meant = 1 - levels / whole if white_is_zero else levels / whole
    np.testing.assert_allclose(read / np.iinfo(read.dtype).max, meant, atol=1 / np.iinfo(read.dtype).max)
    assert read_texture(tmp_path / "a.tif").dtype == (np.uint8 if bits <= 8 else np.uint16)


@pytest.mark.parametrize("kind", [np.float16, np.float32, np.float64])
def test_floats_of_tiff_are_light(tmp_path, kind):
    import tifffile

    values = RNG.random((8, 9, 3)).astype(kind)
    tifffile.imwrite(tmp_path / "a.tif", values, photometric="rgb")
    np.testing.assert_array_equal(decode(tmp_path / "a.tif"), values)
    np.testing.assert_allclose(read_texture(tmp_path / "a.tif"), encode_srgb(values.astype(np.float32)), atol=1e-6)


def test_limits_of_values_in_tiff_change_nothing(tmp_path):
    texels = RNG.integers(0, 4096, (4, 5, 3)).astype(np.uint16)
    limits = [(280, 3, [0] * 3), (281, 3, [4095] * 3)]
    (tmp_path / "a.tif").write_bytes(stored.tiff(texels, 16, 2, limits))
    np.testing.assert_array_equal(read_texture(tmp_path / "a.tif"), texels)


def with_alpha(path, premultiplied, rgb, alpha, dtype):
    """Four channels, whose colours are multiplied by alpha or not, of integers."""
    whole = np.iinfo(dtype).max
    colours = rgb * alpha if premultiplied else rgb
    texels = np.rint(np.concatenate([colours, alpha], axis=2) * whole).astype(dtype)
    if path.suffix == ".tga":
        path.write_bytes(stored.tga(texels, alpha_type=4 if premultiplied else 3))
    else:
        path.write_bytes(stored.tiff(texels, 8 * texels.itemsize, 2, [(338, 3, [1 if premultiplied else 2])]))


@pytest.mark.parametrize("premultiplied", [False, True])
@pytest.mark.parametrize(("suffix", "dtype"), [(".tif", np.uint8), (".tif", np.uint16), (".tga", np.uint8)])
def test_colours_are_what_they_were_before_alpha(tmp_path, suffix, dtype, premultiplied):
    alpha = np.full((6, 8, 1), 1.0)
    alpha[:, :4] = 0.5
    rgb = RNG.random((6, 8, 3))
    with_alpha(tmp_path / f"a{suffix}", premultiplied, rgb, alpha, dtype)
    whole = np.iinfo(dtype).max
    np.testing.assert_allclose(read_texture(tmp_path / f"a{suffix}") / whole, rgb, atol=2.1 / whole)
    assert bool(stated(tmp_path / f"a{suffix}").applied(as_colours=True)) == premultiplied


@pytest.mark.parametrize("kind", ["half", "float"])
def test_colours_of_openexr_are_divided_by_alpha(tmp_path, kind):
    light, alpha = RNG.random((40, 9, 3)).astype(np.float32), RNG.random((40, 9, 1)).astype(np.float32) ** 2
    alpha[0], alpha[1] = 1, 0
    spec = oiio.ImageSpec(9, 40, 4, kind)
    output = oiio.ImageOutput.create(str(tmp_path / "a.exr"))
    assert output.open(str(tmp_path / "a.exr"), spec)
    assert output.write_image(np.concatenate([light * alpha, alpha], axis=2))
    output.close()
    visible = alpha[..., 0] > 0.01
    read = read_texture(tmp_path / "a.exr")
    np.testing.assert_allclose(decode_srgb(read)[visible], light[visible], atol=2e-3 if kind == "half" else 1e-5)
    assert (read[1] == 0).all()


def test_light_that_alpha_does_not_cover_stays(tmp_path):
    channels = {
        name: (np.full((4, 4), value, np.float32), 1) for name, value in zip("RGBA", (0.1, 0.2, 0.3, 0), strict=True)
    }
    (tmp_path / "a.exr").write_bytes(stored.exr(channels, (4, 4)))
    np.testing.assert_allclose(decode(tmp_path / "a.exr")[0, 0], [0.1, 0.2, 0.3, 0], atol=1e-7)


def test_colours_above_their_alpha_were_not_multiplied(tmp_path):
    texels = np.full((4, 4, 4), 200, np.uint8)
    texels[..., 3] = 100
    (tmp_path / "a.tif").write_bytes(stored.tiff(texels, 8, 2, [(338, 3, [1])]))
    with pytest.raises(FaceZipError, match=r"a\.tif: .*multiplied by alpha"):
        decode(tmp_path / "a.tif")


def test_channels_behind_colours_are_left_out(tmp_path):
    texels = RNG.integers(0, 256, (6, 5, 6)).astype(np.uint8)
    (tmp_path / "a.tif").write_bytes(stored.tiff(texels, 8, 2, [(338, 3, [0, 0, 0])]))
    np.testing.assert_array_equal(read_texture(tmp_path / "a.tif"), texels[..., :3])
    assert len(stated(tmp_path / "a.tif").left_out) == 2


REFUSED = {
    "cmyk.tif": (stored.tiff(np.zeros((4, 4, 4)), 8, 5), "CMYK"),
    "lab.tif": (stored.tiff(np.zeros((4, 4, 3)), 8, 8), r"L\*a\*b\*"),
    "signed.tif": (stored.tiff(np.zeros((4, 4, 3)), 16, 2, kind=2), "int16"),
    "white.tif": (stored.tiff(np.zeros((4, 4, 1)), 32, 0, kind=3), "white is zero"),
    "two.tif": (stored.tiff(RGB[..., :2], 8, 1, [(338, 3, [0])]), "two channels"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_would_be_guessed_is_refused_by_name(tmp_path, name):
    content, says = REFUSED[name]
    (tmp_path / name).write_bytes(content)
    with pytest.raises(FaceZipError, match=f"{name}: .*{says}"):
        read_texture(tmp_path / name)


def test_cmyk_of_jpeg_is_refused_by_name(tmp_path):
    Image.fromarray(RGB).convert("CMYK").save(tmp_path / "a.jpg")
    with pytest.raises(FaceZipError, match=r"a\.jpg: .*CMYK"):
        read_texture(tmp_path / "a.jpg")


@pytest.mark.parametrize("suffix", OTHER_SUFFIXES)
def test_other_formats_are_refused_with_those_that_are_read(tmp_path, suffix):
    (tmp_path / f"a{suffix}").write_bytes(b"anything")
    with pytest.raises(FaceZipError, match=rf"a\{suffix}: \{suffix} is not read, PNG, TIFF, JPEG, OpenEXR"):
        read_texture(tmp_path / f"a{suffix}")


@pytest.mark.parametrize("suffix", TEXTURE_SUFFIXES)
def test_a_file_under_the_name_of_another_kind_is_told_so(tmp_path, suffix):
    other = ".exr" if suffix != ".exr" else ".png"
    content = stored.exr({"Y": (np.zeros((2, 2), np.float32), 1)}, (2, 2)) if other == ".exr" else stored.png(RGB)
    (tmp_path / f"a{suffix}").write_bytes(content)
    with pytest.raises(FaceZipError, match=rf"a\{suffix}: .*holds {other[1:]}; its name says \{suffix}"):
        decode(tmp_path / f"a{suffix}")


@pytest.mark.parametrize("size", [(1, 1), (2, 2), (1, 64), (3, 1)])
def test_placeholders_are_images(tmp_path, size):
    texels = RNG.integers(0, 256, (*size, 3)).astype(np.uint8)
    for suffix in ("png", "tif", "tga", "bmp", "webp"):
        Image.fromarray(texels).save(tmp_path / f"a.{suffix}", **LOSSLESS.get(suffix, {}))
        np.testing.assert_array_equal(decode(tmp_path / f"a.{suffix}"), texels)
