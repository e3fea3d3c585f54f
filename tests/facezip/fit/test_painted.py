"""Painted weight maps: they come back byte for byte, and the fit around them is no worse than it has to be."""

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from facezip import compress, save_character
from facezip.character.samples import samples_of
from facezip.errors import ErrorCode, ExitCode, FaceZipError
from facezip.files.images import write_texture
from facezip.fit.locks import Lock
from facezip.fit.painted import Painted, Scale
from facezip.fit.painted_files import read_painted
from facezip.fit.rounding import best_differences
from facezip.machine import memory
from facezip.pack.errors import albedo_errors, mean_rmse
from facezip.pack.parsing import read_manifest
from facezip.pack.quantise import quantise
from facezip.pack.read import read_stored
from tests.facezip.conftest import ALBEDO_KEY, random_character
from tests.facezip.surfaces import random_surface
from tests.test_extend_command import some
from tests.test_layered_commands import run

SCANS = random_character(side=64, expressions=6)
LAST = "expr_5"
bytes_of_all = np.arange(256, dtype=np.uint8)


def painted(side=8, channels=3, seed=0):
    """Blobs of weights of both signs, and both ends of the range."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:side, :side] / side
    blobs = [np.exp(-6 * ((x - a) ** 2 + (y - b) ** 2)) for a, b in rng.random((channels, 2))]
    texels = np.rint(128 + 100 * np.stack(blobs, 2) * rng.choice([-1, 1], channels)).astype(np.uint8)
    texels[0, 0], texels[0, 1] = 0, 255
    return texels


def as_painted(texels, expression=LAST, tile=1001):
    return Painted(expression, tile, {i: np.ascontiguousarray(texels[..., i]) for i in range(texels.shape[2])})


def saved(path, texels):
    write_texture(path, texels)
    return path


def squares(scans, model):
    return sum(error**2 for error in albedo_errors(scans, model).values())


@given(st.floats(2**-10, 2**10, width=32), st.booleans())
def test_a_byte_stands_for_a_weight_and_the_other_way_round(unit, nonnegative):
    scale = Scale(np.float32(unit), nonnegative)
    weights = scale.weights(bytes_of_all)
    np.testing.assert_array_equal(scale.texels(weights), bytes_of_all)
    assert weights[0 if nonnegative else 128] == pytest.approx(0, abs=1e-6 * unit)
    assert weights[255] == pytest.approx(unit, rel=1e-5)
    assert (np.diff(weights) > 0).all()


@given(st.floats(-100, 0, width=32), st.floats(0, 100, width=32))
def test_its_unit_is_the_least_that_holds_all_weights(low, high):
    scale = Scale.of(low, high, nonnegative=False)
    assert scale.offset <= low + 1e-4
    assert scale.offset + scale.span >= high - 1e-4
    again = Scale.of(float(scale.offset), float(scale.offset + scale.span), nonnegative=False)
    assert again.unit == pytest.approx(scale.unit, rel=1e-5)


@pytest.mark.parametrize("nonnegative", [False, True])
@pytest.mark.parametrize("slots", [(0, 1, 2), (1,)])
def test_painted_maps_stay_and_all_weights_share_their_range(nonnegative, slots):
    texels = painted()
    one = Painted(LAST, 1001, {i: texels[..., i] for i in slots})
    model = compress(SCANS, differences=3, nonnegative=nonnegative, painted=[one])
    stored = quantise(model).weight_maps(1001)
    for i in slots:
        np.testing.assert_array_equal(stored.texels[5, :, :, i], texels[..., i])
        least, steps = (0, 255) if nonnegative else (-128 / 127, 127)
        assert stored.offset[i] == pytest.approx(least * stored.span[i] * steps / 255, abs=1e-6)
    if nonnegative:
        np.testing.assert_allclose(stored.span[list(slots)], 1, rtol=1e-6)
        assert model.weights[1001].min() >= 0
        assert model.weights[1001].max() <= 1 + 1e-6
    np.testing.assert_allclose(stored.values, model.weights[1001], atol=1e-6)


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("nonnegative", [False, True])
def test_the_fit_is_no_worse_than_one_without_the_expression_under_its_painted_maps(nonnegative, seed):
    """All squares together, textures solved for all: an expression that is painted has its say in them as any other."""
    texels = painted(seed=seed)
    ours = quantise(compress(SCANS, differences=3, nonnegative=nonnegative, painted=[as_painted(texels)]))
    rest = compress(some(SCANS, 0, 1, 2, 3, 4), differences=3, nonnegative=nonnegative)
    maps = rest.weights[1001]
    scales = [Scale.of(float(maps[..., i].min()), float(maps[..., i].max()), nonnegative) for i in range(3)]
    added = np.stack([scale.weights(texels[..., i]) for i, scale in enumerate(scales)], axis=2)
    weights = np.concatenate([maps, added[None]])
    differences, ranges = best_differences(samples_of(SCANS.first), weights)
    part = replace(rest.parts[ALBEDO_KEY], differences=differences, difference_range=ranges)
    after = replace(rest, expressions=SCANS.expressions, weights={1001: weights}, parts={ALBEDO_KEY: part})
    assert squares(SCANS, ours) <= squares(SCANS, after)


def test_a_map_that_one_layer_has_leaves_the_others_to_make_up_for_it():
    texels = painted(seed=1)
    one = quantise(compress(SCANS, differences=3, painted=[Painted(LAST, 1001, {1: texels[..., 1]})]))
    all_three = quantise(compress(SCANS, differences=3, painted=[as_painted(texels)]))
    free = quantise(compress(SCANS, differences=3))
    errors = [mean_rmse(albedo_errors(SCANS, model)) for model in (free, one, all_three)]
    assert errors == sorted(errors)


@pytest.mark.parametrize("options", [(), ("--nonnegative",)])
def test_maps_that_are_written_for_painting_and_given_back_change_next_to_nothing(tmp_path, options):
    save_character(SCANS, tmp_path / "scans")
    free, locked = tmp_path / "free.facezip", tmp_path / "locked.facezip"
    line = ("compress", tmp_path / "scans", "--differences", 3, "--json", *options)
    before = json.loads(run(*line, "-o", free).stdout)
    done = run("decompress", free, "-o", tmp_path / "maps", "--weights", "--expression", LAST, "--json")
    names = json.loads(done.stdout)["textures"]
    assert names == [f"{LAST}.difference_{i}.png" for i in range(3)]
    words = [f"{LAST}.difference_{i}={tmp_path / 'maps' / names[i]}" for i in range(3)]
    done = run(*line, "-o", locked, *(word for pair in words for word in ("--lock-weights", pair)))
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["rmse"] < 1.01 * before["rmse"]
    assert read_manifest(locked).made_with["locked_weights"] == tuple(f"{LAST}.difference_{i}" for i in range(3))
    # Once more: what a pack with painted maps shows for painting is what was painted.
    assert run("decompress", locked, "-o", tmp_path / "again", "--weights").returncode == 0
    assert len([*(tmp_path / "again").iterdir()]) == 3 * 6
    for name in names:
        assert (tmp_path / "again" / name).read_bytes() == (tmp_path / "maps" / name).read_bytes()


def test_on_tiles_and_beside_a_locked_layer(tmp_path):
    scans = random_surface(expressions=5, tiles=(2, 1))
    save_character(scans, tmp_path / "scans")
    texels = painted(8, 2)[:, :4]
    files = {
        "expr_1.1002": saved(tmp_path / "both.png", np.dstack([texels, np.zeros((8, 4, 2), np.uint8)])),
        "expr_2.1001.difference_1": saved(tmp_path / "one.png", texels[..., :1]),
    }
    layer = painted(64, 3, seed=2)[:, :32]
    words = [word for name, file in files.items() for word in ("--lock-weights", f"{name}={file}")]
    words += ["--lock", f"1002.difference_0={saved(tmp_path / 'layer.png', layer)}"]
    pack = tmp_path / "a.facezip"
    done = run("compress", tmp_path / "scans", "-o", pack, "--differences", 2, *words)
    assert done.returncode == 0, done.stderr
    stored = read_stored(pack, read_manifest(pack))
    np.testing.assert_array_equal(stored.weights[1002].texels[1], texels)
    np.testing.assert_array_equal(stored.weights[1001].texels[2, :, :, 1], texels[..., 0])
    np.testing.assert_array_equal(np.array(Image.open(pack / "albedo.1002.difference_0.png")), layer)
    assert run("decompress", pack, "-o", tmp_path / "maps", "--weights").returncode == 0
    there = np.array(Image.open(tmp_path / "maps" / "expr_2.1001.difference_1.png"))
    np.testing.assert_array_equal(there, texels[..., 0])


@pytest.mark.parametrize("nonnegative", [False, True])
def test_a_streamed_fit_has_the_bytes_of_one_made_in_memory(tmp_path, nonnegative):
    def fitted():
        return quantise(compress(SCANS, differences=3, nonnegative=nonnegative, painted=[as_painted(painted())]))

    here = fitted()
    with memory.limited(1, tmp_path):
        streamed = fitted()
    np.testing.assert_array_equal(streamed.weight_maps(1001).texels, here.weight_maps(1001).texels)
    parts = (model.parts[ALBEDO_KEY].differences for model in (streamed, here))
    np.testing.assert_array_equal(*parts)


@pytest.mark.parametrize(("expression", "tile", "named"), [("nobody", 1001, "nobody"), (LAST, 1003, "1003")])
def test_maps_of_what_there_is_not_are_refused(expression, tile, named):
    with pytest.raises(FaceZipError, match=f"'{named}'") as caught:
        compress(SCANS, painted=[as_painted(painted(channels=4), expression, tile)])
    assert caught.value.code is ErrorCode.UNKNOWN_NAME


@pytest.mark.parametrize(("method", "sparse"), [("pca", None), ("masks", None), ("paper", None), ("refined", 2)])
def test_fits_that_cannot_take_them_refuse(method, sparse):
    with pytest.raises(FaceZipError, match="painted weight maps: ") as caught:
        compress(SCANS, method, sparse=sparse, painted=[as_painted(painted(channels=4))])
    assert caught.value.code is ErrorCode.BAD_VALUE


def test_a_layer_and_weights_that_are_locked_both_stay():
    layer, texels = painted(64), painted()
    lock = Lock("albedo.1001.difference_1", ALBEDO_KEY, 1, layer)
    stored = quantise(compress(SCANS, differences=3, locks=[lock], painted=[as_painted(texels)]))
    np.testing.assert_array_equal(stored.parts[ALBEDO_KEY].differences[1], layer)
    np.testing.assert_array_equal(stored.weight_maps(1001).texels[5], texels)


GREY, COLOURS = painted(4, 1), painted(4, 3)


@pytest.mark.parametrize(
    ("name", "texels", "code"),
    [
        ("nobody", COLOURS, ErrorCode.UNKNOWN_NAME),
        ("expr_0.difference_9", GREY, ErrorCode.UNKNOWN_NAME),
        ("expr_0.1002", COLOURS, ErrorCode.UNKNOWN_NAME),
        ("expr_0", painted(8, 3), ErrorCode.SIZE_MISMATCH),
        ("expr_0", GREY, ErrorCode.BAD_TEXELS),
        ("expr_0.difference_0", COLOURS, ErrorCode.BAD_TEXELS),
        ("expr_0.difference_0", GREY.astype(np.uint16) * 257, ErrorCode.BAD_TEXELS),
    ],
)
def test_what_is_no_weight_map_of_the_fit_is_refused(tmp_path, name, texels, code):
    file = saved(tmp_path / "a.png", texels)
    with pytest.raises(FaceZipError) as caught:
        read_painted({name: file}, random_character(), 3, 8)
    assert caught.value.code is code
    assert "\n" not in str(caught.value)


def test_grey_is_grey_however_it_is_saved(tmp_path):
    grey = painted(4, 1)
    opaque = np.full_like(grey, 255)
    for channels in ([grey], [grey, opaque], [grey] * 3, [grey] * 3 + [opaque]):
        Image.fromarray(np.dstack(channels).squeeze()).save(tmp_path / "a.png")
        (one,) = read_painted({"expr_0.difference_1": tmp_path / "a.png"}, random_character(), 3, 8)
        np.testing.assert_array_equal(one.texels[1], grey[..., 0])


def test_a_map_is_painted_once_and_its_file_is_there(tmp_path):
    both, one = saved(tmp_path / "a.png", painted(4)), saved(tmp_path / "b.png", painted(4, 1))
    with pytest.raises(FaceZipError, match="locked twice"):
        read_painted({"expr_0": both, "expr_0.difference_1": one}, random_character(), 3, 8)
    with pytest.raises(FaceZipError, match=r"nowhere\.png: no such image"):
        read_painted({"expr_0": tmp_path / "nowhere.png"}, random_character(), 3, 8)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--method", "pca"), "--lock-weights needs --method refined"),
        (("--method", "masks"), "--lock-weights needs --method refined"),
        (("--target-rmse", 2), "leave --lock-weights out"),
        (("--sparse", 1), "leave it or --lock-weights out"),
        (("--lock-weights", "expr_0=b.png"), "each name once"),
    ],
)
def test_options_that_contradict_it_are_wrong_usage(tmp_path, options, words):
    save_character(random_character(), tmp_path / "scans")
    lock = ("--lock-weights", f"expr_0={saved(tmp_path / 'a.png', painted(4))}")
    done = run("compress", tmp_path / "scans", "-o", tmp_path / "a.facezip", *lock, *options)
    assert done.returncode == ExitCode.USAGE, options
    assert words in done.stderr


def test_packs_without_weight_maps_have_none_to_paint(tmp_path):
    save_character(random_character(), tmp_path / "scans")
    for method in (("pca",), ("masks", "--masks", 9)):
        pack = tmp_path / f"{method[0]}.facezip"
        assert run("compress", tmp_path / "scans", "-o", pack, "--method", *method).returncode == 0
        done = run("decompress", pack, "-o", tmp_path / "maps", "--weights")
        assert done.returncode == ExitCode.BAD_INPUT
        assert "--weights needs a pack" in done.stderr
