"""Weight maps that are made of masks: what they are, and what a pack keeps of them."""

import json
import shutil
from dataclasses import replace

import numpy as np
import pytest

from facezip import ErrorCode, FaceZipError
from facezip.files.images import read_texture_exactly
from facezip.files.packs import MANIFEST
from facezip.pack.manifest import ACTIVATIONS_FILE
from facezip.pack.masked import MaskedWeights
from facezip.pack.parsing import read_manifest
from facezip.pack.quantise import quantise
from facezip.pack.read import read_pack, read_stored
from facezip.pack.verification import verify_pack
from facezip.pack.write import write_pack
from tests.facezip.conftest import masked, random_model
from tests.facezip.export.conftest import layered_model
from tests.facezip.pack.test_manifest import changed, refused, sign


def weights_of(model, tile=1001):
    """Σ_k a_nki M_k, written down plainly."""
    made = model.masked
    return np.einsum("nki,khw->nhwi", made.activations.astype(float), made.masks[tile] / 255)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    path = tmp_path_factory.mktemp("packs") / "me.facezip"
    write_pack(masked(layered_model(tiles=(1001, 1002), weights=(3, 5)), 6), path)
    return path


@pytest.fixture
def pack(whole, tmp_path):
    return shutil.copytree(whole, tmp_path / "me.facezip")


@pytest.mark.parametrize("slots", [1, 4, 5])
def test_weight_maps_are_sums_of_masks(slots):
    model = masked(random_model(slots=slots))
    np.testing.assert_allclose(model.weights[1001], weights_of(model), atol=1e-5)


def test_a_blend_is_the_same_as_of_the_weight_maps_themselves():
    model = masked(random_model())
    plain = replace(model, weights=dict(model.weights))
    blend = {"expr_0": 0.5, "expr_2": -0.25}
    np.testing.assert_allclose(model.combined(blend, 1001), plain.combined(blend, 1001), atol=1e-5)
    np.testing.assert_array_equal(model.combined({"expr_1": 1.0}, 1001), model.weights[1001][1])


def test_one_white_mask_makes_uniform_weights():
    model = random_model(weights=(3, 5))
    rows = np.random.default_rng(0).normal(size=(3, 1, 4)).astype(np.float16)
    white = replace(model, weights=MaskedWeights(("all",), {1001: np.full((1, 3, 5), 255, np.uint8)}, rows))
    uniform = replace(model, weights={1001: rows.astype(np.float32)[:, None]})
    np.testing.assert_allclose(white.reconstruct("expr_1"), uniform.reconstruct("expr_1"), atol=1e-6)


@pytest.mark.parametrize("count", [1, 4, 5, 17])
@pytest.mark.parametrize("slots", [1, 5])
def test_a_pack_keeps_masks_and_activations_to_the_bit(tmp_path, count, slots):
    model = masked(layered_model(tiles=(1001, 1002), slots=slots), count)
    write_pack(model, tmp_path / "me.facezip")
    back = read_pack(tmp_path / "me.facezip")
    assert back.masked.names == model.masked.names
    np.testing.assert_array_equal(back.masked.activations, model.masked.activations)
    for tile, masks in model.masked.masks.items():
        np.testing.assert_array_equal(back.masked.masks[tile], masks)
        np.testing.assert_array_equal(back.weights[tile], model.weights[tile])
    for key, part in quantise(model).dequantised().parts.items():
        np.testing.assert_allclose(back.parts[key].differences, part.differences, atol=1e-6)
    again = read_manifest(tmp_path / "me.facezip").footprint
    assert replace(again, geometry=0) == model.footprint


def test_bytes_become_weights_as_the_format_says(pack):
    """As an engine reads them, without our code: four masks in a texel, half floats."""
    manifest = json.loads((pack / MANIFEST).read_bytes())
    count, slots = len(manifest["masks"]["names"]), len(manifest["tiles"][0]["weight_span"])
    stored = np.fromfile(pack / manifest["masks"]["activations"], "<f2")
    activations = stored.reshape(len(manifest["expressions"]), count, slots).astype(float)
    for tile, file in zip(manifest["tiles"], manifest["masks"]["files"], strict=True):
        (h, w), columns, image = tile["weight_size"], tile["weight_columns"], read_texture_exactly(pack / file)
        total = np.zeros((h, w, slots))
        for k in range(count):
            row, column = divmod(k // 4, columns)
            cell = image[row * h : (row + 1) * h, column * w : (column + 1) * w]
            total += activations[1, k] * (cell[..., k % 4, None] / 255)
        np.testing.assert_allclose(read_pack(pack).weights[tile["number"]][1], total, atol=1e-5)


def test_memory_does_not_grow_with_the_expressions():
    few, many = (masked(random_model(expressions=n), 6) for n in (3, 30))
    assert few.footprint.weight_bytes == many.footprint.weight_bytes == 4 * 3 * 5 * 2
    assert (
        random_model(expressions=30).footprint.weight_bytes == 10 * random_model(expressions=3).footprint.weight_bytes
    )


def test_a_pack_without_masks_says_nothing_of_them(tmp_path):
    write_pack(random_model(), tmp_path / "me.facezip")
    assert b"masks" not in (tmp_path / "me.facezip" / MANIFEST).read_bytes()


def test_readers_that_want_bytes_get_weight_maps_within_half_a_step(pack):
    stored = read_stored(pack, verify_pack(pack))
    for tile, exact in read_pack(pack).weights.items():
        rounded = stored.weight_maps(tile)
        assert np.abs(rounded.values - exact).max() <= 0.501 * rounded.span.max() / 255


@pytest.mark.parametrize("activations", [0.5, 1.5])
def test_a_pack_says_whether_activations_are_clamped(tmp_path, activations):
    model = masked(random_model())
    rows = np.full_like(model.masked.activations, activations)
    write_pack(replace(model, weights=replace(model.masked, activations=rows)), tmp_path / "me.facezip")
    assert read_manifest(tmp_path / "me.facezip").masks.clamped == (activations <= 1)


def test_masks_and_activations_are_as_many():
    with pytest.raises(ValueError, match="as many"):
        MaskedWeights(("one",), {1001: np.zeros((2, 3, 5), np.uint8)}, np.zeros((3, 2, 4), np.float16))


def test_a_mask_without_a_usable_name_is_refused_and_nothing_is_written(tmp_path):
    model = masked(random_model())
    names = ("../out", *model.masked.names[1:])
    with pytest.raises(FaceZipError, match="masks") as caught:
        write_pack(replace(model, weights=replace(model.masked, names=names)), tmp_path / "me.facezip")
    assert caught.value.code is ErrorCode.BAD_VALUE
    assert not [*tmp_path.iterdir()]


WRONG = [
    changed("masks", []),
    changed("masks", {"names": ["a"]}),
    changed("masks", "surprise", 1),
    changed("masks", "names", []),
    changed("masks", "names", ["a", "a", "b", "c", "d", "e"]),
    changed("masks", "names", ["a", "b", "c"]),
    changed("masks", "names", ["../a", "b", "c", "d", "e", "f"]),
    changed("masks", "names", [f"m{k}" for k in range(4097)]),
    changed("masks", "names", "abcdef"),
    changed("masks", "files", ["masks.1001.png"]),
    changed("masks", "files", ["masks.1001.png"] * 2),
    changed("masks", "files", ["masks.1001.png", "../masks.png"]),
    changed("masks", "files", ["masks.1001.png", 3]),
    changed("masks", "activations", "masks.1001.png"),
    changed("masks", "activations", None),
    changed("masks", "clamped", 0),
    changed("masks", "clamped", True),
    changed("masks", None),
    changed("tiles", 0, "weight_span", [1, 1, 1, 2]),
    changed("tiles", 0, "weight_span", [1, 1, 1, True]),
    changed("tiles", 0, "weight_span", [1, 1, 1, 1, 1]),
    changed("tiles", 1, "weight_offset", [0, 0, 0, 1]),
    changed("tiles", 0, "weight_columns", 3),
    changed("tiles", 0, "weight_size", [1, 1]),
    changed("tiles", 0, "weight_size", [5, 3]),
    changed("tiles", 0, "weights", ["masks.1001.png"]),
    changed("uniform_weights", [[1, 1, 1, 1]] * 3),
    changed("expressions", ["a", "b"]),
    changed("files", ACTIVATIONS_FILE, None),
]


@pytest.mark.parametrize("change", WRONG, ids=range(len(WRONG)))
def test_a_well_signed_manifest_with_wrong_masks_is_refused(pack, change):
    document = json.loads((pack / MANIFEST).read_bytes())
    change(document)
    sign(pack, document)
    refused(pack)


@pytest.mark.parametrize("content", [np.inf, np.nan])
def test_activations_that_are_no_numbers_are_refused(pack, content):
    activations = np.fromfile(pack / ACTIVATIONS_FILE, "<f2")
    activations[7] = content
    activations.tofile(pack / ACTIVATIONS_FILE)
    sign(pack, json.loads((pack / MANIFEST).read_bytes()))
    assert ACTIVATIONS_FILE in refused(pack)
