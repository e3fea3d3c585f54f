import numpy as np
import pytest

from facezip.character.raster import covered, rasterise
from facezip.files.obj import Topology
from tests.facezip.conftest import grid_topology


@pytest.fixture
def triangle():
    """Half of the unit square, below its rising diagonal."""
    uv = np.array([[0, 0], [1, 0], [1, 1]], np.float32)
    return Topology(np.array([[0, 1, 2]], np.int32), uv, np.array([[0, 1, 2]], np.int32))


def test_interpolating_uv_gives_the_texel_centres():
    topology = grid_topology(5)
    seen = rasterise(topology, (12, 20)).interpolate(topology.uv)
    y, x = np.mgrid[:12, :20]
    np.testing.assert_allclose(seen[..., 0], (x + 0.5) / 20, atol=1e-6)
    np.testing.assert_allclose(seen[..., 1], 1 - (y + 0.5) / 12, atol=1e-6)


def test_a_chart_without_gaps_covers_every_texel():
    assert rasterise(grid_topology(5), (31, 17)).covered.all()


def test_the_first_row_of_texels_is_the_top_of_the_chart(triangle):
    seen = rasterise(triangle, (16, 16)).covered
    assert seen[0].sum() == 1
    assert seen[-1].all()


def test_what_is_covered_by_blocks_of_rows_is_what_a_raster_covers(triangle):
    np.testing.assert_array_equal(covered(triangle, (100, 70)), rasterise(triangle, (100, 70)).covered)


def test_barycentrics_sum_to_one_inside_and_to_zero_outside(triangle):
    raster = rasterise(triangle, (16, 16))
    np.testing.assert_allclose(raster.barycentric.sum(axis=2), raster.covered, atol=1e-6)


def test_dilation_keeps_the_chart_and_fills_the_rest_from_it(triangle):
    raster = rasterise(triangle, (16, 16))
    dilated = raster.dilated()
    assert dilated.covered.all()
    np.testing.assert_array_equal(dilated.barycentric[raster.covered], raster.barycentric[raster.covered])
    # The top left corner is nearest to the middle of the diagonal.
    np.testing.assert_allclose(dilated.interpolate(triangle.uv)[0, 0], 0.5, atol=0.04)


def test_a_triangle_without_area_and_one_outside_the_unit_square_cover_nothing():
    uv = np.array([[0, 0], [1, 1], [0.5, 0.5], [2, 2], [3, 2], [2, 3]], np.float32)
    faces = np.array([[0, 1, 2], [3, 4, 5]], np.int32)
    assert not rasterise(Topology(faces, uv, faces), (8, 8)).covered.any()


def test_both_windings_cover_the_same_texels(triangle):
    mirrored = Topology(triangle.faces[:, ::-1].copy(), triangle.uv, triangle.face_uv[:, ::-1].copy())
    np.testing.assert_array_equal(rasterise(triangle, (9, 9)).covered, rasterise(mirrored, (9, 9)).covered)
