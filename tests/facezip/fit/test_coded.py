"""Fits with a codec in the loop: better than coding afterwards, and of every map on every tile."""

from dataclasses import replace

import numpy as np
import pytest

from facezip.blocks.codecs import astc, bc4, bc7, raw
from facezip.character.maps import KNOWN, angles, normals_of
from facezip.files.images import to_float
from facezip.fit.choice import whole_error
from facezip.fit.coded import coded_afterwards, fit_coded
from facezip.fit.methods import compress
from facezip.fit.storage import Storage
from facezip.pack.errors import albedo_errors, mean_rmse, model_errors
from facezip.pack.model import Part
from facezip.pack.quantise import quantise
from tests.facezip.conftest import ALBEDO_KEY, one_part, random_character, random_model
from tests.facezip.surfaces import random_surface

ASTC = Storage(astc((6, 6), "fast"), bc4())


@pytest.fixture(scope="module")
def character():
    return random_character(seed=4, expressions=9, side=48)


@pytest.fixture(scope="module")
def tiled():
    """Albedo, normals and roughness on two tiles."""
    return random_surface(seed=4, side=96, expressions=9, tiles=(2, 1))


def rmse(character, model):
    return mean_rmse(albedo_errors(character, model))


@pytest.mark.parametrize("block", [(4, 4), (8, 8)])
def test_a_fit_with_the_codec_in_the_loop_beats_coding_afterwards(character, block):
    storage = Storage(astc(block, "fast"), bc4())
    after = Storage(astc(block, "fast"))
    refined = compress(character, method="refined", differences=3, weight_scale=4)
    assert rmse(character, fit_coded(character, 3, 4, storage)) < 0.9 * rmse(
        character, coded_afterwards(refined, after)
    )


def test_the_loop_gains_over_all_maps_and_tiles(tiled):
    refined = compress(tiled, differences=3, weight_scale=4)
    loop, after = (
        whole_error(model_errors(tiled, model), {})
        for model in (fit_coded(tiled, 3, 4, ASTC), coded_afterwards(refined, ASTC))
    )
    assert loop < 0.9 * after


def test_neutrals_are_what_the_codec_gives_back_of_the_scans(tiled):
    model = fit_coded(tiled, 2, 4, ASTC, alternations=1)
    for (name, tile), stack in tiled.stacks.items():
        expected = ASTC.neutral(to_float(stack.neutral), KNOWN[name], (name, tile, "neutral"))
        np.testing.assert_array_equal(model.parts[name, tile].neutral, expected)
        assert model.weights[tile].shape == (9, 24, 12, 2)


@pytest.mark.parametrize("codec", [raw(3), bc7(), astc((4, 4), "fast")])
def test_normals_are_coded_as_the_images_that_they_are_and_not_as_slopes(codec):
    """As slopes, which span 20, they would have steps of 0.08."""
    y, x = np.mgrid[:32, :32] / np.float32(8)
    normals = normals_of(np.stack([0.3 * np.sin(x), 0.3 * np.cos(y)], axis=2).astype(np.float32))
    kind = KNOWN["normal"]
    texels = kind.encode(normals)
    back = Storage(codec).neutral(texels, kind, ("normal", 1001, "neutral"))
    slopes = np.rint(texels * 255) / np.float32(255)
    errors = [angles(kind.decode(some), normals).mean() for some in (back, slopes)]
    assert errors[0] < 0.6 * errors[1]


@pytest.mark.parametrize("in_the_loop", [True, False])
def test_the_files_are_the_blocks_that_a_sampler_sees(tiled, in_the_loop):
    storage = Storage(bc7(), bc4())
    if in_the_loop:
        model = fit_coded(tiled, 2, 4, storage, alternations=2)
    else:
        model = coded_afterwards(compress(tiled, differences=2, weight_scale=4), storage)
    # Of every map on every tile the neutral and two differences, and one of BC4 for each slot.
    assert len(storage.files) == 2 * 3 * 3 + 2 * 2
    for (name, tile), part in model.parts.items():
        for slot, difference in enumerate(part.differences):
            steps = bc7().load(storage.files[name, tile, slot], (96, 48, 3))[..., : difference.shape[2]] - 128.0
            scale = np.abs(difference).max(axis=(0, 1)) / np.abs(steps).max(axis=(0, 1))
            np.testing.assert_allclose(difference, steps * scale, rtol=1e-4, atol=1e-7)
    for tile, weights in model.weights.items():
        blocks = storage.files["weights", tile, 1].reshape(len(weights), -1)
        seen = np.stack([bc4().load(one, (*weights.shape[1:3], 1)) for one in blocks])[..., 0] / 65535
        slot = weights[..., 1]
        shares = (slot - slot.min()) / np.ptp(slot)
        np.testing.assert_allclose(shares, (seen - seen.min()) / np.ptp(seen), atol=1e-4)


def test_it_is_the_same_every_time(character):
    one, other = fit_coded(character, 2, 4, ASTC), fit_coded(character, 2, 4, ASTC)
    np.testing.assert_array_equal(one.parts[ALBEDO_KEY].differences, other.parts[ALBEDO_KEY].differences)
    np.testing.assert_array_equal(one.weights[1001], other.weights[1001])


def test_no_more_differences_than_expressions(character):
    stacks = {ALBEDO_KEY: replace(character.first, textures=character.first.textures[:2])}
    few = replace(character, expressions=character.expressions[:2], stacks=stacks)
    assert fit_coded(few, 4, 8, ASTC).footprint.differences == 2


def test_raw_storage_is_that_of_a_pack():
    model = random_model()
    stored = coded_afterwards(model, Storage(raw(3)))
    read = quantise(model).dequantised()
    np.testing.assert_allclose(stored.parts[ALBEDO_KEY].differences, read.parts[ALBEDO_KEY].differences, atol=1e-6)
    np.testing.assert_allclose(stored.parts[ALBEDO_KEY].neutral, read.parts[ALBEDO_KEY].neutral, atol=1e-7)
    np.testing.assert_allclose(stored.weights[1001], read.weights[1001], atol=1e-6)


def test_raw_storage_of_all_maps_is_that_of_a_pack(tiled):
    model = compress(tiled, differences=2)
    stored, read = coded_afterwards(model, Storage(raw(3))), quantise(model).dequantised()
    for key, part in stored.parts.items():
        np.testing.assert_allclose(part.neutral, read.parts[key].neutral, atol=2e-6)
        # A codec finds the range in the texture itself, which may use all but the last of the 127 steps.
        np.testing.assert_allclose(part.differences, read.parts[key].differences, rtol=1 / 126, atol=1e-6)


def test_bytes_are_those_of_all_maps():
    model = random_model(size=(24, 40), weights=(3, 5), slots=5, expressions=3)
    assert Storage(raw(3)).bytes_of(model) == 6 * 24 * 40 * 3 + 3 * 15 * 8
    assert Storage(bc7(), bc4()).bytes_of(model) == 6 * 24 * 40 + 3 * 5 * 2 * 8
    # Uncompressed, a texture costs the channels that it has.
    grey = one_part(Part(np.zeros((8, 8, 1), np.float32), np.zeros((2, 8, 8, 1), np.float32)), model.weights[1001])
    assert Storage(raw(3)).bytes_of(grey) == grey.footprint.bytes_on_gpu
    uniform = replace(model, weights={tile: maps[:, :1, :1] for tile, maps in model.weights.items()})
    assert Storage(raw(3)).bytes_of(uniform) == 6 * 24 * 40 * 3


@pytest.mark.parametrize(
    "codec", [raw(4), bc4(), bc7(4), astc((4, 4), "fast", 1), astc((5, 5), "fast", 4)], ids=lambda one: one.name
)
@pytest.mark.parametrize("slots", [2, 4, 6])
def test_weight_maps_take_the_blocks_of_their_codec_and_come_back(codec, slots):
    """Slots that share an image, and the last image's that are fewer."""
    storage, model = Storage(raw(3), codec), smooth_model(slots)
    back = coded_afterwards(model, storage)
    images = 3 * -(-slots // codec.channels)
    textures = (1 + slots) * model.footprint.tiles[0][0].plain
    assert storage.bytes_of(back) == textures + images * codec.bytes_of(8, 8)
    for tile, weights in model.weights.items():
        spans = np.ptp(weights, axis=(0, 1, 2))
        assert (np.abs(back.weights[tile] - weights) <= 0.15 * spans).all()


def smooth_model(slots):
    """Three expressions' weight maps of 8 x 8 texels, alike in all slots but for their ranges."""
    y, x = np.mgrid[:8, :8] / np.float32(8)
    maps = np.stack([x, y, (x + y) / 2])[..., None] * np.arange(1, slots + 1, dtype=np.float32)
    model = random_model(size=(64, 64), slots=slots)
    return replace(model, weights={tile: maps.astype(np.float32) for tile in model.weights})
