"""A region that is kept of an older pack: nothing in it changes, and all else is fitted anew."""

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facezip import compress, load_character, save_character
from facezip.errors import ExitCode
from facezip.files.images import write_texture
from facezip.fit.extension import beside_neutral_of
from facezip.fit.kept import KeptRegion
from facezip.fit.kept_files import Keeping, read_kept
from facezip.machine import memory
from facezip.pack.errors import albedo_errors, mean_rmse
from facezip.pack.parsing import read_manifest
from facezip.pack.quantise import quantise
from facezip.pack.read import read_pack, read_stored
from facezip.pack.sampling import bilinear_taps
from tests.facezip.conftest import ALBEDO_KEY, random_character, random_model
from tests.facezip.surfaces import random_surface
from tests.test_extend_command import other_neutral, some
from tests.test_layered_commands import run

OPTIONS = ("--differences", 3)


def disk(height, width, soft=0.0):
    """A mask whose border crosses texels of the weight maps."""
    y, x = (np.mgrid[:height, :width] + 0.5) / [[[height]], [[width]]]
    distance = np.hypot(x - 0.4, y - 0.45)
    edge = np.clip((0.27 - distance) / soft + 0.5, 0, 1) if soft else distance < 0.27
    return np.rint(255 * edge).astype(np.uint8)[..., None]


def compressed(scans, pack, *options):
    done = run("compress", scans, "-o", pack, *OPTIONS, "--json", *options)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def noisy(character):
    """Another session of the same expressions: each texture somewhat changed."""
    rng = np.random.default_rng(9)
    stacks = {}
    for key, stack in character.stacks.items():
        most = np.iinfo(stack.textures.dtype).max
        ripple = rng.normal(0, 0.03 * most, stack.textures.shape[:3])[..., None]
        changed = np.clip(stack.textures + np.rint(ripple), 0, most).astype(stack.textures.dtype)
        stacks[key] = replace(stack, textures=changed)
    return replace(character, stacks=stacks)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A pack of five expressions on two tiles; new scans of four of them, and of two that it lacks."""
    folder = tmp_path_factory.mktemp("kept")
    whole = random_surface(expressions=7, tiles=(2, 1))
    save_character(some(whole, 0, 1, 2, 3, 4), folder / "first")
    save_character(some(noisy(whole), 1, 2, 3, 4, 5, 6), folder / "second")
    compressed(folder / "first", folder / "old.facezip")
    write_texture(folder / "mask.png", disk(64, 32))
    words = ("--region", f"spot.1002={folder / 'mask.png'}", "--keep-region", "spot", "--from", folder / "old.facezip")
    document = compressed(folder / "second", folder / "new.facezip", *words)
    (folder / "document.json").write_text(json.dumps(document))
    return folder


@settings(max_examples=25, deadline=None)
@given(betas=st.lists(st.floats(-2, 2, width=32), min_size=4, max_size=4))
def test_what_is_blended_inside_is_what_the_older_pack_gives(folder, betas):
    old, new = read_pack(folder / "old.facezip"), read_pack(folder / "new.facezip")
    weights = dict(zip(("expr_1", "expr_2", "expr_3", "expr_4"), betas, strict=True))
    inside = disk(64, 32)[..., 0] > 127
    for kind in old.maps:
        key = kind.name, 1002
        ours, theirs = new.texels(weights, key), old.texels(weights, key)
        np.testing.assert_array_equal(ours[inside], theirs[inside])


def test_bytes_inside_and_all_ranges_and_neutrals_stay(folder):
    old, new = (read_manifest(folder / f"{name}.facezip") for name in ("old", "new"))
    before, after = (read_stored(folder / f"{name}.facezip", m) for name, m in (("old", old), ("new", new)))
    inside = disk(64, 32)[..., 0] > 127
    for kind in before.maps:
        for tile in (1001, 1002):
            theirs, ours = (stored.parts[kind.name, tile] for stored in (before, after))
            np.testing.assert_array_equal(ours.neutral, theirs.neutral)
        np.testing.assert_array_equal(ours.differences[:, inside], theirs.differences[:, inside])
        assert (ours.differences[:, ~inside] != theirs.differences[:, ~inside]).any()
    for was, now in zip(old.tiles, new.tiles, strict=True):
        assert (now.weight_span, now.weight_offset) == (was.weight_span, was.weight_offset)
        for one, other in zip(was.textures, now.textures, strict=True):
            assert other.difference_span == one.difference_span
    assert new.made_with["kept"] == {"pack": "old.facezip", "regions": ("spot",)}
    assert run("verify", folder / "new.facezip").returncode == 0


def test_what_is_outside_is_fitted_to_the_new_scans(folder):
    scans, document = load_character(folder / "second"), json.loads((folder / "document.json").read_text())
    old, new = read_pack(folder / "old.facezip"), read_pack(folder / "new.facezip")
    there = some(scans, 0, 1, 2, 3)
    assert mean_rmse(albedo_errors(there, new)) < mean_rmse(albedo_errors(there, old))
    kept, inside = document["kept"], disk(64, 32)[..., 0] > 127
    assert kept["share"] == pytest.approx(inside.sum() / (2 * 64 * 32))
    expected = [[], []]
    for name in scans.expressions:
        gaps = [np.square(new.texels({name: 1}, key) - scans.texels(name, key) / np.float32(255)) for key in
                (("albedo", 1001), ("albedo", 1002))]  # fmt: skip
        beside = np.concatenate([gaps[0].ravel(), gaps[1][~inside].ravel()])
        for values, some_gaps in zip(expected, (gaps[1][inside], beside), strict=True):
            values.append(255 * np.sqrt(some_gaps.mean(dtype=np.float64)))
    assert kept["rmse_inside"] == pytest.approx(np.mean(expected[0]), rel=1e-4)
    assert kept["rmse_outside"] == pytest.approx(np.mean(expected[1]), rel=1e-4)


def test_new_expressions_are_solved_inside_under_the_textures_that_stay(folder):
    """As good as what extend makes of them in the older pack, up to the bytes at the border."""
    scans, key = load_character(folder / "second"), ("albedo", 1002)
    more = folder / "extended.facezip"
    assert run("extend", folder / "old.facezip", folder / "second", "-o", more, "--quick").returncode == 0
    inside = disk(64, 32)[..., 0] > 127
    for name in ("expr_5", "expr_6"):
        target = scans.texels(name, key)[inside] / np.float32(255)
        packs = (folder / "new.facezip", more)
        ours, theirs = (np.square(read_pack(pack).texels({name: 1}, key)[inside] - target).mean() for pack in packs)
        assert ours < 1.02 * theirs


def test_a_region_of_everything_is_the_older_pack(tmp_path):
    save_character(random_character(side=64, expressions=5), tmp_path / "scans")
    compressed(tmp_path / "scans", tmp_path / "old.facezip", "--nonnegative")
    write_texture(tmp_path / "mask.png", np.full((9, 9, 1), 255, np.uint8))
    words = ("--region", f"all={tmp_path / 'mask.png'}", "--keep-region", "all", "--from", tmp_path / "old.facezip")
    document = compressed(tmp_path / "scans", tmp_path / "new.facezip", *words)
    old, new = (read_manifest(tmp_path / f"{name}.facezip") for name in ("old", "new"))
    assert new.files == old.files
    assert document["kept"]["rmse_outside"] is None
    assert document["kept"]["rmse_inside"] == pytest.approx(document["rmse"])
    # Its weights are in 0..1 still, and other commands are told so.
    assert new.made_with["nonnegative"] is True


def test_a_streamed_fit_has_the_bytes_of_one_made_in_memory(folder, tmp_path):
    scans = load_character(folder / "second")
    keeping = Keeping(folder / "old.facezip", {"spot.1002": folder / "mask.png"}, ("spot",))

    def fitted():
        kept = read_kept(keeping, scans, 3, 8)
        return quantise(compress(beside_neutral_of(kept.stored, scans), differences=3, kept=kept))

    here = fitted()
    with pytest.MonkeyPatch.context() as patch, memory.limited(1, tmp_path):
        patch.setattr(memory, "LEAST", -(10**9))
        streamed = fitted()
    for tile in (1001, 1002):
        np.testing.assert_array_equal(streamed.weight_maps(tile).texels, here.weight_maps(tile).texels)
    for key, part in here.parts.items():
        np.testing.assert_array_equal(streamed.parts[key].differences, part.differences)


def test_regions_add_up_and_soft_masks_of_any_size_end_at_one_half(tmp_path):
    save_character(random_character(side=64, expressions=4), tmp_path / "scans")
    compressed(tmp_path / "scans", tmp_path / "old.facezip")
    write_texture(tmp_path / "soft.png", disk(128, 128, soft=0.2))
    corner = np.zeros((64, 64, 1), np.uint8)
    corner[50:, 50:] = 255
    write_texture(tmp_path / "corner.png", corner)
    words = ("--region", f"a={tmp_path / 'soft.png'}", "--region", f"b={tmp_path / 'corner.png'}")
    keep = ("--keep-region", "a", "--keep-region", "b", "--from", tmp_path / "old.facezip")
    document = compressed(tmp_path / "scans", tmp_path / "new.facezip", *words, *keep)
    expected = disk(64, 64)[..., 0] > 127
    expected[50:, 50:] = True
    assert document["kept"]["share"] == pytest.approx(expected.mean(), abs=0.02)
    assert document["kept"]["regions"] == ["a", "b"]
    old, new = read_pack(tmp_path / "old.facezip"), read_pack(tmp_path / "new.facezip")
    core = disk(64, 64, soft=0.2)[..., 0] > 160
    core[50:, 50:] = True
    for name in old.expressions:
        np.testing.assert_array_equal(new.reconstruct(name)[core], old.reconstruct(name)[core])
    said = run("compress", tmp_path / "scans", "-o", tmp_path / "b.facezip", *OPTIONS, *words, *keep)
    errors = document["kept"]["rmse_inside"], document["kept"]["rmse_outside"]
    assert f"% of the face; albedo {errors[0]:.2f} inside, {errors[1]:.2f} outside" in said.stdout


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 1000), height=st.integers(5, 40), width=st.integers(5, 40), share=st.floats(0.01, 0.3))
def test_weights_that_stay_are_exactly_those_that_the_region_samples(seed, height, width, share):
    model = random_model(size=(height, width), weights=(3, 5))
    inside = np.random.default_rng(seed).random((height, width)) < share
    kept = KeptRegion(("a",), quantise(model), model, {ALBEDO_KEY: inside}, nonnegative=False)
    rows, columns = bilinear_taps(height, 3), bilinear_taps(width, 5)
    expected = np.zeros((3, 5), bool)
    for y, x in np.argwhere(inside):
        for row in (rows.first[y], rows.second[y]):
            for column in (columns.first[x], columns.second[x]):
                expected[row, column] = True
    np.testing.assert_array_equal(kept.sampled(1001), expected)
    held = kept.held(1001, ("expr_2", "new", "expr_0"))
    np.testing.assert_array_equal(held.where[:, 0, 0], expected)
    assert not held.where[:, :, 1].any()
    stored = kept.weights(1001).values
    np.testing.assert_array_equal(held.values[:, :, 0], stored[2].transpose(0, 2, 1))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda scans: other_neutral(scans), "its albedo differs by"),
        (lambda scans: scans.only("albedo", "normal"), "has roughness on tile 1001, which"),
    ],
)
def test_what_does_not_belong_to_the_pack_is_refused(folder, tmp_path, change, words):
    save_character(change(load_character(folder / "first")), tmp_path / "scans")
    keep = ("--region", f"a.1001={folder / 'mask.png'}", "--keep-region", "a", "--from", folder / "old.facezip")
    done = run("compress", tmp_path / "scans", "-o", tmp_path / "p.facezip", *OPTIONS, *keep)
    assert done.returncode == ExitCode.BAD_INPUT
    assert words in done.stderr.splitlines()[-1]
    assert not (tmp_path / "p.facezip").exists()


@pytest.mark.parametrize(
    ("options", "code", "words"),
    [
        (("--from", "OLD"), ExitCode.USAGE, "needs --region NAME=FILE"),
        (("--keep-region", "a", "--from", "OLD"), ExitCode.USAGE, "needs --region NAME=FILE"),
        (("--region", "a.1001=MASK", "--keep-region", "b", "--from", "OLD"), ExitCode.USAGE, "--region b=FILE"),
        (("--region", "c=MASK", "KEEP"), ExitCode.USAGE, "--region c: nothing is done there"),
        (("KEEP", "--sparse", 1), ExitCode.USAGE, "leave it or --keep-region out"),
        (("KEEP", "--method", "masks"), ExitCode.USAGE, "--keep-region needs --method refined"),
        (("KEEP", "--nonnegative"), ExitCode.USAGE, "leave --nonnegative out"),
        (("KEEP", "--target-rmse", 2), ExitCode.USAGE, "leave --keep-region out"),
        (("KEEP", "--lock", "1001.difference_0=MASK"), ExitCode.USAGE, "leave --lock and"),
        (("KEEP", "--differences", 2), ExitCode.BAD_INPUT, "give --differences 3"),
        (("KEEP", "--weight-scale", 16), ExitCode.BAD_INPUT, "give --weight-scale 8"),
        (("--region", "a=MASK", "--keep-region", "a", "--from", "OLD"), ExitCode.BAD_INPUT, "too, as a.1001"),
        (("--region", "a.1003=MASK", "--keep-region", "a", "--from", "OLD"), ExitCode.BAD_INPUT, "no tile '1003'"),
        (("--region", "a.1001=NONE", "--keep-region", "a", "--from", "OLD"), ExitCode.BAD_INPUT, "no such image"),
        (
            ("--region", "a.1001=BLACK", "--keep-region", "a", "--from", "OLD"),
            ExitCode.BAD_INPUT,
            "nothing is inside a",
        ),
    ],
    ids=str,
)
def test_what_contradicts_it_is_refused_in_one_line(folder, tmp_path, options, code, words):
    write_texture(tmp_path / "black.png", np.full((64, 32, 1), 100, np.uint8))
    places = {"OLD": folder / "old.facezip", "MASK": folder / "mask.png", "BLACK": tmp_path / "black.png"}
    places["NONE"] = tmp_path / "none.png"
    keep = ["--region", f"a.1001={places['MASK']}", "--keep-region", "a", "--from", places["OLD"]]
    line = []
    for option in options:
        name, equals, place = str(option).partition("=")
        line += keep if option == "KEEP" else [f"{name}={places[place]}" if equals else places.get(option, option)]
    given = [] if {"--differences", "--target-rmse"} & {*line} else OPTIONS
    done = run("compress", folder / "first", "-o", tmp_path / "p.facezip", *given, *line)
    assert done.returncode == code, done.stderr
    assert words in done.stderr


def test_the_remedy_for_another_size_of_weight_maps_can_be_followed(tmp_path):
    """Where the sides are no multiple of it."""
    save_character(random_character(side=36), tmp_path / "scans")
    compressed(tmp_path / "scans", tmp_path / "old.facezip")
    write_texture(tmp_path / "mask.png", disk(36, 36))
    keep = ("--region", f"a={tmp_path / 'mask.png'}", "--keep-region", "a", "--from", tmp_path / "old.facezip")
    done = run("compress", tmp_path / "scans", "-o", tmp_path / "p.facezip", *OPTIONS, *keep, "--weight-scale", 4)
    assert done.returncode == ExitCode.BAD_INPUT
    assert "give --weight-scale 8" in done.stderr
    compressed(tmp_path / "scans", tmp_path / "p.facezip", *keep, "--weight-scale", 8)


@pytest.mark.parametrize(
    ("method", "words"), [(("pca",), "one number"), (("masks", "--masks", 9), "weights are masks")]
)
def test_a_pack_without_weight_maps_has_no_region_to_keep(tmp_path, method, words):
    save_character(random_character(), tmp_path / "scans")
    write_texture(tmp_path / "mask.png", disk(32, 32))
    compressed(tmp_path / "scans", tmp_path / "old.facezip", "--method", *method)
    keep = ("--region", f"a={tmp_path / 'mask.png'}", "--keep-region", "a", "--from", tmp_path / "old.facezip")
    done = run("compress", tmp_path / "scans", "-o", tmp_path / "p.facezip", *OPTIONS, *keep)
    assert done.returncode == ExitCode.BAD_INPUT
    assert words in done.stderr
