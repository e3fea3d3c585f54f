"""Normals come out of every way in which files keep them, data as its numbers are; what would be guessed is refused."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from facezip import FaceZipError
from facezip.character.layout import MapFiles
from facezip.character.maps import KNOWN, normals_of
from facezip.character.texels import normal_rows, states_signs, value_rows
from facezip.files.bands import filled
from facezip.files.images import to_float
from tests.facezip.files import profiles, stored

NORMAL, ROUGHNESS = MapFiles(KNOWN["normal"]), MapFiles(KNOWN["roughness"])
ALBEDO = MapFiles(KNOWN["albedo"])


def bumps(seed=0, size=(70, 18), most=1.2):
    """Unit vectors of a bumpy skin, none of them flat everywhere."""
    return normals_of(np.random.default_rng(seed).uniform(-most, most, (*size, 2)).astype(np.float32))


def read(path, signed=False, seen=None, how=NORMAL):
    """Unit vectors of a normal map in a file."""
    fitted = filled(normal_rows(path, how, signed, np.ones((70, 18), bool) if seen is None else seen))
    return normals_of((to_float(fitted) - 0.5) * how.kind.unit)


def in_unit(vectors):
    return (vectors + 1) / 2


ONE, NONE = np.ones((70, 18)), np.zeros((70, 18))
WAYS = {
    "x, y, z": lambda x, y, z: (x, y, z),
    "and opaque": lambda x, y, z: (x, y, z, ONE),
    "and another alpha": lambda x, y, z: (x, y, z, x),
    "x and y, blue 0": lambda x, y, z: (x, y, NONE),
    "x and y, blue 1": lambda x, y, z: (x, y, ONE),
    "x in alpha, red 1": lambda x, y, z: (ONE, y, ONE, x),
    "x in alpha, red 0": lambda x, y, z: (NONE, y, NONE, x),
    "x in alpha, grey of y": lambda x, y, z: (ONE, y, y, x),
    "x in alpha, z in blue": lambda x, y, z: (NONE, y, z, x),
}


@given(way=st.sampled_from(list(WAYS)), bits=st.sampled_from([8, 16]), seed=st.integers(0, 99))
@settings(max_examples=60, deadline=None)
def test_normals_come_out_of_every_way_to_keep_them(tmp_path_factory, way, bits, seed):
    path, whole = tmp_path_factory.mktemp("normal") / "a.png", 2**bits - 1
    vectors = bumps(seed)
    channels = WAYS[way](*np.moveaxis(in_unit(vectors), -1, 0))
    path.write_bytes(stored.png(np.rint(np.stack(channels, axis=-1) * whole).astype(f"uint{bits}")))
    np.testing.assert_allclose(read(path), vectors, atol=2.5 / 255 if bits == 8 else 2e-4)


@pytest.mark.parametrize("names", ["RG", "XY", "UV", "XYZ", "RGB"])
@pytest.mark.parametrize("signed", [False, True])
def test_normals_of_floats_come_out_of_their_channels(tmp_path, names, signed):
    vectors = bumps()
    values = (vectors if signed else in_unit(vectors)).astype(np.float32)
    channels = {name: (values[..., c], 1) for c, name in enumerate(names)}
    (tmp_path / "a.exr").write_bytes(stored.exr(channels, (70, 18)))
    assert states_signs(tmp_path / "a.exr") == signed
    np.testing.assert_allclose(read(tmp_path / "a.exr", signed), vectors, atol=1e-4)


@pytest.mark.parametrize("blue", [0, 1])
def test_signed_floats_without_z_have_it_from_their_length(tmp_path, blue):
    vectors = bumps()
    channels = {"R": (vectors[..., 0], 1), "G": (vectors[..., 1], 1), "B": (np.full((70, 18), blue, np.float32), 1)}
    (tmp_path / "a.exr").write_bytes(stored.exr(channels, (70, 18)))
    np.testing.assert_allclose(read(tmp_path / "a.exr", signed=True), vectors, atol=1e-4)


def test_two_channels_of_tiff_are_x_and_y(tmp_path):
    vectors = bumps()
    texels = np.rint(in_unit(vectors[..., :2]) * 65535).astype(np.uint16)
    (tmp_path / "a.tif").write_bytes(stored.tiff(texels, 16, 1, [(338, 3, [0])]))
    np.testing.assert_allclose(read(tmp_path / "a.tif"), vectors, atol=2e-4)


def test_a_flat_map_is_flat_however_it_is_kept(tmp_path):
    for way in WAYS.values():
        channels = way(*np.moveaxis(np.broadcast_to(in_unit(np.array([0.0, 0, 1])), (70, 18, 3)), -1, 0))
        (tmp_path / "a.png").write_bytes(stored.png(np.rint(np.stack(channels, axis=-1) * 255).astype(np.uint8)))
        np.testing.assert_allclose(read(tmp_path / "a.png"), np.broadcast_to([0, 0, 1], (70, 18, 3)), atol=6e-3)


@pytest.mark.parametrize("profile", [[], [stored.gama(1)], [stored.iccp(profiles.icc([], [], space=b"GRAY"))]])
def test_numbers_of_normals_and_data_are_of_no_colour_space(tmp_path, profile):
    texels = np.rint(in_unit(bumps()) * 255).astype(np.uint8)
    (tmp_path / "a.png").write_bytes(stored.png(texels, profile))
    (tmp_path / "b.png").write_bytes(stored.png(texels))
    np.testing.assert_array_equal(read(tmp_path / "a.png"), read(tmp_path / "b.png"))
    (tmp_path / "c.png").write_bytes(stored.png(texels[..., :1], profile))
    np.testing.assert_array_equal(filled(value_rows(tmp_path / "c.png", ROUGHNESS)), texels[..., :1])


@pytest.mark.parametrize("turn", range(1, 9))
def test_turned_files_keep_their_vectors(tmp_path, turn):
    texels = np.rint(in_unit(bumps()) * 255).astype(np.uint8)
    exif = Image.Exif()
    exif[274] = turn
    Image.fromarray(texels).save(tmp_path / "a.png", exif=exif)
    seen = np.ones((18, 70) if turn > 4 else (70, 18), bool)
    (tmp_path / "b.png").write_bytes(stored.png(texels))
    meant = {1: lambda t: t, 2: lambda t: t[:, ::-1], 3: lambda t: t[::-1, ::-1], 4: lambda t: t[::-1]}
    upright = meant[(turn - 1) % 4 + 1](
        read(tmp_path / "b.png").swapaxes(0, 1) if turn > 4 else read(tmp_path / "b.png")
    )
    np.testing.assert_array_equal(read(tmp_path / "a.png", seen=seen), upright)


REFUSED = {
    "grey": (np.full((70, 18, 1), 128, np.uint8), "one channel"),
    "grey and alpha": (np.random.default_rng(0).integers(90, 160, (70, 18, 2)).astype(np.uint8), "grey and alpha"),
    "blue in the middle": (
        np.dstack([np.full((70, 18, 2), 128), np.full((70, 18), 128)]).astype(np.uint8),
        "length|normal",
    ),
    "a picture of skin": (np.broadcast_to(np.array([200, 150, 140], np.uint8), (70, 18, 3)), "length of 1"),
    "below the surface": (np.rint(in_unit(bumps() * (1, 1, -1)) * 255).astype(np.uint8), "no normal"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_no_normal_map_is_refused_by_name(tmp_path, name):
    texels, says = REFUSED[name]
    (tmp_path / "a.png").write_bytes(stored.png(np.ascontiguousarray(texels)))
    with pytest.raises(FaceZipError, match=rf"a\.png: .*({says})"):
        read(tmp_path / "a.png")


def test_texels_that_nobody_sees_hold_what_they_like(tmp_path):
    vectors, seen = bumps(), np.zeros((70, 18), bool)
    seen[20:50, 3:15] = True
    texels = np.rint(in_unit(vectors) * 255).astype(np.uint8)
    texels[~seen] = 0
    (tmp_path / "a.png").write_bytes(stored.png(texels))
    np.testing.assert_allclose(read(tmp_path / "a.png", seen=seen)[seen], vectors[seen], atol=2.5 / 255)


def test_data_whose_alpha_may_be_meant_is_refused(tmp_path):
    smooth = np.random.default_rng(0).integers(0, 256, (8, 9)).astype(np.uint8)
    metal = np.zeros_like(smooth)
    (tmp_path / "a.png").write_bytes(stored.png(np.stack([metal, metal, metal, smooth], axis=-1)))
    with pytest.raises(FaceZipError, match=r"a\.png: its alpha varies and its grey does not"):
        filled(value_rows(tmp_path / "a.png", ROUGHNESS))
    (tmp_path / "b.png").write_bytes(stored.png(np.stack([smooth, smooth, smooth, metal], axis=-1)))
    np.testing.assert_array_equal(filled(value_rows(tmp_path / "b.png", ROUGHNESS))[..., 0], smooth)


def test_colours_of_a_map_are_converted_as_those_of_the_albedo(tmp_path):
    texels = np.full((8, 9, 3), 128, np.uint8)
    (tmp_path / "a.png").write_bytes(stored.png(texels, [stored.gama(1)]))
    np.testing.assert_array_equal(filled(value_rows(tmp_path / "a.png", ALBEDO)), np.full_like(texels, 188))
