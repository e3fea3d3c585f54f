"""How much texels and maps count: laws of the fit's weights."""

from dataclasses import replace

import numpy as np
import pytest

from facezip.character.loading import save_character
from facezip.errors import ErrorCode, FaceZipError
from facezip.files.images import write_values
from facezip.fit.importance import importance_files, map_factors
from facezip.fit.methods import compress
from facezip.fit.pipeline import Request, compress_into, read_importance
from facezip.pack.errors import model_errors
from tests.facezip.surfaces import random_surface


@pytest.fixture(scope="module")
def scans():
    """Albedo, normals and roughness on two tiles."""
    return random_surface(expressions=5, tiles=(2, 1))


def everywhere(scans, value=1.0):
    return {key: np.full(stack.resolution, value, np.float32) for key, stack in scans.stacks.items()}


def same(one, other):
    return all(np.array_equal(one.parts[key].differences, other.parts[key].differences) for key in one.parts)


def test_an_importance_of_one_everywhere_changes_nothing(scans):
    albedos = {key: one for key, one in everywhere(scans).items() if key[0] == "albedo"}
    plain, weighed = compress(scans, differences=2), compress(scans, differences=2, importance=albedos)
    assert same(plain, weighed)


def test_maps_with_an_importance_of_their_own_count_by_it(scans):
    """As much as a weight of the map that undoes what makes all count alike."""
    alike = map_factors(scans, {})
    weights = {name: 1 / factor for name, factor in alike.items()}
    judged = compress(scans, differences=2, importance=everywhere(scans))
    weighed = compress(scans, differences=2, map_weights=weights)
    for key in scans.stacks:
        np.testing.assert_allclose(judged.parts[key].differences, weighed.parts[key].differences, atol=1e-3)


def test_a_weight_of_a_map_multiplies_its_importance(scans):
    tripled = {key: one * np.float32(3 if key[0] == "normal" else 1) for key, one in everywhere(scans).items()}
    one = compress(scans, differences=2, importance=tripled)
    other = compress(scans, differences=2, importance=everywhere(scans), map_weights={"normal": 3.0})
    for key in scans.stacks:
        np.testing.assert_allclose(one.parts[key].differences, other.parts[key].differences, atol=1e-3)


def test_maps_without_one_take_the_albedos(scans):
    rng = np.random.default_rng(0)
    albedos = {key: rng.random(s.resolution, np.float32) for key, s in scans.stacks.items() if key[0] == "albedo"}
    alike = map_factors(scans, {})
    spread = {key: albedos["albedo", key[1]] * np.float32(alike[key[0]]) for key in scans.stacks}
    one, other = (compress(scans, differences=2, importance=some) for some in (albedos, spread))
    for key in scans.stacks:
        np.testing.assert_allclose(one.parts[key].differences, other.parts[key].differences, atol=1e-3)


@pytest.mark.parametrize("name", ["albedo", "normal", "roughness"])
def test_what_counts_more_has_less_of_the_error(scans, name):
    factors = map_factors(scans, {})
    errors = []
    for strength in (1.0, 100.0):
        images = everywhere(scans)
        for key, image in images.items():
            image *= np.float32(factors[key[0]] * (strength if key[0] == name else 1))
        found = model_errors(scans, compress(scans, differences=2, importance=images))[name]
        errors.append(found.angular_error_rms or found.rmse)
    assert errors[1] < 0.95 * errors[0]


@pytest.mark.parametrize(
    ("lost", "code"),
    [(("albedo", 1002), ErrorCode.SIZE_MISMATCH), (("normal", 1001), ErrorCode.SIZE_MISMATCH)],
)
def test_a_tile_without_its_image_is_named(scans, lost, code):
    images = everywhere(scans)
    del images[lost]
    with pytest.raises(FaceZipError, match=f"{lost[0]} for tile {lost[1]}") as caught:
        compress(scans, importance=images)
    assert caught.value.code is code


@pytest.mark.parametrize("key", [("albedo", 1001), ("normal", 1002)])
def test_an_image_of_another_size_is_refused(scans, key):
    with pytest.raises(FaceZipError, match=f"16 x 8 texels; the {key[0]} .* has 32 x 64 on tile {key[1]}") as caught:
        compress(scans, importance={**everywhere(scans), key: np.ones((8, 16), np.float32)})
    assert caught.value.code is ErrorCode.SIZE_MISMATCH


@pytest.mark.parametrize("key", [("gloss", 1001), ("albedo", 1003)])
def test_an_image_of_what_there_is_not_is_refused(scans, key):
    with pytest.raises(FaceZipError) as caught:
        compress(scans, importance={**everywhere(scans), key: np.ones((4, 4), np.float32)})
    assert caught.value.code is ErrorCode.UNKNOWN_NAME


def test_files_are_named_by_what_there_are_several_of(scans):
    assert [*importance_files(scans).values()][1:3] == ["importance.1002.exr", "importance.normal.1001.exr"]
    whole = random_surface(expressions=2)
    names = ["importance.exr", "importance.normal.exr", "importance.roughness.exr"]
    assert [*importance_files(whole).values()] == names
    assert [*importance_files(whole.only("albedo")).values()] == names[:1]


def test_a_folder_holds_the_albedos_and_those_that_there_are(scans, tmp_path):
    names, rng = importance_files(scans), np.random.default_rng(1)
    images = {key: rng.random(scans.stacks[key].resolution, np.float32) + 0.1 for key in names if key[0] != "roughness"}
    for key, image in images.items():
        write_values(tmp_path / names[key], image)
    found = read_importance(tmp_path, scans)
    assert set(found) == set(images)
    for key, image in images.items():
        np.testing.assert_array_equal(found[key], image)
    (tmp_path / "importance.1002.exr").unlink()
    with pytest.raises(FaceZipError, match=r"importance\.1002\.exr") as caught:
        read_importance(tmp_path, scans)
    assert caught.value.code is ErrorCode.MISSING_FILE


def test_compress_into_fits_with_what_a_folder_holds(scans, tmp_path):
    save_character(scans, tmp_path / "scans")
    (tmp_path / "images").mkdir()
    names = importance_files(scans)
    for key, image in everywhere(scans).items():
        write_values(tmp_path / "images" / names[key], image)
    settings = replace(Request().settings, differences=2)
    request = Request(settings=settings, importance=tmp_path / "images")
    document = compress_into(tmp_path / "scans", tmp_path / "a.facezip", request)
    expected = model_errors(scans, compress(scans, differences=2, importance=everywhere(scans)))
    assert document.errors["roughness"].rmse == pytest.approx(expected["roughness"].rmse, rel=0.05)
    assert document.made_with["importance"] == "images"
