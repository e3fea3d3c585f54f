"""The embedded head: a manifold sheet with one injective chart, a person's proportions, and no two equal halves."""

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from facezip.character.raster import rasterise
from scenes.face.chart import MARGIN
from scenes.face.features import MOUTH_HALF_WIDTH, lip_line
from scenes.face.head import build_head
from scenes.face.sculpt import EYE, distance


@pytest.fixture(scope="module")
def head():
    return build_head()


@pytest.fixture(scope="module")
def edges(head):
    faces = head.topology.faces
    return np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])


def corners(head):
    return head.vertices.astype(np.float64)[head.topology.faces]


def uv_areas(head):
    a, b, c = head.topology.uv.astype(np.float64)[head.topology.face_uv].transpose(1, 0, 2)
    return ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2


def mirrored(head, values):
    """Values on the grid as the other half of the face has them, x negated."""
    columns = np.arange(head.shape[1])
    return head.grid(values)[:, -columns % head.shape[1]] * [-1, 1, 1]


def test_size(head):
    assert 20_000 <= len(head.vertices) <= 30_000
    assert 45_000 <= len(head.topology.faces) <= 55_000
    assert len(head.vertices) == head.shape[0] * head.shape[1]
    assert np.isfinite(head.vertices).all()


def test_every_vertex_and_every_uv_is_used(head):
    assert np.array_equal(np.unique(head.topology.faces), np.arange(len(head.vertices)))
    assert np.array_equal(np.unique(head.topology.face_uv), np.arange(len(head.topology.uv)))


def test_no_edge_is_run_twice_in_one_direction(edges):
    """Neighbours agree on their orientation, and no edge has three faces."""
    assert len(np.unique(edges, axis=0)) == len(edges)


def test_open_only_at_neck_and_crown(head, edges):
    pairs, count = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)
    assert set(np.unique(pairs[count == 1] // head.shape[1])) == {0, head.shape[0] - 1}
    crown = head.grid(head.vertices)[-1]
    assert np.ptp(crown, axis=0).max() < 1e-4


def test_connected(head, edges):
    graph = coo_matrix((np.ones(len(edges)), edges.T), shape=(len(head.vertices),) * 2)
    assert connected_components(graph, directed=False)[0] == 1


def test_faces_look_outwards(head):
    a, b, c = corners(head).transpose(1, 0, 2)
    assert np.einsum("ij,ij->", a, np.cross(b, c)) / 6 > 3000


def test_no_degenerate_faces_but_at_the_crown(head):
    a, b, c = corners(head).transpose(1, 0, 2)
    flat = np.linalg.norm(np.cross(b - a, c - a), axis=1) < 1e-9
    assert (head.topology.faces[flat].max(axis=1) // head.shape[1] == head.shape[0] - 1).all()


def test_uv_lie_inside_the_unit_square(head):
    assert head.topology.uv.min() >= MARGIN * 0.99
    assert head.topology.uv.max() <= 1 - MARGIN * 0.99


def test_uv_triangles_have_one_orientation(head):
    assert (uv_areas(head) > 0).all()


def test_uv_do_not_overlap(head):
    """Triangles of one orientation whose areas add up to what they cover cannot overlap."""
    covered = rasterise(head.topology, (512, 512)).covered.mean()
    assert uv_areas(head).sum() == pytest.approx(covered, abs=0.004)


def test_uv_raster_finds_the_right_triangle(head):
    """The map from texels back to the chart is the identity."""
    raster = rasterise(head.topology, (128, 128))
    uv = np.einsum("hwj,hwjk->hwk", raster.barycentric, head.topology.uv[head.topology.face_uv[raster.face]])
    row, column = np.nonzero(raster.covered)
    expected = np.stack([(column + 0.5) / 128, 1 - (row + 0.5) / 128], axis=1)
    assert np.allclose(uv[raster.covered], expected, atol=1e-4)


def test_chart_is_cut_behind(head):
    """The seam, where one vertex has two UVs, runs down the middle of the back."""
    seam = head.grid(head.vertices)[:, 0]
    assert (seam[seam[:, 1] < 10, 2] < -3).all()
    assert np.abs(seam[:, 0]).max() < 0.3


def test_fills_the_chart_with_the_face(head):
    """From ear to ear and from chin to brow it has most of the chart."""
    a, b, c = corners(head).transpose(1, 0, 2)
    centre = (a + b + c) / 3
    face = (np.abs(np.arctan2(centre[:, 0], centre[:, 2])) < np.pi / 2) & (np.abs(centre[:, 1]) < 11)
    assert uv_areas(head)[face].sum() / uv_areas(head).sum() > 0.5


def test_deterministic(head):
    again = build_head.__wrapped__()
    assert np.array_equal(again.vertices, head.vertices)
    assert np.array_equal(again.topology.faces, head.topology.faces)
    assert np.array_equal(again.topology.uv, head.topology.uv)


def test_slightly_asymmetric(head):
    difference = np.linalg.norm(mirrored(head, head.vertices) - head.grid(head.vertices), axis=2)
    assert 0.01 < np.median(difference) < 0.2


def test_proportions_of_an_adult(head):
    """Eyes at half the height of the head (chin to crown 23 cm), head 15 cm wide without the ears."""
    vertices = head.vertices
    chin = vertices[(np.abs(vertices[:, 0]) < 1) & (vertices[:, 2] > 6), 1].min()
    height = vertices[:, 1].max() - chin
    assert 21.5 < height < 24.0
    assert (EYE[1] - chin) / height == pytest.approx(0.5, abs=0.03)
    skull = vertices[vertices[:, 1] > 5]
    assert 13.5 < np.ptp(skull[:, 0]) < 16.0
    assert 18.0 < np.ptp(skull[:, 2]) < 21.0


def test_nose_is_the_foremost_point(head):
    tip = head.vertices[head.vertices[:, 2].argmax()]
    assert abs(tip[0]) < 0.3
    assert -4 < tip[1] < -2


def test_ears_stand_off_the_head_between_brow_and_nose(head):
    widest = head.vertices[np.abs(head.vertices[:, 0]) > 7.8]
    ears = widest[np.abs(widest[:, 1]) < 6]
    assert (ears[:, 0] > 0).any()
    assert (ears[:, 0] < 0).any()
    assert ears[:, 1].max() < 3.5
    assert ears[:, 1].min() > -5


@pytest.mark.parametrize("side", [-1, 1])
def test_eyes_are_open(head, side):
    """The margins of the lids part by about a centimetre over the pupil."""
    lower, upper = head.grid(head.vertices)[[head.rows.lower_lid, head.rows.upper_lid]]
    pupil = np.abs(lower[:, 0] - side * EYE[0]).argmin()
    assert 0.7 < upper[pupil, 1] - lower[pupil, 1] < 1.3


def test_lips_meet_and_hide_a_pocket(head):
    grid = head.grid(head.vertices)
    lower, upper = grid[head.rows.lower_lip], grid[head.rows.upper_lip]
    inside = (np.abs(lower[:, 0]) < 0.8 * MOUTH_HALF_WIDTH) & (lower[:, 2] > 5)
    assert np.abs(upper[inside, 1] - lower[inside, 1]).max() < 0.15
    assert np.abs(upper[inside, 1] - lip_line(upper[inside, 0])).max() < 0.2
    pocket = grid[head.rows.lower_lip + 1 : head.rows.upper_lip][:, inside]
    assert (pocket[..., 2] < upper[inside, 2]).all()


def test_rows_are_dense_where_rays_from_the_axis_graze_the_sculpt(head):
    """Under the nose and under the chin, where heights alone would leave a centimetre and two without a vertex."""
    grid = head.grid(head.vertices).astype(np.float64)
    middle = np.abs(head.shape[1] // 2 - np.arange(head.shape[1])) < 12
    steps = np.linalg.norm(np.diff(grid[:, middle], axis=0), axis=2)
    y = (grid[1:, middle, 1] + grid[:-1, middle, 1]) / 2
    assert steps[(y > -5) & (y < -2)].max() < 0.6
    assert steps[(y > -12.5) & (y < -8)].max() < 1.0


def test_vertices_of_the_face_lie_on_the_sculpt(head):
    """Whatever moved them along it; eyes, mouth and ears are no part of it."""
    points = head.vertices.astype(np.float64)
    x, y, z = np.abs(points[:, 0]), points[:, 1], points[:, 2]
    face = (x < 4) & (z > 0) & (((y > -5) & (y < -0.8)) | ((y > -16) & (y < -7.3)))
    assert face.sum() > 3000
    assert max(abs(distance(*point)) for point in points[face]) < 2e-3


def test_the_rim_of_the_ear_follows_the_lines_of_the_grid(head):
    """It would be seen as a zigzag: the outline of the right one bends from row to row by a few degrees."""
    grid = head.grid(head.vertices).astype(np.float64)
    rim = grid[np.arange(head.shape[0]), grid[..., 0].argmin(axis=1)]
    rim = rim[(rim[:, 1] > -0.9) & (rim[:, 1] < 1.1)]
    turns = np.diff(rim, axis=0)
    turns /= np.linalg.norm(turns, axis=1, keepdims=True)
    assert len(rim) > 15
    assert np.einsum("ij,ij->i", turns[1:], turns[:-1]).min() > 0.99


def test_neck_ends_in_a_clean_cut(head):
    base = head.grid(head.vertices)[0]
    assert np.ptp(base[:, 1]) < 0.4
    assert head.vertices[:, 1].min() == pytest.approx(base[:, 1].min())


def test_pocket_closes_towards_the_corners_of_the_mouth(head):
    """Nothing of it lies beyond the lips, or pulls on the skin beside them."""
    grid = head.grid(head.vertices)
    band = grid[head.rows.lower_lip : head.rows.upper_lip + 1]
    x = np.abs(band[0, :, 0])
    corner = (x > 0.97 * MOUTH_HALF_WIDTH) & (x < MOUTH_HALF_WIDTH) & (band[0, :, 2] > 5)
    assert corner.any()
    assert np.abs(np.abs(band[:, corner, 0]) - x[corner]).max() < 0.2
