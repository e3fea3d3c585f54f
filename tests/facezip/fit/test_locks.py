"""Painted layers: they come back byte for byte, and the fit around them is never worse than without their slot."""

import numpy as np
import pytest
from PIL import Image

from facezip import compress, load_character, save_character
from facezip.character.samples import samples_of
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.images import write_texture
from facezip.fit.locks import Lock, read_locks
from facezip.fit.sweep import solve_textures
from facezip.pack.errors import albedo_errors, mean_rmse
from facezip.pack.parsing import read_manifest
from facezip.pack.quantise import quantise
from facezip.pack.read import read_pack
from tests.facezip.conftest import ALBEDO_KEY, random_character
from tests.facezip.fit.test_sweep import random_weights, upsampling
from tests.facezip.surfaces import random_surface
from tests.test_layered_commands import run


def painted(side, channels=3, seed=0):
    """Every byte, 0 and 255 too, in blobs and noise."""
    rng = np.random.default_rng(seed)
    texels = np.clip(128 + rng.normal(0, 40, (side, side, channels)), 0, 255).astype(np.uint8)
    texels[0, 0], texels[0, 1] = 0, 255
    return texels


def saved(path, texels):
    Image.fromarray(texels[..., 0] if texels.shape[2] == 1 else texels).save(path)
    return path


def test_textures_around_locked_ones_are_least_squares(character):
    """Against numpy's on the residual, texel by texel."""
    samples, weights = samples_of(character.first), random_weights(4, 3, 5)
    locked = {1: np.random.default_rng(1).normal(0, 0.1, samples.neutral.shape).astype(np.float32)}
    textures = solve_textures(samples, weights, locked=locked)
    np.testing.assert_array_equal(textures[1], locked[1])
    # With the locked part taken from the scans, those of the other slots are the ordinary solution.
    gaps = samples.scale * (samples.textures.astype(np.float32) - samples.neutral)
    up = upsampling(32, 4)
    full = np.einsum("pa,ain->pin", up, weights.transpose(0, 3, 1, 2).reshape(16, 3, 5))
    for texel in (0, 100, 500, 1023):
        y, x = divmod(texel, 32)
        rest = gaps[:, y, x] - full[texel, 1][:, None] * locked[1][y, x]
        design = full[texel][[0, 2]].T
        squares = np.square(weights).sum(dtype=np.float64) / 16
        ridge = 1e-3 * squares
        expected = np.linalg.solve(design.T @ design + ridge * np.eye(2), design.T @ rest)
        np.testing.assert_allclose(textures[[0, 2], y, x], expected, rtol=2e-3, atol=2e-4)


@pytest.mark.parametrize("nonnegative", [False, True])
@pytest.mark.parametrize("slot", [0, 2])
def test_a_locked_layer_stays_and_the_fit_is_no_worse_than_without_its_slot(tmp_path, nonnegative, slot):
    scans, texels = random_character(side=64, expressions=6), painted(64)
    locks = read_locks({f"difference_{slot}": saved(tmp_path / "a.png", texels)}, scans, 3)
    model = compress(scans, differences=3, nonnegative=nonnegative, locks=locks)
    stored = quantise(model)
    np.testing.assert_array_equal(stored.parts[ALBEDO_KEY].differences[slot], texels)
    without = quantise(compress(scans, differences=2, nonnegative=nonnegative))
    assert mean_rmse(albedo_errors(scans, stored)) <= mean_rmse(albedo_errors(scans, without))
    if nonnegative:
        assert model.weights[1001].min() >= 0
        assert model.weights[1001].max() <= 1


def test_a_useful_layer_is_used():
    """A layer that a fit found serves another fit as well as if it had found it itself."""
    scans = random_character(side=64, expressions=6)
    free = quantise(compress(scans, differences=3))
    part = free.parts[ALBEDO_KEY]
    lock = Lock("albedo.1001.difference_1", ALBEDO_KEY, 1, part.differences[1])
    around = quantise(compress(scans, differences=3, locks=[lock]))
    without = quantise(compress(scans, differences=2))
    errors = [mean_rmse(albedo_errors(scans, model)) for model in (free, around, without)]
    assert errors[1] < 0.5 * (errors[0] + errors[2])


def test_maps_and_tiles_are_locked_each_by_itself(tmp_path):
    scans = random_surface(expressions=5, tiles=(2, 1))
    save_character(scans, tmp_path / "scans")
    colour, normal, rough = painted(64)[:, :32], painted(64, seed=1)[:, :32], painted(64, 1, seed=2)[:, :32]
    files = {
        "1001.difference_0": saved(tmp_path / "a.png", colour),
        "normal.1002.difference_1": saved(tmp_path / "b.png", normal),
        "roughness.1001.difference_1": saved(tmp_path / "c.png", rough),
    }
    options = [word for name, file in files.items() for word in ("--lock", f"{name}={file}")]
    pack = tmp_path / "a.facezip"
    done = run("compress", tmp_path / "scans", "-o", pack, "--differences", 3, *options)
    assert done.returncode == 0, done.stderr
    assert read_manifest(pack).made_with["locked"] == tuple(sorted(files))
    for file, texels in (
        ("albedo.1001.difference_0.png", colour),
        ("normal.1002.difference_1.png", normal[..., :2]),
        ("roughness.1001.difference_1.png", rough),
    ):
        there = np.array(Image.open(pack / file))
        np.testing.assert_array_equal(there.reshape(64, 32, -1)[..., : texels.shape[2]], texels)
    without = run("compress", tmp_path / "scans", "-o", tmp_path / "b.facezip", "--differences", 1)
    assert without.returncode == 0
    scans = load_character(tmp_path / "scans")
    ours, theirs = (mean_rmse(albedo_errors(scans, read_pack(path))) for path in (pack, tmp_path / "b.facezip"))
    assert ours < theirs


@pytest.mark.parametrize(
    ("name", "texels", "code"),
    [
        ("difference_9", painted(32), ErrorCode.UNKNOWN_NAME),
        ("wrinkles", painted(32), ErrorCode.BAD_VALUE),
        ("normal.difference_0", painted(32), ErrorCode.UNKNOWN_NAME),
        ("1002.difference_0", painted(32), ErrorCode.UNKNOWN_NAME),
        ("difference_0", painted(16), ErrorCode.SIZE_MISMATCH),
        ("difference_0", painted(32, 1), ErrorCode.BAD_TEXELS),
        ("difference_0", np.dstack([painted(32), painted(32, 1)]), ErrorCode.BAD_TEXELS),
    ],
)
def test_what_is_no_layer_of_the_character_is_refused(tmp_path, name, texels, code):
    file = saved(tmp_path / "a.png", texels)
    with pytest.raises(FaceZipError) as caught:
        read_locks({name: file}, random_character(), 3)
    assert caught.value.code is code


def test_an_opaque_alpha_says_nothing_and_16_bits_are_refused(tmp_path):
    opaque = np.dstack([painted(32), np.full((32, 32, 1), 255, np.uint8)])
    (lock,) = read_locks({"difference_0": saved(tmp_path / "a.png", opaque)}, random_character(), 3)
    np.testing.assert_array_equal(lock.texels, opaque[..., :3])
    write_texture(tmp_path / "b.png", painted(32).astype(np.uint16) * 257)
    with pytest.raises(FaceZipError, match="16 bits"):
        read_locks({"difference_0": tmp_path / "b.png"}, random_character(), 3)


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(FaceZipError, match=r"nowhere\.png: no such image; --lock") as caught:
        read_locks({"difference_0": tmp_path / "nowhere.png"}, random_character(), 3)
    assert caught.value.code is ErrorCode.MISSING_FILE


def test_options_that_contradict_it_are_wrong_usage(tmp_path):
    save_character(random_character(), tmp_path / "scans")
    lock = ("--lock", f"difference_0={saved(tmp_path / 'a.png', painted(32))}")
    for options in (("--method", "pca"), ("--target-rmse", 2), ("--lock", "difference_0=b.png"), ("--lock", "x")):
        done = run("compress", tmp_path / "scans", "-o", tmp_path / "a.facezip", *lock, *options)
        assert done.returncode == 2, options
