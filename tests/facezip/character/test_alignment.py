"""Alignment: nothing where nothing moved, and what moved where something did."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import map_coordinates

from facezip.character.alignment import GRID, THRESHOLD, alignments
from facezip.character.registration import LEAST, register
from scenes.character import make_character
from tests.facezip.conftest import random_character

SIDE = 256
MOVED = "frown"


@pytest.fixture(scope="module")
def scans():
    """Wrinkles, blood and folds of the embedded character, registered exactly."""
    return make_character(SIDE, 6, nuisances=0)


def smooth_field(texels):
    """``(2, SIDE, SIDE)``, (right, down): a smooth displacement of about so many texels."""
    y, x = np.mgrid[:SIDE, :SIDE] / SIDE
    return texels * np.stack([np.cos(3 * y + 1), np.sin(2.5 * x)])


def moved(scans, texels):
    """The scans with one expression's content moved by the field, and the field on the grid."""
    field, n = smooth_field(texels), scans.index(MOVED)
    places = np.indices((SIDE, SIDE)) - field[::-1]
    textures = scans.first.textures.copy()
    for c in range(3):
        shifted = map_coordinates(scans.first.textures[n, ..., c].astype(np.float32), places, order=3, mode="nearest")
        textures[n, ..., c] = np.clip(np.rint(shifted), 0, 255)
    half = SIDE // GRID // 2
    return replace(scans, textures=textures), np.moveaxis(field[:, half :: 2 * half, half :: 2 * half], 0, 2)


def error(alignment, truth):
    """Root mean square of what is wrong with a displacement, in texels."""
    gap = ((alignment.displacement - truth) ** 2).sum(axis=2)
    return np.sqrt((alignment.confidence * gap).sum() / alignment.confidence.sum())


def test_a_texture_lies_on_itself(scans):
    same = replace(scans, textures=np.repeat(scans.first.neutral[None], len(scans.expressions), axis=0))
    for alignment in alignments(same).values():
        assert np.abs(alignment.displacement).max() < 1e-6
        assert alignment.known > 0.5
        assert alignment.registered


@pytest.mark.parametrize("quick", [False, True])
def test_wrinkles_and_blood_are_no_displacement(scans, quick):
    for alignment in alignments(scans, quick=quick).values():
        assert alignment.rms < 0.25


@pytest.mark.parametrize("texels", [1, 2])
def test_a_smooth_displacement_is_found(scans, texels):
    other, truth = moved(scans, texels)
    alignment = alignments(other, [MOVED])[MOVED]
    assert error(alignment, truth) < 0.25
    assert error(alignment, -truth) > 1.5 * texels
    assert alignment.registered == (texels <= THRESHOLD / 2)


def test_the_other_expressions_are_not_accused(scans):
    other, _ = moved(scans, 2)
    found = alignments(other)
    assert [name for name, alignment in found.items() if not alignment.registered] == [MOVED]


def test_the_gain_of_an_exposure_changes_little(scans):
    other, truth = moved(scans, 2)
    darker = replace(other, textures=np.rint(0.8 * other.textures).astype(np.uint8))
    before, after = (alignments(some, [MOVED])[MOVED] for some in (other, darker))
    assert error(after, truth) < error(before, truth) + 0.05


def test_all_types_of_texels_give_the_same(scans):
    other, _ = moved(scans, 2)
    wide = replace(other, neutral=other.neutral * np.uint16(257), textures=other.textures * np.uint16(257))
    real = replace(other, neutral=other.neutral / np.float32(255), textures=other.textures / np.float32(255))
    expected = alignments(other, [MOVED])[MOVED]
    for same in (wide, real):
        found = alignments(same, [MOVED])[MOVED]
        np.testing.assert_allclose(found.displacement, expected.displacement, atol=1e-3)


def test_textures_without_anything_in_common_are_no_evidence():
    for alignment in alignments(random_character(side=64)).values():
        assert alignment.known == alignment.rms == 0


@pytest.mark.parametrize("side", [4, 32, 100])
def test_any_size_has_an_answer(side):
    assert all(np.isfinite(one.displacement).all() for one in alignments(random_character(side=side)).values())


def test_registration_takes_back_what_was_moved_and_leaves_the_rest(scans):
    other, _ = moved(scans, 2)
    found = alignments(other)
    back, names = register(other, {**found, "smile": found["smile"]})
    assert MOVED in names
    assert set(names) == {name for name, alignment in found.items() if alignment.rms > LEAST}
    for name in set(scans.expressions) - set(names):
        np.testing.assert_array_equal(back.texture(name), other.texture(name))
    n, face = scans.index(MOVED), scans.first.mask > 0.5
    gaps = [np.std(some.textures[n][face] - scans.first.textures[n][face].astype(np.float32)) for some in (back, other)]
    assert gaps[0] < 0.4 * gaps[1]
    assert alignments(back, [MOVED])[MOVED].rms < 0.3
