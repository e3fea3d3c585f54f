"""Regions: images of any size become masks of a weight map's size, and leave what they should of a blend."""

import json

import numpy as np
import pytest

from facezip import FaceZipError
from facezip.errors import ErrorCode
from facezip.export import TARGETS
from facezip.export.source import read_source
from facezip.files.images import write_texture
from facezip.pack.write import write_pack
from tests.facezip.conftest import random_model
from tests.facezip.export.conftest import layered_model
from tests.facezip.export.gains import REGIONS, masks_in, regions_in


@pytest.fixture
def pack(tmp_path):
    """Its weight maps are of 3 x 5 texels."""
    write_pack(random_model(meshes=True), tmp_path / "me.facezip")
    return tmp_path / "me.facezip"


def image(folder, texels, name="mask.png"):
    write_texture(folder / name, np.asarray(texels, np.uint8)[..., None])
    return folder / name


def refused(pack, regions):
    with pytest.raises(FaceZipError) as caught:
        read_source(pack, regions=regions)
    return caught.value


def test_masks_are_the_means_of_their_images(pack, tmp_path):
    texels = np.random.default_rng(0).integers(0, 256, (12, 20))
    (tile,) = read_source(pack, regions={"chin": image(tmp_path, texels)}).tiles
    means = texels.reshape(3, 4, 5, 4).mean(axis=(1, 3))
    assert tile.regions.names == ("chin",)
    assert np.abs(tile.regions.masks[0] - means).max() <= 0.5 + 1e-4


def test_a_smaller_image_changes_steadily_between_its_texels(pack, tmp_path):
    (tile,) = read_source(pack, regions={"chin": image(tmp_path, [[0, 255]])}).tiles
    between = (np.arange(5) + 0.5) * 2 / 5 - 0.5
    expected = np.broadcast_to(255 * np.clip(between, 0, 1), (3, 5))
    assert np.abs(tile.regions.masks[0] - expected).max() <= 0.5 + 1e-3


def test_what_is_exported_are_the_masks(pack, tmp_path):
    files = regions_in(tmp_path)
    (tile,) = read_source(pack, regions=files).tiles
    TARGETS["gltf"](pack, tmp_path / "out", region=files)
    found = masks_in(tmp_path / "out")
    assert tuple(found) == REGIONS
    np.testing.assert_array_equal(np.stack([*found.values()]), tile.regions.masks / 255)


def test_an_export_without_regions_says_so(pack, tmp_path):
    TARGETS["gltf"](pack, tmp_path / "out")
    document = json.loads((tmp_path / "out" / "facezip.json").read_text())
    assert document["gains"] == {"maps": ["albedo"], "expressions": ["expr_0", "expr_1", "expr_2"], "regions": []}
    assert "regions" not in document
    assert "region" not in (tmp_path / "out" / "facezip.glsl").read_text()


def test_a_tile_without_a_file_has_nothing_of_the_region(tmp_path):
    write_pack(layered_model(tiles=(1001, 1002)), tmp_path / "me.facezip")
    image(tmp_path, np.full((3, 5), 255), "lips.1002.png")
    first, second = read_source(tmp_path / "me.facezip", regions={"lips": tmp_path / "lips.<UDIM>.png"}).tiles
    assert not first.regions.masks.any()
    assert (second.regions.masks == 255).all()


def test_what_would_do_nothing_is_refused(pack, tmp_path):
    white, black = (image(tmp_path, np.full((3, 5), value), f"{value}.png") for value in (255, 0))
    assert refused(pack, {"a": black}).code is ErrorCode.BAD_TEXELS
    assert refused(pack, {"a": tmp_path / "none.<UDIM>.png"}).code is ErrorCode.MISSING_FILE
    assert refused(pack, {"a": tmp_path / "none.png"}).code is ErrorCode.MISSING_FILE
    assert refused(pack, {"a/b": white}).code is ErrorCode.UNSAFE_NAME
    assert refused(pack, {"a": white, "A": white}).code is ErrorCode.UNSAFE_NAME
    write_pack(random_model(weights=(1, 1), meshes=True), tmp_path / "uniform.facezip")
    assert refused(tmp_path / "uniform.facezip", {"a": white}).code is ErrorCode.BAD_VALUE
    write_pack(layered_model(tiles=(1001, 1002)), tmp_path / "tiles.facezip")
    assert refused(tmp_path / "tiles.facezip", {"a": white}).code is ErrorCode.BAD_VALUE
