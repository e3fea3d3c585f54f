"""One character in a folder whose names are spelt otherwise: the same texels, or a sentence that names the file."""

import re
import shutil
import tempfile
import unicodedata
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facezip import ErrorCode, FaceZipError
from facezip.character.layout import holds_neutral
from facezip.character.loading import load_character, save_character
from facezip.files.images import read_texture, write_texture
from facezip.files.opening import OTHER_SUFFIXES
from tests.facezip.surfaces import random_surface

LIGHT = settings(max_examples=15, deadline=None)
NAMES = ("neutral", "lächeln", "expr_1")


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    """Two expressions, two maps, two tiles, masks; kept, and never changed."""
    from dataclasses import replace

    folder = tmp_path_factory.mktemp("plain") / "scans"
    save_character(
        replace(random_surface(expressions=2, side=16, maps=("roughness",), tiles=(2, 1)), expressions=NAMES[1:]),
        folder,
    )
    for tile in (1001, 1002):
        write_texture(folder / f"mask.{tile}.png", np.arange(128, dtype=np.uint8).reshape(16, 8, 1) + 100)
    return folder


def same(one, other):
    assert {*one.expressions} == {*other.expressions}
    assert one.tiles == other.tiles
    for key, stack in one.stacks.items():
        for name in ("neutral", *one.expressions):
            np.testing.assert_array_equal(one.texels(name, key), other.texels(name, key))
        np.testing.assert_array_equal(stack.mask, other.stacks[key].mask)
    for name in ("neutral", *one.expressions):
        np.testing.assert_array_equal(one.mesh_vertices(name), other.mesh_vertices(name))
    return True


def respelt(plain, place, spell):
    folder = Path(place) / "scans"
    folder.mkdir()
    for path in plain.iterdir():
        shutil.copy(path, folder / spell(path.name))
    return folder


@LIGHT
@given(st.data())
def test_case_and_unicode_form_of_names_do_not_count(plain, data):
    def spell(name):
        stem, suffix = name.rsplit(".", 1)
        cases = st.sampled_from([str, str.upper, str.title]) if not stem.startswith(NAMES[1:]) else st.just(str)
        stem = unicodedata.normalize(data.draw(st.sampled_from(["NFC", "NFD"])), data.draw(cases)(stem))
        return f"{stem}.{data.draw(st.sampled_from([suffix, suffix.upper(), suffix.title()]))}"

    with tempfile.TemporaryDirectory() as place:
        assert same(load_character(plain), load_character(respelt(plain, place, spell)))


@LIGHT
@given(
    st.sampled_from([".{0}", "_{0}", "-{0}", "_u{1}_v1", "_U{1}_V1", ".u{1}_v1", "_u{2}_v0"]),
    st.sets(st.sampled_from([".DS_Store", "Thumbs.db", "desktop.ini", "._{}", ".{}.swp", ".hidden.png", "~${}"])),
)
def test_tiles_of_other_programs_are_read_and_litter_is_not(plain, tile, litter):
    def spell(name):
        number = re.search(r"\.(100(\d))\.", name)
        return name.replace(f".{number[1]}", tile.format(number[1], number[2], int(number[2]) - 1)) if number else name

    with tempfile.TemporaryDirectory() as place:
        folder = respelt(plain, place, spell)
        for pattern in litter:
            for path in [path for path in folder.iterdir() if not path.name.startswith((".", "~"))]:
                (folder / pattern.format(path.name)).write_bytes(bytes(50))
        assert same(load_character(plain), load_character(folder))


@LIGHT
@given(st.sampled_from(["Base", "basis", "000_neutral", "Neutral_Face", "rest.001", "REST"]))
def test_a_neutral_under_another_certain_name_is_taken_and_said(plain, called):
    with tempfile.TemporaryDirectory() as place:
        folder = respelt(plain, place, lambda name: name.replace("neutral", called))
        assert holds_neutral(folder)
        found = load_character(folder)
        assert same(load_character(plain), found)
        assert [note.words for note in found.notes if note.file == f"{called}.obj"] == ["taken for the neutral"]


def refused(folder):
    with pytest.raises(FaceZipError) as caught:
        load_character(folder)
    return caught.value


def test_two_meshes_that_may_be_the_neutral_are_named(plain, tmp_path):
    folder = respelt(plain, tmp_path, lambda name: name.replace("neutral", "base").replace("expr_1", "rest"))
    error = refused(folder)
    assert "base.obj" in str(error)
    assert "rest.obj" in str(error)


@pytest.mark.parametrize("forms", [("NFC", "NFD"), (str.upper, str.lower)], ids=["form", "case"])
def test_two_meshes_of_one_name_to_a_file_system_are_refused(plain, tmp_path, forms):
    folder = respelt(plain, tmp_path, str)
    for form in forms:
        name = unicodedata.normalize(form, "grüße") if isinstance(form, str) else form("grusse")
        shutil.copy(folder / "expr_1.obj", folder / f"{name}.obj")
    if sum(path.name[0] in "gG" for path in folder.iterdir()) < 2:
        pytest.skip("this file system takes the two for one")
    assert "differs" in str(refused(folder))


@LIGHT
@given(st.sampled_from(["masks", "Mask_face", "face_mask", "mask (1)", "expr_1.mask", "head-mask"]), st.booleans())
def test_an_image_that_is_called_nearly_like_the_mask_is_never_passed_over(plain, called, unread):
    with tempfile.TemporaryDirectory() as place:
        folder = respelt(plain, place, str)
        (folder / "mask.1001.png").rename(folder / f"{called}.{'psd' if unread else 'png'}")
        first, note = load_character(folder).notes
        assert first.asks
        assert first.file == f"{called}.{'psd' if unread else 'png'}"
        assert note.words.startswith("its tile has no mask, as others have")


@LIGHT
@given(
    st.sampled_from(OTHER_SUFFIXES),
    st.sampled_from(["neutral.1001", "expr_1.1002", "lächeln.roughness.1001", "mask.1001"]),
)
def test_a_texture_of_a_format_that_is_not_read_is_refused_by_its_name(plain, suffix, stem):
    with tempfile.TemporaryDirectory() as place:
        folder = respelt(plain, place, str)
        (folder / f"{stem}.png").rename(folder / f"{stem}{suffix}")
        error = refused(folder)
        assert error.code is ErrorCode.UNREADABLE_IMAGE
        assert f"{stem}{suffix}" in str(error)


def test_one_beside_a_texture_that_is_read_changes_nothing(plain, tmp_path):
    folder = respelt(plain, tmp_path, str)
    (folder / "expr_1.1001.psd").write_bytes(b"8BPS")
    assert load_character(folder).notes == ()


def test_a_mask_without_a_number_is_that_of_the_only_tile_and_asks_where_there_are_several(plain, tmp_path):
    folder = respelt(plain, tmp_path, lambda name: name.replace("mask.1001", "mask"))
    (note,) = load_character(folder).notes
    assert note.asks
    assert note.file == "mask.png"
    only = tmp_path / "only"
    save_character(random_surface(expressions=2, side=16, maps=()), only)
    for path in only.glob("*.png"):
        path.rename(path.with_suffix(".1001.png"))
    write_texture(only / "mask.png", np.full((16, 16, 1), 200, np.uint8))
    assert load_character(only).first.mask.max() == np.float32(200 / 255)


@pytest.mark.parametrize("name", ["expr_1.1003.png", "lächeln.roughness.1011.png"])
def test_a_texture_on_a_tile_that_the_neutral_has_not_is_refused(plain, tmp_path, name):
    folder = respelt(plain, tmp_path, str)
    shutil.copy(folder / "expr_1.1001.png", folder / name)
    assert name in str(refused(folder))


def test_what_is_missing_is_called_as_its_neighbours_are(plain, tmp_path):
    folder = respelt(plain, tmp_path, lambda name: name.replace(".1001", "_u1_v1").replace(".1002", "_u2_v1"))
    (folder / "expr_1_u2_v1.png").unlink()
    assert "expr_1_u2_v1.png: missing" in str(refused(folder))


@pytest.mark.parametrize("suffix", [".fbx", ".ply", ".GLB"])
def test_a_folder_without_meshes_that_are_read_is_told_which_are_there(plain, tmp_path, suffix):
    folder = respelt(plain, tmp_path, lambda name: name.replace(".obj", suffix))
    assert suffix in str(refused(folder))


def test_a_mask_in_the_albedos_alpha_is_said_and_asks_where_there_is_no_other(plain, tmp_path):
    folder = respelt(plain, tmp_path, str)
    rng = np.random.default_rng(0)
    for name in NAMES:
        for tile in (1001, 1002):
            path = folder / f"{name}.{tile}.png"
            texels = read_texture(path)
            alpha = rng.integers(0, 255, (16, 8, 1), np.uint8) if tile == 1001 else np.full((16, 8, 1), 255, np.uint8)
            write_texture(path, np.concatenate([texels, alpha], axis=2))
    said = {note.file: note.asks for note in load_character(folder).notes}
    assert said == {f"{name}.1001.png": False for name in NAMES}
    (folder / "mask.1001.png").unlink()
    assert all(note.asks for note in load_character(folder).notes)


def test_the_channel_of_a_mask_is_said_where_it_is_not_the_only_one(plain, tmp_path):
    folder = respelt(plain, tmp_path, str)
    grey = read_texture(folder / "mask.1001.png")
    write_texture(folder / "mask.1001.png", np.concatenate([0 * grey, grey, 0 * grey], axis=2))
    assert same(load_character(plain), found := load_character(folder))
    assert [note.words for note in found.notes] == ["its channel G is the mask"]


MAPS = {"albedo": "", "roughness": ".roughness"}
SETTINGS = """
meshes = "Geometry/{name}.obj"
mask = "masks/{tile}.png"
[maps.albedo]
files = "colour/{name}_C_{tile}.png"
[maps.roughness]
files = "{name}/rough.{tile}.PNG"
"""


@LIGHT
@given(st.sampled_from(["{0}", "u{1}_v1", "U{1}_V1", "u{1}v1"]), st.sampled_from(["NFC", "NFD"]), st.booleans())
def test_patterns_of_character_toml_know_the_same_names(plain, tile, form, upper):
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "scans"
        for path in plain.iterdir():
            name, number = path.stem.split(".")[0], path.stem[-4:]
            at = tile.format(number, number[-1])
            to = f"geometry/{name}.obj"
            if path.suffix == ".png":
                to = f"{name}/rough.{at}.png" if "roughness" in path.stem else f"colour/{name}_C_{at}.png"
                to = f"masks/{at}.png" if name == "mask" else to
            whole = folder / unicodedata.normalize(form, to.replace(".png", ".PNG") if upper else to)
            whole.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(path, whole)
            (whole.parent / f"._{whole.name}").write_bytes(bytes(20))
        (folder / "character.toml").write_text(SETTINGS)
        assert same(load_character(plain), load_character(folder))


@pytest.mark.parametrize(("file", "what"), [("EXPR_1.obj", "mesh"), ("EXPR_1.1001.png", "texture")])
def test_patterns_that_catch_two_files_of_one_are_refused(plain, tmp_path, file, what):
    folder = respelt(plain, tmp_path, str)
    maps = "".join(f'[maps.{name}]\nfiles = "{{name}}{suffix}.{{tile}}.png"\n' for name, suffix in MAPS.items())
    (folder / "character.toml").write_text(f'mask = "mask.{{tile}}.png"\n{maps}')
    assert same(load_character(plain), load_character(folder))
    shutil.copy(folder / file.lower(), folder / file)
    with pytest.raises(FaceZipError, match=rf"a second {what} beside {file}") as refused:
        load_character(folder)
    assert refused.value.code is ErrorCode.BAD_CHARACTER


def test_an_image_called_nearly_like_the_masks_beside_them_is_said_and_asks_nothing(plain, tmp_path):
    folder = respelt(plain, tmp_path, str)
    shutil.copy(folder / "mask.1001.png", folder / "mask_core.png")
    (note,) = load_character(folder).notes
    assert (note.file, note.asks) == ("mask_core.png", False)
