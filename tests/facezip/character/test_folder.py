"""Characters as folders: what is read, what is refused, and that nothing is changed in silence."""

import shutil
from dataclasses import replace

import numpy as np
import pytest

from facezip import ErrorCode, FaceZipError
from facezip.character.loading import load_character, save_character
from facezip.character.maps import angles
from facezip.character.tiles import FIRST_TILE
from facezip.files.images import write_texture
from facezip.files.obj import write_obj
from tests.facezip.conftest import random_character
from tests.facezip.surfaces import random_surface, write_floats


@pytest.fixture
def folder(tmp_path, surface):
    save_character(surface, tmp_path / "scans")
    return tmp_path / "scans"


def refused(folder, code, **options):
    with pytest.raises(FaceZipError) as caught:
        load_character(folder, **options)
    assert caught.value.code is code
    assert "\n" not in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize("tiles", [(1, 1), (2, 1), (2, 2)])
def test_what_is_saved_is_read_back(tmp_path, tiles):
    surface = random_surface(maps=("normal", "roughness", "specular", "cavity"), tiles=tiles)
    save_character(surface, tmp_path / "scans")
    back = load_character(tmp_path / "scans")
    assert [kind.name for kind in back.maps] == ["albedo", "cavity", "normal", "roughness", "specular"]
    assert back.tiles == surface.tiles
    assert back.neutral_bits == surface.neutral_bits
    np.testing.assert_allclose(back.meshes.topology.uv, surface.meshes.topology.uv, atol=1e-6)
    for kind in surface.maps:
        for tile in surface.tiles:
            ours, theirs = surface.stacks[kind.name, tile], back.stacks[kind.name, tile]
            if kind.is_normal:
                assert angles(kind.decode(ours.textures), kind.decode(theirs.textures)).max() < 0.5
            else:
                np.testing.assert_array_equal(theirs.textures, ours.textures)


def test_only_the_maps_that_are_wanted_are_read(folder, surface):
    (folder / "expr_2.normal.png").write_bytes(b"no image")
    albedo = load_character(folder, maps=("albedo",))
    assert [kind.name for kind in albedo.maps] == ["albedo"]
    np.testing.assert_array_equal(albedo.first.textures, surface.first.textures)


@pytest.mark.parametrize(("wanted", "known"), [({"map": "gloss"}, "albedo, normal"), ({"tile": 1005}, "1001")])
def test_a_map_or_tile_that_is_not_there_is_told_what_is(surface, wanted, known):
    with pytest.raises(FaceZipError, match=known) as caught:
        surface.texture("neutral", **wanted)
    assert caught.value.code is ErrorCode.UNKNOWN_NAME


def test_a_name_that_a_mesh_has_is_an_expressions_name(tmp_path):
    character = random_character(expressions=2)
    named = replace(character, expressions=("a", "a.normal"))
    save_character(named, tmp_path / "scans")
    back = load_character(tmp_path / "scans")
    assert [kind.name for kind in back.maps] == ["albedo"]
    assert back.expressions == ("a", "a.normal")


def test_what_is_missing_is_named(folder):
    (folder / "expr_2.roughness.png").unlink()
    assert "expr_2.roughness.png: missing" in refused(folder, ErrorCode.MISSING_FILE)


@pytest.mark.parametrize(
    ("called", "whose"),
    [
        ("expr_2.png", "the albedo of 'expr_2'"),
        ("expr_2.roughness.png", "the roughness of 'expr_2'"),
        ("neutral.png", "the albedo of the neutral"),
        ("neutral.obj", "the mesh of the neutral"),
        ("expr_2.obj", "the mesh of 'expr_2'"),
    ],
)
def test_a_folder_that_is_called_as_a_file_is_said_to_be_one(folder, called, whose):
    (folder / called).rename(folder / "moved")
    (folder / called).mkdir()
    message = refused(folder, ErrorCode.MISSING_FILE)
    assert f"{called}: is a folder, and {whose} has to be a file" in message


def test_a_folder_that_is_called_as_the_mask_is_asked_about(folder):
    (folder / "mask.tif").mkdir()
    (note,) = load_character(folder).notes
    assert (note.file, note.asks) == ("mask.tif", True)


def test_a_texture_without_a_mesh_is_named(folder):
    shutil.copy(folder / "expr_2.normal.png", folder / "typo.normal.png")
    assert "typo.obj" in refused(folder, ErrorCode.MISSING_FILE)


@pytest.mark.parametrize("layered", [False, True])
@pytest.mark.parametrize(
    ("behind", "nearest"),
    [
        ("rougness", "roughness"),
        ("1001x", "1001"),
        ("normel", "normal"),
        ("cavty.1002", "cavity.1002"),
        ("1001.normel", "normal.1001"),
        ("final", None),
        ("normal.normal", None),
    ],
)
def test_a_map_with_an_odd_name_is_told_what_there_is_and_what_is_nearest(tmp_path, behind, nearest, layered):
    save_character(random_surface(expressions=2, side=16, maps=("normal",) if layered else ()), tmp_path / "scans")
    (tmp_path / "scans" / f"expr_0.{behind}.png").touch()
    message = refused(tmp_path / "scans", ErrorCode.BAD_CHARACTER)
    assert f"expr_0.{behind}.png: '{behind}' is no map of 'expr_0'" in message
    assert "albedo, normal, roughness, specular, cavity" in message
    assert (f"call it expr_0.{nearest}.png" in message) == (nearest is not None)


def test_two_files_for_one_texture_are_refused(folder):
    shutil.copy(folder / "expr_2.normal.png", folder / "expr_2.normal.1001.png")
    assert "second texture" in refused(folder, ErrorCode.BAD_CHARACTER)


def test_a_texture_of_another_size_is_refused(folder):
    write_texture(folder / "expr_2.roughness.png", np.arange(512, dtype=np.uint16).reshape(8, 64, 1))
    assert "64x8" in refused(folder, ErrorCode.SIZE_MISMATCH)


def test_data_in_colour_is_refused_and_grey_data_is_one_channel(folder, surface):
    grey = np.repeat(surface.stacks["roughness", FIRST_TILE].textures[2], 3, axis=2)
    write_texture(folder / "expr_2.roughness.png", grey)
    assert load_character(folder).stacks["roughness", FIRST_TILE].neutral.shape[2] == 1
    grey[0, 0, 1] ^= 1
    write_texture(folder / "expr_2.roughness.png", grey)
    assert "channels differ" in refused(folder, ErrorCode.BAD_TEXELS)


@pytest.mark.parametrize("row", [10, 50])
def test_what_is_no_normal_is_refused_on_the_face_and_flat_beside_it(folder, row):
    steep = np.full((64, 64, 3), 128, np.uint8)
    steep[..., 2] = 255
    steep[row, 3] = (255, 128, 120)
    write_texture(folder / "expr_2.normal.png", steep)
    assert f"column 3, row {row}" in refused(folder, ErrorCode.BAD_TEXELS)
    mask = np.full((64, 64, 1), 255, np.uint8)
    mask[row, 3] = 0
    write_texture(folder / "mask.png", mask)
    found = load_character(folder).texture("expr_2", "normal")
    np.testing.assert_allclose(found[row, 3], (0, 0, 1), atol=2e-3)


@pytest.mark.parametrize("kind", ["half", "float"])
def test_floats_beyond_the_range_are_refused_or_kept_never_clipped(tmp_path, kind):
    character = random_character(expressions=2, side=32)
    folder = tmp_path / "scans"
    save_character(character, folder)
    rng = np.random.default_rng(0)
    values = {name: rng.uniform(-2, 3, (32, 32, 1)).astype(np.float16) for name in ("neutral", "expr_0", "expr_1")}
    for name, texels in values.items():
        write_floats(folder / f"{name}.cavity.exr", texels.astype(np.float32), kind)
    assert "--float" in refused(folder, ErrorCode.BAD_TEXELS)
    surface = load_character(folder, keep_floats=True)
    cavity = surface.maps[1]
    assert (cavity.low, cavity.high) == (min(map(np.min, values.values())), max(map(np.max, values.values())))
    for name, texels in values.items():
        np.testing.assert_allclose(surface.texture(name, "cavity"), texels.astype(np.float32), atol=1e-5)
    save_character(surface, tmp_path / "again")
    again = load_character(tmp_path / "again", keep_floats=True)
    np.testing.assert_allclose(
        again.stacks["cavity", FIRST_TILE].textures, surface.stacks["cavity", FIRST_TILE].textures, atol=1e-5
    )


def test_data_in_a_float_file_is_no_colour(tmp_path):
    folder = tmp_path / "scans"
    save_character(random_character(expressions=2, side=32), folder)
    for name in ("neutral", "expr_0", "expr_1"):
        write_floats(folder / f"{name}.roughness.exr", np.full((32, 32, 1), 0.25, np.float32))
    assert (load_character(folder).stacks["roughness", FIRST_TILE].textures == 0.25).all()


def test_what_is_not_finite_is_refused_where_it_is(folder):
    values = np.full((64, 64, 1), 0.25, np.float32)
    values[50, 3] = np.nan
    (folder / "expr_2.roughness.png").unlink()
    write_floats(folder / "expr_2.roughness.exr", values)
    assert "column 3, row 50" in refused(folder, ErrorCode.BAD_TEXELS)


@pytest.mark.parametrize("shift", [0, 0.5], ids=["signed", "unsigned"])
def test_normals_in_float_files_may_have_signs(tmp_path, shift):
    folder = tmp_path / "scans"
    save_character(random_character(expressions=2, side=32), folder)
    vector = np.array([-0.6, 0.0, 0.8], np.float32)
    for name in ("neutral", "expr_0", "expr_1"):
        write_floats(
            folder / f"{name}.normal.exr", np.tile(vector * (1 - shift) + shift, (32, 32, 1)).astype(np.float32)
        )
    found = load_character(folder).texture("neutral", "normal")
    np.testing.assert_allclose(found, np.broadcast_to(vector, found.shape), atol=1e-6)


SETTINGS = """
meshes = "geometry/{name}.obj"
mask = "masks/{tile}.png"

[maps.albedo]
files = "color/{name}_C.{tile}.png"

[maps.normal]
files = "nrm/{name}/{name}_N.{tile}.png"
green = "down"

[maps.displacement]
files = "disp/{name}.{tile}.exr"
encoding = "data"
float = true
"""


def test_character_toml_says_what_is_where(tmp_path):
    surface = random_surface(maps=("normal",), tiles=(2, 1), expressions=2)
    save_character(surface, tmp_path / "flat")
    folder = tmp_path / "scans"
    for place in ("geometry", "color", "disp", "masks"):
        (folder / place).mkdir(parents=True)
    for name in ("neutral", "expr_0", "expr_1"):
        shutil.copy(tmp_path / "flat" / f"{name}.obj", folder / "geometry")
        (folder / "nrm" / name).mkdir(parents=True)
        for tile in (1001, 1002):
            shutil.copy(tmp_path / "flat" / f"{name}.{tile}.png", folder / "color" / f"{name}_C.{tile}.png")
            normal = folder / "nrm" / name / f"{name}_N.{tile}.png"
            shutil.copy(tmp_path / "flat" / f"{name}.normal.{tile}.png", normal)
            write_floats(folder / "disp" / f"{name}.{tile}.exr", np.full((64, 32, 1), tile - 1000.5, np.float32))
    write_texture(folder / "masks" / "1001.png", np.full((64, 32, 1), 255, np.uint8))
    (folder / "character.toml").write_text(SETTINGS)
    back = load_character(folder)
    assert [kind.name for kind in back.maps] == ["albedo", "displacement", "normal"]
    assert (back.maps[1].low, back.maps[1].high) == (0, 1.5)
    np.testing.assert_array_equal(back.stacks["albedo", 1002].textures, surface.stacks["albedo", 1002].textures)
    ours, theirs = (one.texture("expr_1", "normal", 1002) for one in (surface, back))
    assert angles(theirs, ours * np.array([1, -1, 1], np.float32)).max() < 1
    assert back.stacks["albedo", 1001].mask is not None
    assert back.stacks["albedo", 1002].mask is None


@pytest.mark.parametrize(
    "text",
    [
        "meshes = 3",
        "surprise = 1",
        "[maps.albedo]\nfiles = '../{name}.png'",
        "[maps.albedo]\nfiles = '/{name}.png'",
        "[maps.Albedo]\nfiles = '{name}.png'",
        "[maps.albedo]\nfiles = '{name}.png'\nencoding = 'linear'",
        "[maps.albedo]\nfiles = '{name}.png'\ngamma = 2",
        "[maps.albedo]\nfiles = 'nowhere/{name}.png'",
        "[maps.normal]\nfiles = '{name}.png'",
        "maps = 3",
        "not toml",
    ],
)
def test_a_character_toml_that_makes_no_sense_is_refused(folder, text):
    (folder / "character.toml").write_text(text)
    assert refused(folder, ErrorCode.BAD_CHARACTER)


def test_a_mask_of_a_tile_may_be_black(tmp_path):
    surface = random_surface(tiles=(2, 1), expressions=2)
    save_character(surface, tmp_path / "scans")
    for tile, value in ((1001, 255), (1002, 0)):
        write_texture(tmp_path / "scans" / f"mask.{tile}.png", np.full((64, 32, 1), value, np.uint8))
    stacks = load_character(tmp_path / "scans").stacks
    assert stacks["normal", 1002].mask.max() == 0
    assert stacks["normal", 1001].mask.min() == 1


def test_meshes_must_share_their_topology(folder, surface):
    topology = surface.meshes.topology
    half = replace(topology, faces=topology.faces[:10], face_uv=topology.face_uv[:10])
    write_obj(folder / "expr_1.obj", surface.meshes.neutral, half)
    assert "cut off" not in refused(folder, ErrorCode.TOPOLOGY_MISMATCH)


@pytest.mark.parametrize("encoding", ["ascii", "utf-16"])
def test_a_mesh_of_another_topology_whose_last_line_does_not_end_may_be_cut_off(folder, surface, encoding):
    topology = surface.meshes.topology
    half = replace(topology, faces=topology.faces[:10], face_uv=topology.face_uv[:10])
    write_obj(folder / "expr_1.obj", surface.meshes.neutral, half)
    text = (folder / "expr_1.obj").read_text()
    (folder / "expr_1.obj").write_text(text, encoding=encoding)
    assert "cut off" not in refused(folder, ErrorCode.TOPOLOGY_MISMATCH)
    (folder / "expr_1.obj").write_text(text.strip(), encoding=encoding)
    assert "its last line does not end, so the file may be cut off" in refused(folder, ErrorCode.TOPOLOGY_MISMATCH)
