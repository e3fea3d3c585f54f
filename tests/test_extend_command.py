"""``facezip extend PACK CHARACTER -o PACK``: what has been shipped stays, and what is new is as good as it can be."""

import json
from dataclasses import replace

import numpy as np
import pytest

from facezip.character.loading import save_character
from facezip.errors import ExitCode
from facezip.files.images import as_texels
from facezip.pack.parsing import read_manifest
from facezip.pack.read import read_pack, read_stored
from facezip.pack.write import write_pack
from tests.facezip.conftest import ALBEDO_KEY, random_character, random_model
from tests.facezip.surfaces import random_surface
from tests.test_layered_commands import run

METHODS = {
    "refined": (),
    "nonnegative": ("--nonnegative",),
    "pca": ("--method", "pca"),
    "masks": ("--method", "masks", "--masks", 9, "--nonnegative"),
}


def some(character, *numbers):
    """The character with a few of its expressions."""
    chosen = list(numbers)
    return replace(
        character,
        expressions=tuple(character.expressions[n] for n in chosen),
        meshes=replace(character.meshes, vertices=character.meshes.vertices[chosen]),
        stacks={key: replace(stack, textures=stack.textures[chosen]) for key, stack in character.stacks.items()},
    )


@pytest.fixture(scope="module")
def whole():
    return random_surface(expressions=7, tiles=(2, 1))


@pytest.fixture(scope="module")
def folder(tmp_path_factory, whole):
    """The first five expressions, packs of them, and the last three: one of those is in the packs."""
    folder = tmp_path_factory.mktemp("extend")
    save_character(some(whole, 0, 1, 2, 3, 4), folder / "first")
    save_character(some(whole, 4, 5, 6), folder / "last")
    for name, options in METHODS.items():
        pack = folder / f"{name}.facezip"
        done = run("compress", folder / "first", "-o", pack, "--differences", 3, *options)
        assert done.returncode == 0, done.stderr
    return folder


def extended(folder, name, *options):
    path = folder / f"{name}-more.facezip"
    done = run("extend", folder / f"{name}.facezip", folder / "last", "-o", path, "--overwrite", "--json", *options)
    assert done.returncode == 0, done.stderr
    return path, json.loads(done.stdout)


@pytest.mark.parametrize("method", METHODS)
def test_what_was_there_stays_byte_for_byte(folder, whole, method):
    path, document = extended(folder, method, "--quick")
    assert run("verify", path).returncode == 0
    assert (document["added"], document["kept"]) == (["expr_5", "expr_6"], ["expr_4"])
    old, new = (read_manifest(pack) for pack in (folder / f"{method}.facezip", path))
    textures = [name for name in old.files if "neutral" in name or "difference" in name or "masks" in name]
    assert len(textures) >= 2 * 3 * 4
    assert {name: new.files[name] for name in textures} == {name: old.files[name] for name in textures}
    before, after = (read_pack(pack) for pack in (folder / f"{method}.facezip", path))
    assert after.expressions == whole.expressions
    for tile in before.tiles:
        np.testing.assert_array_equal(after.weights[tile][:5], before.weights[tile])
    np.testing.assert_array_equal(after.meshes.vertices[:5], before.meshes.vertices)
    np.testing.assert_array_equal(after.meshes.neutral, before.meshes.neutral)
    np.testing.assert_allclose(after.meshes.vertices[5:], whole.meshes.vertices[5:], atol=1e-3)


@pytest.mark.parametrize("suffix", ["", ".glb"])
@pytest.mark.parametrize("method", METHODS)
def test_one_new_expression_alone_gets_what_it_gets_beside_others(tmp_path, method, suffix):
    scans, packs = random_character(side=64, expressions=6), {}
    for name, numbers in (("first", (0, 1, 2, 3)), ("one", (4,)), ("two", (4, 5))):
        save_character(some(scans, *numbers), tmp_path / f"{name}{suffix}")
    old, options = tmp_path / "old.facezip", ("--differences", 3, *METHODS[method])
    assert run("compress", tmp_path / f"first{suffix}", "-o", old, *options).returncode == 0
    for name in ("one", "two"):
        path = tmp_path / f"{name}.facezip"
        done = run("extend", old, tmp_path / f"{name}{suffix}", "-o", path, "--quick")
        assert done.returncode == 0, done.stderr
        packs[name] = read_pack(path)
    np.testing.assert_allclose(packs["one"].weights[1001][4], packs["two"].weights[1001][4], atol=1e-5)
    if method == "masks":
        # An expression is K · R numbers of two bytes.
        files = [read_manifest(path).files["activations.f16"].bytes for path in (old, tmp_path / "one.facezip")]
        assert files[1] - files[0] == 2 * 9 * 3


def test_a_folder_without_an_expression_is_refused_and_one_is_too_few_for_a_pack(folder, whole, tmp_path):
    save_character(some(whole, 5), tmp_path / "one")
    refused = run("compress", tmp_path / "one", "-o", tmp_path / "a.facezip")
    assert refused.returncode == ExitCode.BAD_INPUT
    assert "1 expression(s); at least two besides the neutral" in refused.stderr
    for file in (tmp_path / "one").glob("expr_5*"):
        file.unlink()
    none = run("extend", folder / "refined.facezip", tmp_path / "one", "-o", tmp_path / "a.facezip")
    assert none.returncode == ExitCode.BAD_INPUT
    assert "0 expression(s); at least one besides the neutral" in none.stderr


def test_numbers_of_uniform_weights_are_those_of_least_squares(tmp_path):
    scans = random_character(side=32, expressions=7)
    save_character(some(scans, 0, 1, 2, 3, 4), tmp_path / "first")
    save_character(some(scans, 5, 6), tmp_path / "last")
    assert run("compress", tmp_path / "first", "-o", tmp_path / "a.facezip", "--method", "pca").returncode == 0
    done = run("extend", tmp_path / "a.facezip", tmp_path / "last", "-o", tmp_path / "b.facezip", "--quick")
    assert done.returncode == 0, done.stderr
    model = read_pack(tmp_path / "b.facezip")
    part, stack = model.parts[ALBEDO_KEY], scans.first
    gaps = stack.textures[5:] / np.float64(255) - part.neutral
    expected = np.linalg.lstsq(part.differences.reshape(4, -1).T, gaps.reshape(2, -1).T, rcond=None)[0].T
    np.testing.assert_allclose(model.weights[1001][5:, 0, 0], expected, rtol=1e-3, atol=1e-4)


def test_weights_lie_within_the_range_of_the_old_ones(folder):
    path, _ = extended(folder, "refined", "--quick")
    before, after = (read_stored(pack, read_manifest(pack)) for pack in (folder / "refined.facezip", path))
    for tile, weights in before.weights.items():
        np.testing.assert_array_equal(after.weights[tile].span, weights.span)
        np.testing.assert_array_equal(after.weights[tile].offset, weights.offset)
    clamped = read_pack(extended(folder, "masks", "--quick")[0]).masked
    assert clamped.clamped


@pytest.mark.parametrize("method", METHODS)
def test_blends_of_old_expressions_are_as_good_as_the_old_fit(tmp_path, method):
    scans = random_character(side=64, expressions=6)
    stack = scans.first
    betas = np.array([[0.6, 0.4, 0, 0, 0, 0], [0, 0, 0.5, 0.25, 0.25, 0]], np.float32)
    gaps = stack.textures.astype(np.float32) - stack.neutral
    mixed = np.rint(stack.neutral + np.einsum("bn,nhwc->bhwc", betas, gaps)).astype(np.uint8)
    meshes = replace(scans.meshes, vertices=scans.meshes.vertices[:2])
    blends = replace(
        scans, expressions=("mix_a", "mix_b"), meshes=meshes, stacks={ALBEDO_KEY: replace(stack, textures=mixed)}
    )
    save_character(scans, tmp_path / "scans")
    save_character(blends, tmp_path / "blends")
    assert run("compress", tmp_path / "scans", "-o", tmp_path / "a.facezip", *METHODS[method]).returncode == 0
    done = run("extend", tmp_path / "a.facezip", tmp_path / "blends", "-o", tmp_path / "b.facezip", "--quick", "--json")
    document = json.loads(done.stdout)
    model = read_pack(tmp_path / "a.facezip")
    for name, beta, texture in zip(("mix_a", "mix_b"), betas, mixed, strict=True):
        old = model.blend(dict(zip(model.expressions, beta.tolist(), strict=True)))
        error = 255 * np.sqrt(np.mean(np.square(old - texture / np.float32(255))))
        assert document["errors"]["albedo"]["rmse_per_expression"][name] < 1.01 * error


def test_what_is_lost_against_a_fit_of_all_is_said(folder):
    _, document = extended(folder, "refined")
    ours, full = (document[key]["albedo"]["rmse_per_expression"] for key in ("errors", "full_fit"))
    assert {*full} == {"expr_5", "expr_6"}
    assert document["loss"]["albedo"] == {name: ours[name] - full[name] for name in ours}
    assert all(loss > 0 for loss in document["loss"]["albedo"].values())
    much = [name for name in ours if ours[name] > 1.5 * full[name] and ours[name] - full[name] > 0.5]
    assert {*much} <= {*document["advised"]}
    done = run("extend", folder / "refined.facezip", folder / "last", "-o", folder / "said.facezip")
    assert "expr_4 stays as it is" in done.stdout
    assert f"expr_5     albedo {ours['expr_5']:.2f}, {full['expr_5']:.2f} with a fit of all" in done.stdout
    assert "compress all scans again" in done.stdout


def test_textures_whose_sides_are_no_multiple_are_extended_beside_a_fit_of_all(tmp_path):
    scans = random_character(side=36, expressions=6)
    save_character(some(scans, 0, 1, 2, 3), tmp_path / "first")
    save_character(some(scans, 4, 5), tmp_path / "last")
    assert run("compress", tmp_path / "first", "-o", tmp_path / "a.facezip", "--differences", 3).returncode == 0
    done = run("extend", tmp_path / "a.facezip", tmp_path / "last", "-o", tmp_path / "b.facezip", "--json")
    assert done.returncode == 0, done.stderr
    document = json.loads(done.stdout)
    assert document["weight_scale"] == 8
    assert {*document["full_fit"]["albedo"]["rmse_per_expression"]} == {"expr_4", "expr_5"}


def test_weight_maps_that_no_fit_makes_are_refused_before_a_pack_is_written(tmp_path):
    scans = random_character(expressions=5)
    model = random_model(size=(32, 32), weights=(5, 7))
    neutral = as_texels(model.parts[ALBEDO_KEY].neutral, scans.first.neutral.dtype)
    save_character(replace(scans, stacks={ALBEDO_KEY: replace(scans.first, neutral=neutral)}), tmp_path / "scans")
    write_pack(model, tmp_path / "a.facezip")
    refused = run("extend", tmp_path / "a.facezip", tmp_path / "scans", "-o", tmp_path / "b.facezip")
    assert refused.returncode == ExitCode.BAD_INPUT
    assert "a.facezip: no fit makes weight maps of their size; give --quick" in refused.stderr
    assert not (tmp_path / "b.facezip").exists()
    done = run("extend", tmp_path / "a.facezip", tmp_path / "scans", "-o", tmp_path / "b.facezip", "--quick")
    assert done.returncode == 0, done.stderr


def test_a_pack_may_be_extended_in_its_place_and_again(folder, whole, tmp_path):
    save_character(some(whole, 5, 0), tmp_path / "one")
    save_character(some(whole, 6, 0), tmp_path / "two")
    path, _ = extended(folder, "refined", "--quick")
    done = run("extend", folder / "refined.facezip", tmp_path / "one", "-o", tmp_path / "p.facezip", "--quick")
    assert done.returncode == 0, done.stderr
    again = run("extend", tmp_path / "p.facezip", tmp_path / "two", "-o", tmp_path / "p.facezip", "--quick")
    assert again.returncode == ExitCode.CANNOT_WRITE
    options = ("--quick", "--overwrite")
    assert (
        run("extend", tmp_path / "p.facezip", tmp_path / "two", "-o", tmp_path / "p.facezip", *options).returncode == 0
    )
    assert read_manifest(tmp_path / "p.facezip").made_with["extended_by"] == ("expr_5", "expr_6")
    assert {*read_manifest(tmp_path / "p.facezip").expressions} == {*read_manifest(path).expressions}


def other_neutral(scans):
    key = ("albedo", 1001)
    stack = scans.stacks[key]
    return replace(scans, stacks={**scans.stacks, key: replace(stack, neutral=255 - stack.neutral)})


def moved(scans):
    return replace(scans, meshes=replace(scans.meshes, neutral=scans.meshes.neutral + np.float32(1)))


def fewer_maps(scans):
    return scans.only("albedo", "normal")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (other_neutral, "its albedo differs by"),
        (moved, "its mesh is off by"),
        (fewer_maps, "has roughness on tile 1001, which"),
        (lambda scans: replace(scans, expressions=("expr_0", "expr_1", "expr_2")), "nothing to add"),
        (lambda scans: replace(scans, expressions=("EXPR_0", "a", "b")), "take them for one"),
    ],
)
def test_what_does_not_belong_to_the_pack_is_refused(folder, whole, tmp_path, change, words):
    save_character(change(some(whole, 4, 5, 6)), tmp_path / "scans")
    done = run("extend", folder / "pca.facezip", tmp_path / "scans", "-o", tmp_path / "p.facezip")
    assert done.returncode == ExitCode.BAD_INPUT
    assert words in done.stderr
    assert done.stderr.count("\n") == 1
    assert not (tmp_path / "p.facezip").exists()
