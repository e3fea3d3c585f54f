"""Textures under the names that other programs give them: whose they are, of which map, and what is never mistaken."""

import re
import shutil
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from facezip import ErrorCode, FaceZipError
from facezip.character.examination import examine_character
from facezip.character.loading import load_character, save_character
from facezip.character.map_words import meant, meant_by_folder
from facezip.character.spellings import Ambiguous, called, chosen, meanings, readings_of, words_of
from facezip.files.images import write_texture
from facezip.names import folded
from tests.facezip.surfaces import random_surface

# By map, the words that programs write behind the name of a mesh, each with what it is of: (program's own spelling).
SPELLINGS = {
    "albedo": (
        *("BaseColor", "Base_Color", "Base_color", "basecolor", "baseColor", "BC", "Albedo", "albedo", "Diffuse", "D"),
        *("diff", "Color", "Colour", "col", "diffuse_albedo", "AlbedoTransparency", "MainTex", "BaseMap", "DiffuseMap"),
    ),
    "normal": (
        *("Normal", "Normals", "normals", "NormalMap", "normal_map", "N", "NRM", "nrm", "nor", "norm", "NM"),
        *("Normal_OpenGL", "NormalGL", "nor_gl", "Normal-OpenGL"),
    ),
    "roughness": ("Roughness", "roughness", "Rough", "rough", "R", "RGH", "RoughnessMap"),
    "specular": ("Specular", "Spec", "spec", "SpecularLevel", "Specular_level", "specular_albedo"),
    "cavity": ("Cavity", "cavity", "Cav", "CavityMap"),
}
DOWN = ("Normal_DirectX", "NormalDX", "nor_dx", "Normal-DirectX")
LEFT_OUT = (
    *("AO", "ao", "AmbientOcclusion", "Ambient_Occlusion", "Mixed_AO", "Occlusion", "Height", "Displacement", "disp"),
    *("Metallic", "Metalness", "M", "Emissive", "Opacity", "SSS", "thickness", "Gloss", "Glossiness", "Smoothness"),
    *("Curvature", "ORM", "ARM", "OcclusionRoughnessMetallic", "MetallicSmoothness", "MaskMap", "metallicRoughness"),
    *("Bump", "position", "WorldNormal", "matid", "Translucency"),
)
LONG = {map: tuple(word for word in words if len(word) > 1) for map, words in SPELLINGS.items()}
# Expressions whose names look like those of maps, beside ordinary ones, with what they begin with.
TRICKY = ("Jaw", "Jaw_N", "Sad", "Sad_D", "Sad_D_N", "AO", "N", "Normal", "BaseColor", "Smile_R", "Smile", "Brow Up")
names = st.lists(
    st.sampled_from(TRICKY) | st.text(st.characters(categories=("L", "Nd")), min_size=1, max_size=8),
    min_size=1,
    max_size=6,
    unique_by=words_of,
).filter(lambda some: not {words_of(name) for name in some} & {("neutral",), ()})
maps = st.lists(st.sampled_from([*SPELLINGS]), min_size=1, max_size=3, unique=True)


@st.composite
def patterns(draw):
    """One pattern a map: words behind or before the name, as one program would write all of them."""
    before, joined = draw(st.booleans()), draw(st.sampled_from("_-. "))
    case = draw(st.sampled_from([str, str.lower, str.upper, str.title]))
    first = draw(st.sampled_from(["", "T", "TX", "ada"]))
    last = draw(st.sampled_from(["", "4k", "2048", "8K"]))
    tile = draw(st.sampled_from(["", ".{tile}", "_{tile}"]))
    found = {}
    for map in draw(maps):
        word = case(draw(st.sampled_from((LONG if before else SPELLINGS)[map])))
        parts = [first, word, "{name}", last] if before else [first, "{name}", word, last]
        found[map] = joined.join(part for part in parts if part) + tile
    return found


def read(patterns, meshes, tile):
    """Files by these patterns, of the neutral and of meshes; what is told of each."""
    written = {
        pattern.replace("{name}", name).replace("{tile}", tile) + ".png": (name, map)
        for map, pattern in patterns.items()
        for name in ("neutral", *meshes)
    }
    assume(len({*map(folded, written)}) == len(patterns) * (1 + len(meshes)))
    known = called({folded(name): name for name in ("neutral", *meshes)})
    found = chosen({file: [*readings_of(file, known)] for file in written})
    says = meanings(found.values())
    return written, found, says


@settings(max_examples=400, deadline=None)
@given(patterns(), names, st.sampled_from(["1001", "1012", "u1_v1", "U2_V1"]))
def test_every_texture_is_of_its_mesh_and_map_however_programs_call_it(patterns, meshes, tile):
    written, found, says = read(patterns, meshes, tile)
    for file, (name, map) in written.items():
        assert found[file].owner == name
        assert found[file].tile == (tile if "{tile}" in patterns[map] else "")
        assert says[found[file].like].map == map


@given(st.sampled_from(sorted({word for words in SPELLINGS.values() for word in words})), st.sampled_from("_-. "))
def test_what_joins_words_and_their_case_does_not_count(word, joined):
    parts = [part.lower() for part in re.split("[_-]", word)]
    ways = [meant(words_of(joined.join(case(part) for part in parts))) for case in (str, str.upper, str.title)]
    assert ways[0] is not None
    assert ways == [meant(tuple(parts))] * 3


@pytest.mark.parametrize("word", LEFT_OUT)
def test_a_map_that_nothing_takes_is_known_and_left_out(word):
    assert meant(words_of(word)).map == ""


@pytest.mark.parametrize("word", ["A", "S", "preview", "final", "wrinkle", "v2", "rougness"])
def test_what_may_be_several_maps_or_none_is_not_guessed(word):
    assert meant(words_of(word)) is None


def test_a_name_that_can_be_taken_apart_in_two_ways_is_refused_with_both():
    known = called({name.lower(): name for name in ("neutral", "Jaw", "Jaw_N")})
    files = ("neutral.png", "Jaw.png", "Jaw_N.png", "neutral_N.png", "Jaw_N_N.png")
    with pytest.raises(Ambiguous, match=r"Jaw_N\.png may be '\{name\}(_N)?' of 'Jaw(_N)?' or '\{name\}(_N)?' of"):
        chosen({file: [*readings_of(file, known)] for file in files})


# Names of folders, and what images in them are that are called as meshes are; None where nothing says it.
FOLDERS = {
    "albedo": (
        *(
            "textures",
            "Texture",
            "tex",
            "maps",
            "Textures_4k",
            "2048",
            "images",
            "img",
            "photos",
            "png",
            "tif_4k",
            "udim",
        ),
        *("diffuse", "Color", "colors", "albedos", "baseColor", "face_textures", "ada_albedo", "albedo_v2", "udim"),
    ),
    "normal": ("normals", "Normal_Maps", "nrm"),
    "": (
        *("dpmap", "dpmaps", "dp", "dpm", "dp_map", "disp_maps", "disps", "displace", "displaced", "displacements"),
        *("bumps", "heights", "vdisp", "microdisp", "depth", "depth_maps", "my_displacement_v2", "disp_images", "AO"),
    ),
    None: ("foo", "final", "ada", "scan_02", "wrinkle_maps", "ada_normals", "d_ada"),
}


@pytest.mark.parametrize(("map", "folder"), [(map, folder) for map, some in FOLDERS.items() for folder in some])
def test_a_folder_says_of_which_map_its_images_are_or_it_is_a_guess(map, folder):
    said = meant_by_folder(words_of(folder))
    assert (said.map, said.guessed) == (("albedo", True) if map is None else (map, False))


NAMES = ("neutral", "expr_0", "expr_1")
MAPS = ("albedo", "normal", "roughness")


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    """Two expressions, three maps, two tiles; kept, and never changed."""
    folder = tmp_path_factory.mktemp("plain") / "scans"
    save_character(random_surface(expressions=2, side=16, maps=MAPS[1:], tiles=(2, 1)), folder)
    return folder


def respelt(plain, place, patterns, meshes="{name}.obj", masks="mask.png"):
    """The same files under other names; patterns with ``{map}`` are of all maps but the albedo."""
    folder = Path(place) / "scans"
    for path in plain.iterdir():
        name, *rest = path.stem.split(".")
        tile = rest.pop() if rest and rest[-1].isdigit() else ""
        map = rest[0] if rest else "albedo"
        to = meshes if path.suffix == ".obj" else masks if name == "mask" else patterns[map]
        to = to.replace("{name}", name).replace("{tile}", tile).replace("{u}", tile[-1:])
        (folder / to).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(path, folder / to)
    return folder


def same(one, other):
    assert (one.expressions, one.tiles, one.maps) == (other.expressions, other.tiles, other.maps)
    for key in one.stacks:
        for name in ("neutral", *one.expressions):
            np.testing.assert_array_equal(one.texels(name, key), other.texels(name, key))
    return True


def all_of(pattern, *words):
    return {map: pattern.replace("{map}", word) for map, word in zip(MAPS, words, strict=True)}


SUBSTANCE = all_of("{name}_{map}.{tile}.png", "Base_color", "Normal_OpenGL", "Roughness")
STYLES = {
    "Substance Painter": (SUBSTANCE, "{name}.obj"),
    "Unreal": (all_of("T_Face_{name}_{map}_{tile}.png", "D", "N", "R"), "{name}.obj"),
    "Reality Capture": (all_of("{name}_u{u}_v1_{map}.png", "diffuse", "normal", "roughness"), "{name}.obj"),
    "before the name": (all_of("{map}_{name}.{tile}.png", "BaseColor", "Normal", "Roughness"), "{name}.obj"),
    "resolution": (all_of("{name}_{map}_4k.{tile}.png", "albedo", "nor_gl", "rough"), "{name}.obj"),
    "a folder a map": (all_of("{map}/{name}.{tile}.png", "BaseColor", "Normals", "Roughness"), "{name}.obj"),
    "a folder of textures": (all_of("textures/{name}_{map}.{tile}.png", "d", "n", "r"), "meshes/{name}.obj"),
    "a folder an expression": (
        all_of("{name}/{map}.{tile}.png", "baseColor", "normal", "roughness"),
        "{name}/scan.obj",
    ),
    "one folder an expression": (all_of("{name}/{name}_{map}.{tile}.png", "BC", "NRM", "RGH"), "{name}/{name}.obj"),
}


@pytest.mark.parametrize("style", STYLES)
def test_a_character_in_the_style_of_a_program_is_read_and_each_texture_has_a_note(plain, tmp_path, style):
    folder = respelt(plain, tmp_path, *STYLES[style])
    found = load_character(folder)
    assert same(load_character(plain), found)
    textures = {path.relative_to(folder).as_posix() for path in folder.rglob("*.png") if "mask" not in path.name}
    assert textures <= {note.file for note in found.notes}
    assert not any(note.asks for note in found.notes)


@settings(max_examples=len(STYLES), deadline=None)
@given(st.sampled_from([*STYLES]), st.sampled_from(["face01", "neutral"]), st.booleans())
def test_the_settings_that_doctor_prints_read_the_files_that_are_there(plain, style, neutral, unknown):
    if unknown:
        assume(style == "Substance Painter")
    with tempfile.TemporaryDirectory() as place:
        folder = respelt(plain, place, *STYLES[style])
        for path in sorted(folder.rglob("*neutral*"), key=lambda path: -len(path.parts)):
            path.rename(path.with_name(path.name.replace("neutral", neutral)))
        # What makes it refuse the folder: no neutral, or a word that is of no map.
        if unknown or neutral == "neutral":
            for path in [*folder.rglob("*expr_0*.png"), *folder.rglob("expr_0/*.png")]:
                shutil.copy(path, path.with_name(f"{path.stem.split('.')[0]}_preview.png"))
                break
        diagnosis = examine_character(folder)
        assert diagnosis.refusals
        text = diagnosis.character_toml
        assert ('neutral = ""' in text) == (neutral == "face01")
        (folder / "character.toml").write_text(text.replace('neutral = ""', f'neutral = "{neutral}"'))
        assert same(load_character(plain), load_character(folder))


@pytest.mark.parametrize("meshes", ["SM_{name}.obj", "ada-{name}_v2.obj"])
def test_words_that_all_meshes_share_need_not_be_in_the_names_of_textures(plain, tmp_path, meshes):
    found = load_character(respelt(plain, tmp_path, all_of("T_{name}_{map}.{tile}.png", "BC", "N", "R"), meshes))
    whole = load_character(plain)
    for name in ("expr_0", "expr_1"):
        np.testing.assert_array_equal(found.texture(meshes[:-4].replace("{name}", name)), whole.texture(name))


def test_maps_in_a_folder_beside_textures_are_never_passed_over(plain, tmp_path):
    folder = respelt(plain, tmp_path, SUBSTANCE | {"albedo": "{name}.{tile}.png", "normal": "Normal/{name}.{tile}.png"})
    notes = [note for note in load_character(folder).notes if note.asks]
    assert {note.file for note in notes} == {f"Normal/{name}.{tile}.png" for name in NAMES for tile in (1001, 1002)}
    shutil.copytree(folder / "Normal", folder / "old")
    assert [note for note in load_character(folder).notes if note.asks] == notes


BESIDE = all_of("models_reg/{name}{map}.{tile}.png", "", "_n", "_r")


@settings(max_examples=12, deadline=None)
@given(st.sampled_from(["dpmap", "foo", "aaa", "Displacement", "zzz/{name}"]))
def test_images_in_a_folder_of_any_other_name_never_take_the_place_of_those_beside_the_meshes(plain, other):
    with tempfile.TemporaryDirectory() as place:
        folder = respelt(plain, place, BESIDE, "models_reg/{name}.obj")
        for path in [*folder.rglob("*_r.*.png")]:
            name, _, tile, _ = re.split(r"_r|\.", path.name)
            to = folder / other.replace("{name}", name) / f"{name}.{tile}.png"
            to.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(path, to)
        found = load_character(folder)
        assert same(load_character(plain), found)
        left_out = [note for note in found.notes if "left out" in note.words and not note.asks]
        assert len(left_out) == 2 * len(NAMES)
        assert all(note.file.startswith(other.split("/")[0]) for note in left_out)


@pytest.mark.parametrize("masked", [False, True])
def test_images_that_are_in_a_folder_of_an_unknown_name_alone_are_asked_about(plain, tmp_path, masked):
    folder = respelt(
        plain, tmp_path, SUBSTANCE | {"albedo": "foo/{name}.{tile}.png", "normal": "foo/{name}_n.{tile}.png"}
    )
    for path in folder.glob("*Roughness*"):
        path.rename(folder / "foo" / path.name)
    if masked:
        for tile in (1001, 1002):
            write_texture(folder / f"mask.{tile}.png", np.full((16, 8, 1), 255, np.uint8))
    found = load_character(folder)
    np.testing.assert_array_equal(found.texture("expr_1"), load_character(plain).texture("expr_1"))
    asked = {note.file for note in found.notes if note.asks}
    assert asked == {f"foo/{name}.{tile}.png" for name in NAMES for tile in (1001, 1002)}


def test_images_in_a_folder_of_displacement_alone_are_no_albedo(plain, tmp_path):
    folder = respelt(plain, tmp_path, all_of("dpmap/{name}{map}.{tile}.png", "", "_n", "_r"))
    assert "no albedo of the neutral" in str(refused(folder))


SPACES = (
    "ACEScg",
    "acescct",
    "ACES2065-1",
    "AdobeRGB",
    "Adobe_RGB",
    "Display-P3",
    "rec2020",
    "Rec.709",
    "linear",
    "lin",
)


@settings(max_examples=30, deadline=None)
@given(
    st.sampled_from([*SPACES, "lin_srgb", "linear_rec709", "ProPhoto"]),
    st.sampled_from(["{name}.{tile}_{space}.png", "{name}_BaseColor_{space}.{tile}.png", "{space}/{name}.{tile}.png"]),
    st.booleans(),
)
def test_a_name_that_states_another_colour_space_is_refused_with_that(plain, space, pattern, everywhere):
    data = all_of("{name}_{map}.{tile}.png", "", "N", "R")
    if everywhere and "/" not in pattern:
        data = all_of("{name}_{map}_{space}.{tile}.png", "", "N", "R")
    if "/" in pattern:
        data = {map: f"nothing/{file}" for map, file in data.items()}
    with tempfile.TemporaryDirectory() as place:
        patterns = {map: file.replace("{space}", space) for map, file in (data | {"albedo": pattern}).items()}
        diagnosis = examine_character(respelt(plain, place, patterns))
    asked = [refusal.words for refusal in diagnosis.refusals if "convert it to sRGB" in refusal.words]
    assert len(asked) == 2 * len(NAMES)
    assert not any("is no map" in refusal.words for refusal in diagnosis.refusals)
    assert "[maps.albedo]" not in diagnosis.character_toml
    assert "# Colours of another space than sRGB, to be converted first:" in diagnosis.character_toml


@pytest.mark.parametrize("space", [*SPACES, "sRGB"])
def test_data_have_no_colour_space_whatever_their_names_say(plain, tmp_path, space):
    patterns = all_of("{name}_{map}_{tile}.png", "BaseColor_sRGB", f"Normal_{space}", f"{space}_Roughness")
    assert same(load_character(plain), load_character(respelt(plain, tmp_path, patterns)))


SIZES = {
    "albedo alone": ({"albedo": "{name}_1024.png"}, "mask.png"),
    "a mask likewise": ({"albedo": "{name}.1024.png"}, "mask_1024.png"),
    "by custom": ({"albedo": "{name}-1024.png", "normal": "{name}.normal-1024.png"}, "mask.png"),
    "in words": ({"albedo": "{name}_1024_BaseColor.png", "normal": "{name}_N_1024.png"}, "mask_1024.png"),
    "in a folder": ({"albedo": "tex/{name}_1024.png", "normal": "tex/{name}_N_2048.png"}, "mask_1024.png"),
    "of some": ({"albedo": "{name}_1024.png", "normal": "{name}_N.png"}, "mask.png"),
}


@pytest.mark.parametrize("style", SIZES)
def test_a_number_that_is_also_a_size_is_that_where_all_images_say_no_other(tmp_path, style):
    patterns, mask = SIZES[style]
    whole = tmp_path / "whole"
    save_character(
        random_surface(expressions=2, side=16, maps=tuple(map for map in patterns if map != "albedo")), whole
    )
    write_texture(whole / "mask.png", np.full((16, 16, 1), 200, np.uint8))
    folder = respelt(whole, tmp_path / "respelt", {**patterns}, masks=mask)
    found = load_character(folder)
    assert same(load_character(whole), found)
    assert found.masked


@pytest.mark.parametrize("pattern", ["{name}.{tile}.png", "T_{name}_BC_{tile}.png"])
def test_beside_tiles_it_is_a_tile(tmp_path, pattern):
    whole = tmp_path / "whole"
    save_character(random_surface(expressions=2, side=16, maps=(), tiles=(2, 1)), whole)
    folder = respelt(whole, tmp_path / "respelt", {"albedo": pattern})
    for path in folder.glob("*1002*"):
        path.rename(path.with_name(path.name.replace("1002", "1024")))
    assert "onto tile 1002, which has no textures" in str(refused(folder))


def refused(folder):
    with pytest.raises(FaceZipError) as caught:
        load_character(folder)
    assert "\n" not in str(caught.value)
    return caught.value


def test_normals_whose_name_says_directx_have_green_down(plain, tmp_path):
    up = load_character(respelt(plain, tmp_path / "up", SUBSTANCE)).texture("expr_1", "normal")
    down = respelt(plain, tmp_path / "down", SUBSTANCE | {"normal": "{name}_Normal_DirectX.{tile}.png"})
    np.testing.assert_allclose(load_character(down).texture("expr_1", "normal"), up * (1, -1, 1), atol=2e-2)
    for path in sorted(respelt(plain, tmp_path / "up2", SUBSTANCE).glob("*OpenGL*")):
        shutil.copy(path, down / path.name)
    both = load_character(down)
    np.testing.assert_array_equal(both.texture("expr_1", "normal"), up)
    assert any("left out: normals with green down" in note.words for note in both.notes)


@settings(max_examples=10, deadline=None)
@given(st.sampled_from(LEFT_OUT))
def test_maps_that_nothing_takes_are_left_out_with_a_note(plain, word):
    with tempfile.TemporaryDirectory() as place:
        folder = respelt(plain, place, SUBSTANCE)
        shutil.copy(folder / "expr_1_Roughness.1001.png", folder / f"expr_1_{word}.1001.png")
        found = load_character(folder)
        assert same(load_character(plain), found)
        assert [note.file for note in found.notes if "left out" in note.words] == [f"expr_1_{word}.1001.png"]


def test_two_textures_of_one_map_are_refused(plain, tmp_path):
    folder = respelt(plain, tmp_path, SUBSTANCE)
    shutil.copy(folder / "expr_1_Base_color.1001.png", folder / "expr_1_Diffuse.1001.png")
    error = refused(folder)
    assert error.code is ErrorCode.BAD_CHARACTER
    assert "expr_1_Diffuse.1001.png: a second texture beside expr_1_Base_color.1001.png" in str(error)


def test_a_texture_that_is_missing_is_called_as_the_others_are(plain, tmp_path):
    folder = respelt(plain, tmp_path, SUBSTANCE)
    (folder / "expr_1_Roughness.1002.png").unlink()
    assert "expr_1_Roughness.1002.png: missing" in str(refused(folder))


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[maps.albedo]\nfiles = '{name}_Base_colour.{tile}.png'", "maps.albedo = '{name}_Base_colour.{tile}.png'"),
        ("meshes = 'SM_{name}.obj'\n[maps.albedo]\nfiles = '{name}_Base_color.{tile}.png'", "meshes = 'SM_{name}.obj'"),
        ("mask = 'face.png'\n[maps.albedo]\nfiles = '{name}_Base_color.{tile}.png'", "mask = 'face.png'"),
        ("meshes = '{name}.obj'", "add [maps.albedo]"),
        ("neutral = 'rest'", "'rest' is neutral in character.toml, and there is no mesh of that name"),
        ("neutral = 3", "neutral is the name"),
    ],
)
def test_what_in_character_toml_is_like_no_file_is_named(plain, tmp_path, text, says):
    folder = respelt(plain, tmp_path, SUBSTANCE)
    (folder / "character.toml").write_text(text)
    error = refused(folder)
    assert error.code is ErrorCode.BAD_CHARACTER
    assert says in str(error)


def test_the_mesh_of_the_face_at_rest_may_be_said(plain, tmp_path):
    folder = respelt(plain, tmp_path, SUBSTANCE)
    for path in folder.glob("neutral*"):
        path.rename(path.with_name(path.name.replace("neutral", "face01")))
    (folder / "character.toml").write_text('neutral = "Face01.obj"')
    assert same(load_character(plain), load_character(folder))
