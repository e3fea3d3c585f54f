"""ICC profiles in every format that has them: colours come as sRGB, and sRGB in any spelling comes unchanged."""

import struct
from contextlib import suppress
from io import BytesIO

import colour
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image, ImageCms

from facezip import FaceZipError
from facezip.files.colour_space import ColourFault
from facezip.files.icc import SRGB_COLUMNS, profile_space
from facezip.files.images import read_texture
from facezip.files.srgb import decode_srgb, encode_srgb
from facezip.files.statements import stated
from tests.facezip.files import profiles, stored

RNG = np.random.default_rng(0)
# Skin and lips: far from the borders of every space, so that nothing is clipped.
SKIN = (0.25 + 0.5 * RNG.random((24, 20, 3)) ** 2) * (1, 0.8, 0.7)
# Where sRGB's curve is a line, and a power is not.
DARK = np.broadcast_to(np.linspace(0, 0.12, 8 * 20).reshape(8, 20, 1), (8, 20, 3))
LITTLECMS = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
# Of each space its columns, its curve as a profile has it, and the way back from light.
SPACES = {
    "Display P3": (profiles.SRGB_CURVE, encode_srgb),
    "Adobe RGB": (profiles.curve(563 / 256), lambda x: x ** (256 / 563)),
    "ProPhoto": (profiles.curve(1.8, kind=0), lambda x: x ** (1 / 1.8)),
}
PROFILES = {
    "parametric": profiles.icc(profiles.COLUMNS["sRGB"], [profiles.SRGB_CURVE] * 3),
    "sampled": profiles.icc(
        profiles.COLUMNS["sRGB"], [profiles.curve(samples=decode_srgb(np.linspace(0, 1, 1024)))] * 3
    ),
    "of littlecms": LITTLECMS,
}


def in_space(name, encoded):
    """Encoded sRGB colours as numbers of another space, by its published columns."""
    columns = np.array(profiles.COLUMNS[name]).T
    light = decode_srgb(encoded) @ np.linalg.solve(columns, np.array(profiles.COLUMNS["sRGB"]).T).T
    return SPACES[name][1](np.clip(light, 0, 1))


def write(path, values, dtype, profile):
    """A file that has a profile, of floats in [0, 1] rounded to a type."""
    texels = np.rint(values * np.iinfo(dtype).max).astype(dtype)
    if path.suffix == ".png":
        path.write_bytes(stored.png(texels, [stored.iccp(profile)]))
    elif path.suffix == ".tif":
        path.write_bytes(stored.tiff(texels, 8 * texels.itemsize, 2, [(34675, 1, list(profile))]))
    elif path.suffix == ".bmp":
        Image.fromarray(texels).save(path)
        path.write_bytes(with_embedded(path.read_bytes(), profile))
    else:
        options = {".jpg": {"quality": 100, "subsampling": 0}, ".webp": {"lossless": True}}[path.suffix]
        Image.fromarray(texels).save(path, icc_profile=profile, **options)
    return texels


def with_embedded(bitmap, profile):
    """A bitmap of version 3 as one of version 5 that holds a profile."""
    pixels = bitmap[54:]
    info = struct.pack("<I", 124) + bitmap[18:54] + bytes(124 - 40)
    info = info[:56] + b"DEBM" + info[60:112] + struct.pack("<II", 124 + len(pixels), len(profile)) + info[120:]
    return b"BM" + struct.pack("<IHHI", 138 + len(pixels) + len(profile), 0, 0, 138) + info + pixels + profile


FORMATS = [(".png", np.uint8), (".png", np.uint16), (".tif", np.uint8), (".tif", np.uint16), (".webp", np.uint8)]
FORMATS += [(".bmp", np.uint8)]


@pytest.mark.parametrize(("suffix", "dtype"), [*FORMATS, (".jpg", np.uint8)])
@pytest.mark.parametrize("name", SPACES)
def test_colours_of_a_profile_are_what_they_were_in_srgb(tmp_path, suffix, dtype, name):
    path, profile = tmp_path / f"a{suffix}", profiles.icc(profiles.COLUMNS[name], [SPACES[name][0]] * 3, name)
    write(path, in_space(name, SKIN), dtype, profile)
    read = read_texture(path)
    assert read.dtype == dtype
    # One rounding of each writer, and what it becomes on a steeper curve.
    level = 3 / 255 if dtype == np.uint8 else 4 / 65535
    np.testing.assert_allclose(read / np.iinfo(dtype).max, SKIN, atol=12 / 255 if suffix == ".jpg" else level)
    assert any(name in words for words in stated(path).applied(as_colours=True))


@pytest.mark.parametrize(("suffix", "dtype"), FORMATS)
@pytest.mark.parametrize("profile", PROFILES)
def test_srgb_in_any_spelling_changes_nothing(tmp_path, suffix, dtype, profile):
    path = tmp_path / f"a{suffix}"
    texels = write(path, RNG.random((16, 16, 3)), dtype, PROFILES[profile])
    np.testing.assert_array_equal(read_texture(path), texels)
    assert stated(path).applied(as_colours=True) == ()


@given(
    columns=st.sampled_from(list(profiles.COLUMNS)),
    kind=st.sampled_from([None, 0, 1, 2, 3, 4, "samples"]),
    exponent=st.floats(1.2, 2.8),
    seed=st.integers(0, 2**16),
)
@settings(max_examples=60, deadline=None)
def test_profiles_are_read_as_littlecms_reads_them(tmp_path_factory, columns, kind, exponent, seed):
    path = tmp_path_factory.mktemp("icc") / "a.png"
    profile = profiles.icc(profiles.COLUMNS[columns], [some_curve(kind, exponent)] * 3)
    rng = np.random.default_rng(seed)
    # Near grey: in the gamut of both.
    texels = np.clip(rng.integers(90, 250, (8, 8, 1)) + rng.integers(-3, 4, (8, 8, 3)), 0, 255).astype(np.uint8)
    path.write_bytes(stored.png(texels, [stored.iccp(profile)]))
    theirs = ImageCms.profileToProfile(
        Image.fromarray(texels), ImageCms.ImageCmsProfile(BytesIO(profile)), ImageCms.createProfile("sRGB"),
        renderingIntent=ImageCms.Intent.RELATIVE_COLORIMETRIC,
    )  # fmt: skip
    ours = read_texture(path)
    if not np.array_equal(ours, texels):
        assert np.abs(ours.astype(int) - np.asarray(theirs).astype(int)).max() <= 1


def some_curve(kind, g):
    """A curve from black to white, of each kind that profiles have."""
    if kind == "samples":
        return profiles.curve(samples=np.linspace(0, 1, 33) ** g)
    a, b = 1 / 1.05, 0.05 / 1.05
    numbers = {
        None: (g,),
        0: (g,),
        1: (g, a, b),
        2: (g, a, b, 0.0),
        3: (g, a, b, 0.1, 0.02),
        4: (g, a, b, 0.1, 0.02, 0.0, 0.0),
    }
    return profiles.curve(*numbers[kind], kind=kind)


@pytest.mark.parametrize("bits", [8, 16])
def test_a_profile_of_grey_moves_grey(tmp_path, bits):
    whole = 2**bits - 1
    texels = np.arange(0, whole, whole // 64).astype(f"uint{bits}")[:64].reshape(8, 8, 1)
    profile = profiles.icc([], [profiles.curve(1.8)], space=b"GRAY")
    (tmp_path / "a.png").write_bytes(stored.png(texels, [stored.iccp(profile)]))
    meant = encode_srgb(np.power(texels / whole, round(1.8 * 256) / 256))
    np.testing.assert_allclose(read_texture(tmp_path / "a.png") / whole, meant, atol=0.6 / whole)


@pytest.mark.parametrize("suffix", [".webp", ".jpg"])
def test_a_camera_that_means_adobe_rgb_without_a_profile_is_understood(tmp_path, suffix):
    exif = Image.Exif()
    exif._ifds[0x8769] = {0xA001: 65535, 0xA005: {1: "R03"}}
    colours = np.concatenate([SKIN, DARK])
    texels = np.rint(in_space("Adobe RGB", colours) * 255).astype(np.uint8)
    exact = {"lossless": True} if suffix == ".webp" else {"quality": 100, "subsampling": 0}
    Image.fromarray(texels).save(tmp_path / f"a{suffix}", exif=exif, **exact)
    level = 3 / 255 if suffix == ".webp" else 5 / 255
    np.testing.assert_allclose(read_texture(tmp_path / f"a{suffix}") / 255, colours, atol=level)


def test_srgb_columns_are_those_of_colour_science():
    space = colour.RGB_COLOURSPACES["sRGB"].copy()
    space.use_derived_transformation_matrices(True)
    white, d50 = space.matrix_RGB_to_XYZ.sum(axis=1), np.array(profiles.WHITE)
    adapted = colour.adaptation.matrix_chromatic_adaptation_VonKries(white, d50, "Bradford") @ space.matrix_RGB_to_XYZ
    np.testing.assert_allclose(SRGB_COLUMNS, adapted, atol=2e-4)


@pytest.mark.parametrize("name", PROFILES)
def test_a_profile_of_colours_serves_grey(tmp_path, name):
    texels = RNG.integers(0, 256, (6, 7, 1)).astype(np.uint8)
    (tmp_path / "a.png").write_bytes(stored.png(texels, [stored.iccp(PROFILES[name])]))
    np.testing.assert_array_equal(read_texture(tmp_path / "a.png"), texels)
    p3 = profiles.icc(profiles.COLUMNS["Display P3"], [profiles.curve(1.0)] * 3)
    (tmp_path / "b.png").write_bytes(stored.png(texels, [stored.iccp(p3)]))
    np.testing.assert_array_equal(read_texture(tmp_path / "b.png"), np.rint(encode_srgb(texels / 255) * 255))


@pytest.mark.parametrize("is_linear", [True, False])
def test_floats_with_a_profile_are_what_it_says(tmp_path, is_linear):
    values = RNG.random((5, 8, 3)).astype(np.float32)
    curve = profiles.curve(1.0) if is_linear else profiles.SRGB_CURVE
    profile = profiles.icc(profiles.COLUMNS["sRGB"], [curve] * 3)
    (tmp_path / "a.tif").write_bytes(stored.tiff(values, 32, 2, [(34675, 1, list(profile))], kind=3))
    meant = encode_srgb(values) if is_linear else values
    np.testing.assert_allclose(read_texture(tmp_path / "a.tif"), meant, atol=1e-4)


def test_a_damaged_profile_is_refused_by_its_name(tmp_path):
    kind, content = stored.iccp(PROFILES["parametric"], b"Mine")
    (tmp_path / "a.png").write_bytes(stored.png(np.zeros((4, 4, 3), np.uint8), [(kind, content[:20] + bytes(90))]))
    with pytest.raises(FaceZipError, match=r"a\.png: its colours are of the ICC profile 'Mine', which is damaged"):
        read_texture(tmp_path / "a.png")


@given(changes=st.lists(st.tuples(st.integers(0, 1023), st.integers(0, 255)), min_size=1, max_size=8))
@settings(max_examples=200, deadline=None)
def test_a_changed_profile_is_read_or_refused(changes):
    profile = bytearray(
        profiles.icc(profiles.COLUMNS["ProPhoto"], [some_curve(4, 2.4), some_curve("samples", 2), some_curve(2, 2)])
    )
    for at, value in changes:
        profile[at % len(profile)] = value
    values = np.linspace(0, 1, 30, dtype=np.float32).reshape(10, 3)
    with suppress(ColourFault):
        assert np.isfinite(profile_space(bytes(profile), 3).light(values)).all()
