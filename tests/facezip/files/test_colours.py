"""What PNG, TIFF and OpenEXR state of their colour space besides ICC profiles: converted, or refused by its name."""

import struct

import colour
import numpy as np
import OpenImageIO as oiio
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facezip import FaceZipError
from facezip.files.bands import filled
from facezip.files.colours import colour_bands
from facezip.files.decoding import decode
from facezip.files.images import read_texture
from facezip.files.srgb import decode_srgb, encode_srgb
from tests.facezip.files import profiles, stored

RNG = np.random.default_rng(0)
# Skin and lips: far from the borders of every space, so that nothing is clipped.
SKIN = (0.25 + 0.5 * RNG.random((24, 20, 3)) ** 2) * (1, 0.8, 0.7)


@given(exponent=st.floats(0.4, 4).filter(lambda x: abs(x - 2.2) > 0.1), bits=st.sampled_from([8, 16]))
@settings(max_examples=40, deadline=None)
def test_gamma_of_png_is_a_power_of_light(tmp_path_factory, exponent, bits):
    path, whole = tmp_path_factory.mktemp("gamma") / "a.png", 2**bits - 1
    texels = np.linspace(0, whole, 48).round().astype(f"uint{bits}").reshape(4, 4, 3)
    chunk = stored.gama(exponent)
    path.write_bytes(stored.png(texels, [chunk]))
    stated_exponent = 100000 / struct.unpack(">I", chunk[1])[0]
    meant = texels / whole if abs(exponent - 2.2) < 0.05 else encode_srgb(np.power(texels / whole, stated_exponent))
    np.testing.assert_allclose(read_texture(path) / whole, meant, atol=0.6 / whole)


REC_2020 = colour.RGB_COLOURSPACES["ITU-R BT.2020"]
SRGB_CHRM = stored.chrm((0.64, 0.33), (0.3, 0.6), (0.15, 0.06), (0.3127, 0.329))
LYING = [stored.gama(1), stored.chrm(*REC_2020.primaries, REC_2020.whitepoint)]


@pytest.mark.parametrize(
    "chunks",
    [
        [(b"sRGB", b"\0")],
        [stored.gama(2.2)],
        [stored.gama(2.2), SRGB_CHRM],
        [SRGB_CHRM],
        [(b"sRGB", b"\0"), *LYING],
        [(b"cICP", bytes([1, 13, 0, 1])), *LYING],
        [(b"cICP", bytes([2, 2, 0, 1])), (b"sRGB", b"\0")],
        [
            (b"cICP", bytes([1, 13, 0, 1])),
            stored.iccp(profiles.icc(profiles.COLUMNS["ProPhoto"], [profiles.SRGB_SAMPLED] * 3)),
        ],
    ],
)
def test_the_chunk_that_outranks_the_others_counts(tmp_path, chunks):
    texels = RNG.integers(0, 256, (9, 9, 3)).astype(np.uint8)
    (tmp_path / "a.png").write_bytes(stored.png(texels, chunks))
    np.testing.assert_array_equal(read_texture(tmp_path / "a.png"), texels)


def light_in(space):
    """The light of skin, by the primaries of a space of colour-science and by its mathematics."""
    return colour.RGB_to_RGB(decode_srgb(SKIN), "sRGB", space, chromatic_adaptation_transform="Bradford")


def as_texels(light):
    return np.rint(encode_srgb(light) * 65535).astype(np.uint16)


@pytest.mark.parametrize(
    ("chunks", "space"),
    [
        ([stored.chrm(*REC_2020.primaries, REC_2020.whitepoint)], "ITU-R BT.2020"),
        ([(b"cICP", bytes([9, 13, 0, 1]))], "ITU-R BT.2020"),
        ([(b"cICP", bytes([12, 13, 0, 1]))], "Display P3"),
    ],
)
def test_primaries_of_png_are_converted(tmp_path, chunks, space):
    (tmp_path / "a.png").write_bytes(stored.png(as_texels(light_in(space)), chunks))
    np.testing.assert_allclose(read_texture(tmp_path / "a.png") / 65535, SKIN, atol=5e-4)


XY = {name: colour.RGB_COLOURSPACES[name] for name in ("ACES2065-1", "ACEScg", "ITU-R BT.2020", "Adobe RGB (1998)")}


def chromaticities(name):
    space = XY[name]
    return b"chromaticities", b"chromaticities", struct.pack("<8f", *space.primaries.ravel(), *space.whitepoint)


def string(name, text):
    return name.encode(), b"string", text.encode()


@pytest.mark.parametrize(
    ("attributes", "space"),
    [
        *([[chromaticities(name)], name] for name in XY),
        ([string("colorInteropID", "lin_ap1_scene")], "ACEScg"),
        ([string("colorInteropID", "lin_rec2020_scene")], "ITU-R BT.2020"),
        ([(b"acesImageContainerFlag", b"int", struct.pack("<i", 1))], "ACES2065-1"),
    ],
)
def test_primaries_of_openexr_are_converted(tmp_path, attributes, space):
    light = light_in(space).astype(np.float32)
    channels = {name: (light[..., c], 1) for c, name in enumerate("RGB")}
    (tmp_path / "a.exr").write_bytes(stored.exr(channels, light.shape[:2], attributes=attributes))
    np.testing.assert_allclose(read_texture(tmp_path / "a.exr"), SKIN, atol=5e-4)


REC_709 = (0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329)


@pytest.mark.parametrize(
    ("attributes", "is_encoded"),
    [
        ([], False),
        (
            [
                (
                    b"chromaticities",
                    b"chromaticities",
                    struct.pack("<8f", 0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329),
                )
            ],
            False,
        ),
        ([(b"whiteLuminance", b"float", struct.pack("<f", 100))], False),
        ([string("colorInteropID", "lin_rec709_scene")], False),
        ([string("colorInteropID", "unknown")], False),
        ([string("colorInteropID", "srgb_rec709_scene")], True),
    ],
)
def test_openexr_of_srgbs_primaries_is_encoded_once(tmp_path, attributes, is_encoded):
    values = RNG.random((6, 7, 3)).astype(np.float32)
    channels = {name: (values[..., c], 1) for c, name in enumerate("RGB")}
    (tmp_path / "a.exr").write_bytes(stored.exr(channels, (6, 7), attributes=attributes))
    np.testing.assert_allclose(
        read_texture(tmp_path / "a.exr"), values if is_encoded else encode_srgb(values), atol=1e-6
    )


def test_primaries_of_tiff_are_converted(tmp_path):
    texels = as_texels(light_in("ITU-R BT.2020"))
    points = [[round(1e4 * x), 10000] for point in REC_2020.primaries for x in point]
    white = [[3127, 10000], [3290, 10000]]
    (tmp_path / "a.tif").write_bytes(stored.tiff(texels, 16, 2, [(318, 5, white), (319, 5, points)]))
    np.testing.assert_allclose(read_texture(tmp_path / "a.tif") / 65535, SKIN, atol=5e-4)


def profiled(profile, channels=3):
    return stored.png(RNG.integers(0, 256, (8, 8, channels)).astype(np.uint8), [stored.iccp(profile)])


def exr_with(*attributes):
    channels = {name: (np.full((8, 8), 0.5, np.float32), 1) for name in "RGB"}
    return stored.exr(channels, (8, 8), attributes=attributes)


GREY = profiles.icc([], [profiles.curve(2.2)], "Dot gain", space=b"GRAY")
P3 = profiles.COLUMNS["Display P3"]
UNCERTAIN = {
    "tables.png": (
        profiled(profiles.icc(P3, [profiles.SRGB_SAMPLED] * 3, "Printer", tables=(b"A2B0",))),
        "Printer.*tables",
    ),
    "lab.png": (
        profiled(profiles.icc(P3, [profiles.SRGB_SAMPLED] * 3, "Strange", connection=b"Lab ")),
        "Strange.*tables",
    ),
    "cmyk.png": (profiled(profiles.icc(P3, [profiles.SRGB_SAMPLED] * 3, "Press", space=b"CMYK")), "ICC"),
    "grey-for-colours.tif": (stored.tiff(np.full((4, 4, 3), 9), 8, 2, [(34675, 1, list(GREY))]), "Dot gain.*GRAY"),
    "black.png": (profiled(profiles.icc(P3, [profiles.curve(samples=[0, 0.1])] * 3)), "black to white"),
    "pq.png": (stored.png(np.zeros((4, 4, 3), np.uint8), [(b"cICP", bytes([9, 16, 0, 1]))]), "9 and 16"),
    "video.png": (stored.png(np.zeros((4, 4, 3), np.uint8), [(b"cICP", bytes([1, 13, 0, 0]))]), "video"),
    "gamma.png": (stored.png(np.zeros((4, 4, 3), np.uint8), [stored.gama(9)]), "gamma of 9"),
    "curve.tif": (stored.tiff(np.full((4, 4, 3), 9), 8, 2, [(301, 3, [7] * 256)]), "301"),
    "white.tif": (stored.tiff(np.full((4, 4, 3), 9), 8, 2, [(318, 5, [[34, 100], [35, 100]])]), "318"),
    "log.exr": (exr_with(string("colorInteropID", "ocio:acescct_ap1_scene")), "acescct"),
    "data.exr": (exr_with(string("colorInteropID", "data")), "'data'"),
}


@pytest.mark.parametrize("name", UNCERTAIN)
def test_a_space_that_cannot_be_converted_is_refused_by_its_name(tmp_path, name):
    content, says = UNCERTAIN[name]
    (tmp_path / name).write_bytes(content)
    with pytest.raises(FaceZipError, match=f"{name}: its colours are .*{says}.*sRGB"):
        read_texture(tmp_path / name)


@pytest.mark.parametrize("name", UNCERTAIN)
def test_numbers_that_are_no_colours_do_not_ask_for_a_space(tmp_path, name):
    content, _ = UNCERTAIN[name]
    (tmp_path / name).write_bytes(content)
    image = oiio.ImageInput.open(str(tmp_path / name))
    np.testing.assert_array_equal(decode(tmp_path / name), image.read_image(oiio.UNKNOWN))


def test_colours_outside_of_srgb_are_refused_where_they_are_many(tmp_path):
    greens = np.zeros((10, 10, 3), np.uint8)
    greens[..., 1] = 255
    greens[1:, :, :] = 128
    chunk = (b"cICP", bytes([12, 13, 0, 1]))
    (tmp_path / "many.png").write_bytes(stored.png(greens, [chunk]))
    with pytest.raises(FaceZipError, match="many.png: 10% of its colours.*outside of sRGB"):
        read_texture(tmp_path / "many.png")
    greens[0, 1:] = 128
    (tmp_path / "one.png").write_bytes(stored.png(greens, [chunk]))
    np.testing.assert_array_equal(read_texture(tmp_path / "one.png")[0, 0], [0, 255, 0])


def test_ranges_are_kept_through_primaries(tmp_path):
    light = np.linspace(-0.5, 2, 24).astype(np.float32).reshape(2, 4, 3)
    channels = {name: (light[..., c], 1) for c, name in enumerate("RGB")}
    (tmp_path / "a.exr").write_bytes(stored.exr(channels, (2, 4), attributes=[chromaticities("ACEScg")]))
    kept = filled(colour_bands(tmp_path / "a.exr", keeps_range=True))
    meant = colour.RGB_to_RGB(light, "ACEScg", "sRGB", chromatic_adaptation_transform="Bradford")
    np.testing.assert_allclose(kept, encode_srgb(meant), atol=2e-3)
    with pytest.raises(FaceZipError, match="-0.5 to 2"):
        read_texture(tmp_path / "a.exr")


def test_numbers_of_an_image_in_gltf_are_srgb_whatever_it_states(tmp_path):
    texels = RNG.integers(0, 256, (6, 7, 3)).astype(np.uint8)
    for name, content in {
        "gamma.png": stored.png(texels, [stored.gama(1)]),
        "black.png": UNCERTAIN["black.png"][0],
    }.items():
        (tmp_path / name).write_bytes(content)
        as_they_are = filled(colour_bands(tmp_path / name, ignores_space=True))
        np.testing.assert_array_equal(as_they_are, decode(tmp_path / name))
