"""Alignment: nothing where nothing moved, and what moved where something did."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import map_coordinates

from facezip.character.alignment import THRESHOLD, alignments, worst_of
from facezip.character.displacement import GRID
from facezip.character.registration import LEAST, register
from scenes.character import make_character
from scenes.face.capture import MAPS
from scenes.tiles import in_tiles
from tests.facezip.conftest import random_character, with_albedo

SIDE = 256
MOVED = "frown"
# A displacement of so many texels is found within, and what --register leaves of it.
FOUND, LEFT = 0.25, 0.3


@pytest.fixture(scope="module")
def scans():
    """Wrinkles, blood and folds of the embedded character, registered exactly."""
    return make_character(SIDE, 6, nuisances=0)


def smooth_field(texels):
    """``(2, SIDE, SIDE)``, (right, down): a smooth displacement of about so many texels."""
    y, x = np.mgrid[:SIDE, :SIDE] / SIDE
    return texels * np.stack([np.cos(3 * y + 1), np.sin(2.5 * x)])


def moved(scans, texels):
    """The scans with one expression's content moved by the field, in all maps, and the field on the grid."""
    field, n = smooth_field(texels), scans.index(MOVED)
    stacks = {}
    for key, stack in scans.stacks.items():
        textures, most = stack.textures.copy(), np.rint(1 / stack.scale)
        places = np.indices((SIDE, SIDE)) - field[::-1]
        for c in range(stack.channels):
            shifted = map_coordinates(textures[n, ..., c].astype(np.float32), places, order=3, mode="nearest")
            textures[n, ..., c] = np.clip(np.rint(shifted), 0, most)
        stacks[key] = replace(stack, textures=textures)
    half = SIDE // GRID // 2
    return replace(scans, stacks=stacks), np.moveaxis(field[:, half :: 2 * half, half :: 2 * half], 0, 2)


def aligned(scans, names=None):
    """The alignments of a character of one tile, by expression."""
    return {name: worst_of(tiles) for name, tiles in alignments(scans, names).items()}


def error(alignment, truth):
    """Root mean square of what is wrong with a displacement, in texels."""
    gap = ((alignment.displacement - truth) ** 2).sum(axis=2)
    return np.sqrt((alignment.confidence * gap).sum() / alignment.confidence.sum())


def test_a_texture_lies_on_itself(scans):
    same = with_albedo(scans, textures=np.repeat(scans.first.neutral[None], len(scans.expressions), axis=0))
    for alignment in aligned(same).values():
        assert np.abs(alignment.displacement).max() < 1e-6
        assert alignment.known > 0.5
        assert alignment.state == "registered"


def test_wrinkles_and_blood_are_no_displacement(scans):
    for alignment in aligned(scans).values():
        assert alignment.rms < 0.25
        assert alignment.state == "registered"


@pytest.mark.parametrize("texels", [1, 2])
def test_a_smooth_displacement_is_found(scans, texels):
    other, truth = moved(scans, texels)
    alignment = aligned(other, [MOVED])[MOVED]
    assert error(alignment, truth) < 0.25
    assert error(alignment, -truth) > 1.5 * texels
    assert (alignment.state == "registered") == (texels <= THRESHOLD / 2)
    assert alignment.worst[0] >= alignment.rms


def test_the_other_expressions_are_not_accused(scans):
    other, _ = moved(scans, 2)
    found = aligned(other)
    assert [name for name, alignment in found.items() if alignment.state != "registered"] == [MOVED]


def test_the_gain_of_an_exposure_changes_little(scans):
    other, truth = moved(scans, 2)
    darker = with_albedo(other, textures=np.rint(0.8 * other.first.textures).astype(np.uint8))
    before, after = (aligned(some, [MOVED])[MOVED] for some in (other, darker))
    assert error(after, truth) < error(before, truth) + 0.05


def test_all_types_of_texels_give_the_same(scans):
    other, _ = moved(scans, 2)
    neutral, textures = other.first.neutral, other.first.textures
    wide = with_albedo(other, neutral=neutral * np.uint16(257), textures=textures * np.uint16(257))
    real = with_albedo(other, neutral=neutral / np.float32(255), textures=textures / np.float32(255))
    expected = aligned(other, [MOVED])[MOVED]
    for same in (wide, real):
        found = aligned(same, [MOVED])[MOVED]
        np.testing.assert_allclose(found.displacement, expected.displacement, atol=1e-3)


def test_textures_without_anything_in_common_are_no_evidence():
    for alignment in aligned(random_character(side=64)).values():
        assert alignment.known == alignment.rms == 0
        assert alignment.state == "unknown"


@pytest.mark.parametrize("side", [4, 32, 100])
def test_any_size_has_an_answer(side):
    assert all(np.isfinite(one.displacement).all() for one in aligned(random_character(side=side)).values())


def test_registration_takes_back_what_was_moved_and_leaves_the_rest(scans):
    other, _ = moved(scans, 2)
    found = alignments(other)
    back, names = register(other, found)
    assert MOVED in names
    assert set(names) == {name for name, tiles in found.items() if worst_of(tiles).rms > LEAST}
    for name in set(scans.expressions) - set(names):
        np.testing.assert_array_equal(back.texture(name), other.texture(name))
    assert off(back, scans) < 0.4 * off(other, scans)
    assert aligned(back, [MOVED])[MOVED].rms < LEFT


def off(scans, truth, key=("albedo", 1001)):
    """Standard deviation of what is wrong with the moved expression's texels on the face, in their unit."""
    face = truth.stacks[key].weight > 0.5
    return np.std(scans.texels(MOVED, key)[face] - truth.texels(MOVED, key)[face].astype(np.float32))


@pytest.fixture(scope="module")
def maps():
    """Albedo, normals and roughness, registered exactly."""
    return make_character(SIDE, 4, nuisances=0, maps=MAPS[:2])


@pytest.mark.parametrize("tiles", [(1, 1), (2, 1)])
def test_registration_takes_back_every_map_on_every_tile_by_what_the_albedo_says(maps, tiles):
    other, truth = in_tiles(moved(maps, 3)[0], *tiles), in_tiles(maps, *tiles)
    back, names = register(other, alignments(other))
    assert MOVED in names
    for key in truth.stacks:
        assert off(back, truth, key) < 0.5 * off(other, truth, key)
        assert back.stacks[key].textures.dtype == truth.stacks[key].textures.dtype


def test_a_finer_map_moves_as_far_on_the_skin(maps):
    """Normals of twice the size move by twice the texels: halved again, they are as near to what they should be."""
    key, other = ("normal", 1001), moved(maps, 3)[0]
    finer = resized(other, key, lambda texels: texels.repeat(2, axis=-3).repeat(2, axis=-2))
    back = register(finer, alignments(other))[0]
    halves = resized(back, key, lambda texels: texels.reshape(*texels.shape[:-3], SIDE, 2, SIDE, 2, -1).mean((-4, -2)))
    assert off(halves, maps, key) < 0.5 * off(other, maps, key)


def resized(scans, key, change):
    """The character with the texels of one map changed by a function of ``(..., H, W, C)``."""
    stack = scans.stacks[key]
    changed = replace(stack, neutral=change(stack.neutral), textures=change(stack.textures))
    return replace(scans, stacks={**scans.stacks, key: changed})
