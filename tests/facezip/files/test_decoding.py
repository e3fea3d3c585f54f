"""Texels come where and as a file states that they are meant: upright, whole, and of the channels that count."""

import numpy as np
import OpenEXR
import OpenImageIO as oiio
import pytest
import tifffile
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image, ImageOps

from facezip import FaceZipError
from facezip.files.decoding import decode
from facezip.files.statements import stated
from facezip.machine import memory
from tests.facezip.files import stored

RNG = np.random.default_rng(0)
# Higher than a band, and no two rows or columns alike.
TALL = RNG.integers(0, 256, (300, 21, 3)).astype(np.uint8)


def half(*shape):
    return RNG.random(shape).astype(np.float16)


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize("suffix", [".png", ".tif", ".webp", ".jpg"])
def test_orientations_are_applied_as_pillow_applies_them(tmp_path, suffix, orientation):
    exif = Image.Exif()
    exif[274] = orientation
    path = tmp_path / f"a{suffix}"
    Image.fromarray(TALL).save(path, exif=exif, **({"lossless": True} if suffix == ".webp" else {}))
    with Image.open(path) as image:
        upright = np.asarray(ImageOps.exif_transpose(image))
    read = decode(path)
    assert np.abs(read.astype(int) - upright).max() <= (4 if suffix == ".jpg" else 0)
    facts = stated(path)
    assert (facts.size, facts.texel_bytes) == (upright.shape[:2], upright[0, 0].nbytes)
    assert bool(facts.applied(as_colours=False)) == (orientation > 1)


def test_exif_behind_the_pixels_of_a_png_counts(tmp_path):
    (tmp_path / "a.png").write_bytes(stored.png(TALL, after=[(b"eXIf", stored.exif(3))]))
    np.testing.assert_array_equal(decode(tmp_path / "a.png"), TALL[::-1, ::-1])


@pytest.mark.parametrize("orientation", [3, 6])
def test_a_bounded_memory_changes_no_orientation(tmp_path, orientation):
    texels = RNG.integers(0, 2**16, (700, 900, 3)).astype(np.uint16)
    (tmp_path / "a.tif").write_bytes(stored.tiff(texels, 16, 2, [(274, 3, [orientation])]))
    with memory.limited(400_000_000, tmp_path):
        bounded = decode(tmp_path / "a.tif").copy()
    np.testing.assert_array_equal(bounded, decode(tmp_path / "a.tif"))


@given(
    size=st.tuples(st.integers(1, 20), st.integers(1, 300)),
    corner=st.tuples(st.integers(-9, 9), st.integers(-300, 299)),
    extent=st.tuples(st.integers(1, 30), st.integers(1, 600)),
    tiled=st.booleans(),
)
@settings(max_examples=60, deadline=None)
def test_the_display_window_is_read_with_the_data_at_their_place(tmp_path_factory, size, corner, extent, tiled):
    (width, height), (left, top), (across, down) = size, corner, extent
    path, values = tmp_path_factory.mktemp("window") / "a.exr", half(down, across, 3)
    spec = oiio.ImageSpec(across, down, 3, "half")
    spec.x, spec.y, spec.full_x, spec.full_y, spec.full_width, spec.full_height = left, top, 0, 0, width, height
    if tiled:
        spec.tile_width = spec.tile_height = 32
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), spec)
    assert output.write_image(values)
    output.close()
    meant = np.zeros((height + 1800, width + 100, 3), np.float16)
    meant[top + 600 : top + 600 + down, left + 50 : left + 50 + across] = values
    meant = meant[600 : 600 + height, 50 : 50 + width]
    if not (-across < left < width and -down < top < height):
        with pytest.raises(FaceZipError, match="data window lies beside its display window"):
            decode(path)
        return
    np.testing.assert_array_equal(decode(path), meant)
    assert stated(path).size == (height, width)


def test_a_page_lies_anywhere_on_paper(tmp_path):
    places = [(282, 5, [[72, 1]]), (283, 5, [[72, 1]]), (286, 5, [[3, 1]]), (287, 5, [[2, 1]])]
    (tmp_path / "a.tif").write_bytes(stored.tiff(TALL, 8, 2, places))
    (tmp_path / "a.png").write_bytes(stored.png(TALL, [(b"oFFs", bytes([0, 0, 0, 5, 0, 0, 0, 9, 0]))]))
    for suffix in (".tif", ".png"):
        np.testing.assert_array_equal(decode(tmp_path / f"a{suffix}"), TALL)


RGB = half(12, 10, 3)
Z = half(12, 10)


def exr_of(path, *parts, **header):
    """Parts of named channels, by the library of OpenEXR."""
    made = [
        OpenEXR.Part(
            {"type": OpenEXR.scanlineimage, **header},
            {name: np.ascontiguousarray(v) for name, v in part.items()},
            f"part{n}",
        )
        for n, part in enumerate(parts)
    ]
    OpenEXR.File(made).write(str(path))


def layer(name, values=RGB, leaves="RGB"):
    return {f"{name}{leaf}": values[..., c] for c, leaf in enumerate(leaves)}


CERTAIN = {
    "in another order": [{"B": RGB[..., 2], "R": RGB[..., 0], "G": RGB[..., 1]}],
    "small letters": [layer("", leaves="rgb")],
    "words": [{"red": RGB[..., 0], "green": RGB[..., 1], "blue": RGB[..., 2]}],
    "one layer": [layer("diffuse.")],
    "a layer in a layer": [layer("ViewLayer.Combined.")],
    "with depth": [layer("") | {"Z": Z}],
    "a layer with depth": [layer("diffuse.") | {"Z": Z}],
    "the picture beside layers": [layer("") | layer("specular.", RGB[::-1]) | {"id": Z}],
    "views": [layer("") | layer("right.", RGB[::-1])],
    "the second part": [{"Z": Z}, layer("")],
    "a part beside one of normals": [layer("N.", RGB[::-1], "XYZ"), layer("")],
    "a vector": [layer("N.", leaves="xyz")],
}


@pytest.mark.parametrize("name", CERTAIN)
def test_the_layer_that_is_meant_is_read(tmp_path, name):
    exr_of(tmp_path / "a.exr", *CERTAIN[name])
    np.testing.assert_array_equal(decode(tmp_path / "a.exr"), RGB)
    facts = stated(tmp_path / "a.exr")
    assert len(facts.left_out) == sum(map(len, CERTAIN[name])) - 3
    assert bool(facts.applied(as_colours=True)) == bool(facts.left_out)


@pytest.mark.parametrize("channel", ["Y", "Z", "A", "height", "displacement.Z", "R"])
def test_a_channel_that_is_alone_is_meant(tmp_path, channel):
    exr_of(tmp_path / "a.exr", {channel: Z})
    np.testing.assert_array_equal(decode(tmp_path / "a.exr"), Z[..., None])


UNCERTAIN = {
    "two layers": ([layer("diffuse.") | layer("specular.")], "diffuse.*specular"),
    "two parts": ([layer(""), layer("")], "part0.*part1"),
    "grey beside a layer": ([layer("diffuse.") | {"Y": Z}], "diffuse"),
    "two numbers": ([{"height": Z, "gloss": Z}], "gloss.*height"),
}


@pytest.mark.parametrize("name", UNCERTAIN)
def test_layers_of_which_one_would_be_guessed_are_named(tmp_path, name):
    parts, says = UNCERTAIN[name]
    exr_of(tmp_path / "a.exr", *parts)
    with pytest.raises(FaceZipError, match=rf"a\.exr: .*channels.*{says}"):
        decode(tmp_path / "a.exr")


def test_channels_of_other_types_and_sizes_are_refused_by_name(tmp_path):
    f = Z.astype(np.float32)
    refused = {
        "ids": ({"Y": (np.arange(120, dtype=np.uint32).reshape(12, 10), 1)}, "uint"),
        "chroma": ({"Y": (Z, 1), "RY": (Z[::2, ::2], 2), "BY": (Z[::2, ::2], 2)}, "channel"),
        "chroma of full size": ({"Y": (Z, 1), "RY": (Z, 1), "BY": (Z, 1)}, "luminance and chroma"),
        "a colour of half the size": ({"R": (f, 1), "G": (f[::2, ::2], 2), "B": (f, 1)}, "channel"),
    }
    for channels, says in refused.values():
        (tmp_path / "a.exr").write_bytes(stored.exr(channels, (12, 10)))
        with pytest.raises(FaceZipError, match=rf"a\.exr: .*{says}"):
            decode(tmp_path / "a.exr")


def test_channels_of_several_types_come_as_the_widest(tmp_path):
    channels = {"R": (RGB[..., 0], 1), "G": (RGB[..., 1].astype(np.float32), 1), "B": (RGB[..., 2], 1)}
    (tmp_path / "a.exr").write_bytes(stored.exr(channels, (12, 10)))
    read = decode(tmp_path / "a.exr")
    assert read.dtype == np.float32
    np.testing.assert_array_equal(read, RGB)


@pytest.mark.parametrize("suffix", [".exr", ".tif"])
def test_of_a_pyramid_the_full_size_is_read(tmp_path, suffix):
    values = RNG.random((64, 64, 3)).astype(np.float32)
    image = oiio.ImageBuf(values)
    assert oiio.ImageBufAlgo.make_texture(oiio.MakeTxTexture, image, str(tmp_path / f"a{suffix}"))
    np.testing.assert_array_equal(decode(tmp_path / f"a{suffix}"), values)


def test_deep_pixels_are_refused_by_name(tmp_path):
    spec = oiio.ImageSpec(4, 4, 2, "float")
    spec.channelnames, spec.deep = ("Z", "A"), True
    output = oiio.ImageOutput.create(str(tmp_path / "a.exr"))
    assert output.open(str(tmp_path / "a.exr"), spec)
    deep = oiio.DeepData()
    deep.init(16, 2, ["float", "float"], ("Z", "A"))
    assert output.write_deep_image(deep)
    output.close()
    with pytest.raises(FaceZipError, match=r"a\.exr: .*deep"):
        decode(tmp_path / "a.exr")


def test_pages_are_refused_but_for_previews_and_masks(tmp_path):
    with tifffile.TiffWriter(tmp_path / "a.tif") as writer:
        writer.write(TALL, photometric="rgb")
        writer.write(TALL[::2, ::2], photometric="rgb", subfiletype=1)
        writer.write(TALL[..., 0] > 99, photometric="mask", subfiletype=4)
    np.testing.assert_array_equal(decode(tmp_path / "a.tif"), TALL)
    tifffile.imwrite(tmp_path / "pages.tif", np.stack([TALL, TALL]), photometric="rgb")
    with pytest.raises(FaceZipError, match=r"pages\.tif: .*several pages"):
        decode(tmp_path / "pages.tif")
    frames = [Image.fromarray(frame) for frame in (TALL, TALL[::-1].copy())]
    frames[0].save(tmp_path / "a.webp", save_all=True, append_images=frames[1:])
    with pytest.raises(FaceZipError, match=r"a\.webp: .*animation"):
        decode(tmp_path / "a.webp")
