import numpy as np
import pytest

from facezip.character.tiles import Atlas, shifted
from scenes.tiles import in_tiles
from tests.facezip.surfaces import random_surface


@pytest.mark.parametrize("tiles", [(1, 1), (3, 1), (2, 2)])
def test_cutting_into_tiles_and_joining_them_changes_nothing(tiles):
    whole = random_surface(side=48)
    cut = in_tiles(whole, *tiles)
    atlas = Atlas.of(cut.tiles)
    np.testing.assert_allclose(atlas.topology(cut.meshes.topology).uv, whole.meshes.topology.uv, atol=1e-6)
    for kind in whole.maps:
        joined = atlas.joined({tile: cut.texture("expr_1", kind.name, tile) for tile in cut.tiles})
        np.testing.assert_array_equal(joined, whole.texture("expr_1", kind.name))


def test_tiles_far_from_the_first_leave_no_empty_room_around_them():
    assert Atlas.of((1013, 1024)) == Atlas(2, 1, 2, 2)
    assert Atlas.of((1013,)).joined({1013: np.ones((4, 6, 3), np.float32)}).shape == (4, 6, 3)


def test_a_smaller_tile_is_enlarged_to_the_largest():
    small, large = np.full((4, 4, 1), 0.25, np.float32), np.full((8, 8, 1), 0.75, np.float32)
    joined = Atlas.of((1001, 1002)).joined({1001: small, 1002: large})
    np.testing.assert_allclose(joined[:, :8], 0.25)
    np.testing.assert_allclose(joined[:, 8:], 0.75)


def test_a_tile_lies_in_the_unit_square_of_its_own_layout(surface):
    topology = in_tiles(surface, 2, 2).meshes.topology
    for tile, corner in ((1001, (0, 0)), (1002, (1, 0)), (1011, (0, 1)), (1012, (1, 1))):
        np.testing.assert_allclose(shifted(topology, tile).uv + corner, topology.uv)
