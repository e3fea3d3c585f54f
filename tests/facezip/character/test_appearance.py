"""A texture that is empty, or turned against the neutral's, is asked about; one that only shows another face is not."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facezip.character.appearance import seen
from facezip.character.features import FLIPS
from facezip.character.loading import load_character, save_character
from facezip.character.tiles import FIRST_TILE
from facezip.files.images import write_texture
from scenes.character import make_character
from scenes.tiles import in_tiles

CAPTURE = Path(__file__).parents[4] / "shared" / "data" / "capture_a"
MAPS = ("normal", "roughness")


@pytest.fixture(scope="module")
def people():
    """Different people with the noise and the misregistration of a bad capture, and all expressions that have names."""
    return [make_character(128, 20, seed, nuisances=2, maps=() if seed else MAPS) for seed in (0, 3)]


def changed(character, n, change, map="albedo", tile=FIRST_TILE):
    """The character with one texture of one expression changed."""
    stack = character.stacks[map, tile]
    textures = stack.textures.copy()
    textures[n] = change(textures[n])
    return replace(character, stacks={**character.stacks, (map, tile): replace(stack, textures=textures)})


def test_expressions_are_not_accused_of_what_they_show(people):
    for character in people:
        for tiles in ((1, 1), (2, 1)):
            assert seen(in_tiles(character, *tiles)) == ()


def test_a_real_capture_has_nothing_of_the_kind():
    if not CAPTURE.is_dir():
        pytest.skip("real scans lie in ../shared, which is not here")
    assert seen(load_character(CAPTURE)) == ()


@settings(max_examples=6, deadline=None)
@given(st.integers(0, 1), st.floats(0.3, 0.99), st.booleans())
def test_an_inverted_mask_is_asked_about_and_a_narrow_one_is_not(people, person, threshold, on_tiles):
    character = people[person]
    face = (character.first.mask >= threshold).astype(np.float32)

    def masked(mask):
        stacks = {key: replace(stack, mask=mask) for key, stack in character.stacks.items()}
        scans = replace(character, stacks=stacks)
        return seen(in_tiles(scans, 2, 1) if on_tiles else scans)

    assert masked(face) == ()
    notes = masked(1 - face)
    assert notes
    assert all(note.asks and "mask" in note.words and "invert it" in note.words for note in notes)


@settings(max_examples=6, deadline=None)
@given(st.integers(0, 1), st.permutations(range(20)))
def test_a_mesh_that_is_anothers_is_named_but_not_where_textures_alone_differ(people, person, order):
    character, (one, other) = people[person], sorted(order[:2])
    meshes = character.meshes

    def of(vertices):
        return seen(replace(character, meshes=replace(meshes, vertices=vertices)))

    vertices = meshes.vertices.copy()
    vertices[other] = vertices[one]
    (note,) = of(vertices)
    assert (note.file, note.asks) == (character.expressions[other], True)
    assert note.words.startswith(f"its mesh is that of '{character.expressions[one]}', vertex for vertex")
    vertices[other] = meshes.neutral
    (note,) = of(vertices)
    assert note.words.startswith("its mesh is the neutral's")
    assert of(np.broadcast_to(meshes.neutral, vertices.shape)) == ()


@pytest.mark.parametrize("inside_out", ["mirrored", "reversed"])
def test_a_head_that_is_inside_out_is_named(people, inside_out):
    character = people[0]
    meshes = character.meshes
    if inside_out == "mirrored":
        mirror = np.array([-1, 1, 1], np.float32)
        meshes = replace(meshes, neutral=meshes.neutral * mirror, vertices=meshes.vertices * mirror)
    else:
        topology = meshes.topology
        reversed_faces = {name: getattr(topology, name)[:, ::-1].copy() for name in ("faces", "face_uv")}
        meshes = replace(meshes, topology=replace(topology, **reversed_faces))
    (note,) = seen(replace(character, meshes=meshes))
    assert note.asks
    assert note.words.startswith("its triangles face inwards")


@pytest.mark.parametrize(("channels", "colours"), [((1,), "green"), ((0,), "red"), ((0, 1), "red and green")])
def test_a_normal_map_that_goes_the_other_way_is_named(people, channels, colours):
    def turned(texels):
        texels = texels.copy()
        for channel in channels:
            texels[..., channel] = np.iinfo(texels.dtype).max - texels[..., channel]
        return texels

    (note,) = seen(changed(people[0], 7, turned, "normal"))
    assert (note.file, note.asks) == (people[0].expressions[7], True)
    assert note.words.startswith(f"its normal has {colours} the other way than the neutral's")


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 1), st.integers(0, 19), st.sampled_from([*FLIPS]))
def test_a_turned_texture_is_named_with_how_it_lies(people, person, n, how):
    character = people[person]
    (note,) = seen(changed(character, n, lambda texels: texels[FLIPS[how]]))
    assert note.file == character.expressions[n]
    assert note.words.startswith(f"its albedo is {how} against")
    assert note.asks


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 19), st.sampled_from(["albedo", *MAPS]), st.sampled_from([0, 1, 90]))
def test_a_texture_of_one_value_is_named(people, n, map, value):
    character = people[0]
    (note,) = seen(changed(character, n, lambda texels: np.full_like(texels, value), map))
    colour = "black" if map == "albedo" and value < 90 else "of one value"
    assert note.file == character.expressions[n]
    assert note.words.startswith(f"its {map} is {colour} everywhere")
    assert note.asks


def copied(character, onto, of, map="albedo", tile=FIRST_TILE):
    """The character with the texture of one expression, or of the neutral (-1), in the place of another's."""
    stack = character.stacks[map, tile]
    return changed(character, onto, lambda _: stack.neutral if of < 0 else stack.textures[of], map, tile)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 1), st.permutations(range(20)), st.sampled_from(["albedo", *MAPS]))
def test_two_expressions_that_have_one_texture_are_named(people, person, order, map):
    one, other = sorted(order[:2])
    character = people[0 if map != "albedo" else person]
    (note,) = seen(copied(character, other, one, map))
    assert note.file == character.expressions[other]
    assert note.words.startswith(f"its {map} is that of '{character.expressions[one]}', texel for texel")
    assert note.asks


@settings(max_examples=6, deadline=None)
@given(st.permutations(range(20)), st.integers(0, 127), st.integers(0, 127), st.integers(0, 2))
def test_a_texel_is_enough_for_two_textures_to_be_two(people, order, row, column, channel):
    one, other = order[:2]
    character = copied(people[0], other, one)

    def touched(texels):
        texels = texels.copy()
        texels[row, column, channel] ^= 1
        return texels

    assert seen(character) != ()
    assert seen(changed(character, other, touched)) == ()


def test_an_albedo_that_is_the_neutrals_is_named_and_a_map_that_does_not_change_is_not(people):
    (note,) = seen(copied(people[0], 3, -1))
    assert (note.file, note.asks) == (people[0].expressions[3], True)
    assert note.words.startswith("its albedo is the neutral's")
    assert seen(copied(people[0], 3, -1, "normal")) == ()
    shared = people[0]
    for n in range(1, 20):
        shared = copied(shared, n, 0, "roughness")
    assert seen(shared) == ()


def test_a_tile_that_does_not_change_is_none_but_an_albedo_without_changes_is_named(people):
    character = in_tiles(people[1], 2, 1)
    still = copied(character, 4, -1, tile=1002)
    assert seen(still) == ()
    (note,) = seen(copied(still, 4, -1))
    assert note.words.startswith("its albedo is the neutral's")
    (note,) = seen(copied(character, 4, 2, tile=1002))
    assert f"albedo on tile 1002 is that of '{character.expressions[2]}'" in note.words


def test_a_map_that_is_one_value_in_all_of_them_is_a_map_without_changes(people):
    stack = people[0].stacks["roughness", FIRST_TILE]
    flat = replace(stack, neutral=np.full_like(stack.neutral, 7), textures=np.full_like(stack.textures, 9))
    assert seen(replace(people[0], stacks={**people[0].stacks, ("roughness", FIRST_TILE): flat})) == ()


def test_what_is_turned_on_one_of_several_tiles_is_told_with_its_tile(people):
    character = in_tiles(people[1], 2, 1)
    (note,) = seen(changed(character, 4, lambda texels: texels[::-1], tile=1002))
    assert "albedo on tile 1002 is upside down" in note.words


@pytest.mark.parametrize("placeholder", ["smile.roughness.png", "smile_wide.png"])
def test_a_placeholder_excuses_no_other_texture(tmp_path, placeholder):
    character = make_character(64, 2, maps=("roughness",))
    character = replace(character, expressions=("smile", "smile_wide"))
    save_character(changed(character, 0, np.zeros_like), tmp_path / "scans")
    write_texture(tmp_path / "scans" / placeholder, np.full((1, 1, 1), 90, np.uint8))
    notes = {note.file: note.words for note in load_character(tmp_path / "scans").notes if note.asks}
    assert {*notes} == {"smile", placeholder}
    assert notes["smile"].startswith("its albedo is black everywhere")
