"""The 52 shapes: their names, their laws, and that each does what its name says."""

import numpy as np
import pytest

from scenes.face.features import LID_HALF_WIDTH, MOUTH_HALF_WIDTH
from scenes.face.head import build_head
from scenes.face.sculpt import EYE
from scenes.face.shapes import ARKIT_SHAPES, shape_deltas

LEFT = [name for name in ARKIT_SHAPES if name.endswith("Left")]
COMPOUNDS = {
    "smile": {"mouthSmile": 1, "cheekSquint": 1},
    "grin": {"mouthSmile": 1, "mouthUpperUp": 0.5, "jawOpen": 0.4},
    "surprise": {"browInnerUp": 1, "browOuterUp": 1, "eyeWide": 1, "jawOpen": 0.6},
    "disgust": {"noseSneer": 1, "browDown": 1, "mouthUpperUp": 1},
    "funnel": {"jawOpen": 0.5, "mouthFunnel": 1},
    "closed lips": {"jawOpen": 1, "mouthClose": 1},
    "scream": {"jawOpen": 1, "mouthStretch": 1, "eyeSquint": 1, "browDown": 1},
    "frown": {"browDown": 1, "mouthFrown": 1},
}


@pytest.fixture(scope="module")
def head():
    return build_head()


@pytest.fixture(scope="module")
def deltas(head):
    return shape_deltas(head)


@pytest.fixture
def shape(head, deltas):
    """Displacements of a shape on the grid."""
    return lambda name: head.grid(deltas[ARKIT_SHAPES.index(name)]).astype(np.float64)


@pytest.fixture
def grid(head):
    return head.grid(head.vertices).astype(np.float64)


def column_at(grid, row, x):
    """The front column nearest to x on a row."""
    return int((np.abs(grid[row, :, 0] - x) + 100 * (grid[row, :, 2] < 0)).argmin())


def near(grid, point):
    """Index of the vertex nearest to a point."""
    return np.unravel_index(np.linalg.norm(grid - np.array(point), axis=2).argmin(), grid.shape[:2])


def turned_over(head, displacement):
    """Whether each face's normal turns by more than 90 degrees; slivers are left out."""
    before, after = (_normals(head, points) for points in (head.vertices, head.vertices + displacement))
    size = np.linalg.norm(before, axis=1)
    return (np.einsum("ij,ij->i", before, after) < 0) & (size > 2e-6)


def _normals(head, points):
    a, b, c = points.astype(np.float64)[head.topology.faces].transpose(1, 0, 2)
    return np.cross(b - a, c - a)


def in_openings(head):
    """Faces inside the mouth or between the lids, which fold away as they should."""
    rows = head.topology.faces // head.shape[1]
    low, high = rows.min(axis=1), rows.max(axis=1)
    mouth = (high > head.rows.lower_lip) & (low < head.rows.upper_lip)
    return mouth | ((high > head.rows.lower_lid) & (low < head.rows.upper_lid))


def test_the_52_names_of_arkit():
    assert len(ARKIT_SHAPES) == len(set(ARKIT_SHAPES)) == 52
    assert list(ARKIT_SHAPES) == sorted(ARKIT_SHAPES)
    for name in LEFT:
        assert f"{name[:-4]}Right" in ARKIT_SHAPES


def test_shapes_are_finite_float32(head, deltas):
    assert deltas.shape == (52, len(head.vertices), 3)
    assert deltas.dtype == np.float32
    assert np.isfinite(deltas).all()


def test_every_shape_moves_something_and_nothing_far(deltas):
    reach = np.linalg.norm(deltas, axis=2).max(axis=1)
    assert (reach > 0.1).all()
    assert (reach < 5).all()


def test_deterministic(head, deltas):
    assert np.array_equal(shape_deltas(head), deltas)


def test_neck_base_and_back_of_the_head_rest(head, deltas):
    still = (head.vertices[:, 1] < -15.5) | (head.vertices[:, 2] < -3)
    assert np.abs(deltas[:, still]).max() < 1e-5


def test_ears_hardly_move(head, deltas):
    ears = (np.abs(head.vertices[:, 0]) > 7.6) & (np.abs(head.vertices[:, 1]) < 4)
    assert np.linalg.norm(deltas[:, ears], axis=2).max() < 0.1


@pytest.mark.parametrize("name", LEFT)
def test_right_shapes_mirror_left_ones(head, shape, name):
    """Up to the asymmetry of the face."""
    left, right = shape(name), shape(f"{name[:-4]}Right")
    columns = np.arange(head.shape[1])
    mirrored = right[:, -columns % head.shape[1]] * [-1, 1, 1]
    assert np.linalg.norm(mirrored - left, axis=2).max() < 0.15 * np.linalg.norm(left, axis=2).max()


@pytest.mark.parametrize("name", [name for name in LEFT if not name.startswith(("jaw", "mouthLeft"))])
def test_left_shapes_move_the_left_half_most(grid, shape, name):
    moved = np.linalg.norm(shape(name), axis=2)
    assert moved[grid[..., 0] > 0].sum() > 2 * moved[grid[..., 0] < 0].sum()


# mouthClose is a corrective of jawOpen, which makes sense only with it.
@pytest.mark.parametrize("name", [name for name in ARKIT_SHAPES if name != "mouthClose"])
def test_no_skin_turns_over(head, deltas, name):
    assert not (turned_over(head, deltas[ARKIT_SHAPES.index(name)]) & ~in_openings(head)).any()


@pytest.mark.parametrize("name", COMPOUNDS)
def test_no_skin_turns_over_in_compounds(head, deltas, name):
    total = np.zeros_like(deltas[0])
    for base, weight in COMPOUNDS[name].items():
        for whole in (base, f"{base}Left", f"{base}Right"):
            if whole in ARKIT_SHAPES:
                total += np.float32(weight) * deltas[ARKIT_SHAPES.index(whole)]
    assert not (turned_over(head, total) & ~in_openings(head)).any()


@pytest.mark.parametrize("side", ["Left", "Right"])
def test_blink_closes_the_eye_and_squeezes_what_is_between(head, grid, shape, side):
    lower, upper = head.rows.lower_lid, head.rows.upper_lid
    closed = grid + shape(f"eyeBlink{side}")
    sign = 1 if side == "Left" else -1
    for x in (EYE[0] - 0.6, EYE[0], EYE[0] + 0.6):
        column = column_at(grid, lower, sign * x)
        opening = grid[upper, column, 1] - grid[lower, column, 1]
        assert closed[upper, column, 1] - closed[lower, column, 1] < 0.15 * opening
        y, z = (closed[lower : upper + 1, column] - EYE)[:, 1:].T
        assert (np.diff(np.arctan2(y, z)) > -0.01).all(), "rows between the lids fold over"


def test_blinking_lid_slides_over_the_eyeball(head, grid, shape):
    """At half and at full weight the margin of the lid stays outside the part of the eyeball next to it."""
    low, high = head.rows.lower_lid, head.rows.upper_lid
    x = grid[high, :, 0]
    columns = np.flatnonzero((np.abs(x - EYE[0]) < 0.8 * LID_HALF_WIDTH) & (grid[high, :, 2] > 4))
    for weight in (0.5, 1.0):
        distance = np.linalg.norm((grid + weight * shape("eyeBlinkLeft") - EYE)[low : high + 1, columns, 1:], axis=2)
        assert (distance[-1] > distance[-2]).all()


def test_wide_eyes_keep_a_round_iris(head, grid, shape):
    """The lids part, and what lies between their margins hardly stretches around the pupil."""
    low, high = head.rows.lower_lid, head.rows.upper_lid
    column = column_at(grid, low, EYE[0])
    moved = shape("eyeWideLeft")[low : high + 1, column, 1]
    assert moved[-1] > 0.12
    assert np.abs(moved[3:-3]).max() < 0.06


def test_looking_moves_the_iris_and_not_the_corners(head, grid, shape):
    row = (head.rows.lower_lid + head.rows.upper_lid) // 2
    iris = column_at(grid, row, EYE[0])
    assert shape("eyeLookOutLeft")[row, iris, 0] > 0.2
    assert shape("eyeLookInLeft")[row, iris, 0] < -0.2
    assert shape("eyeLookUpLeft")[row, iris, 1] > 0.15
    assert shape("eyeLookDownLeft")[row, iris, 1] < -0.15
    corner = column_at(grid, row, EYE[0] + LID_HALF_WIDTH + 0.1)
    assert np.abs(shape("eyeLookOutLeft")[row, corner]).max() < 0.05


def test_jaw_opens_the_mouth(head, grid, shape):
    middle = head.shape[1] // 2
    opened = shape("jawOpen")
    lips = opened[head.rows.upper_lip, middle, 1] - opened[head.rows.lower_lip, middle, 1]
    assert lips > 2
    assert np.abs(opened[head.rows.upper_lip, middle]).max() < 0.1
    assert np.linalg.norm(opened[near(grid, (0, 2.5, 9))]) < 1e-3


def test_mouth_close_brings_the_lips_of_an_open_jaw_together(head, shape):
    middle = head.shape[1] // 2
    closed = shape("jawOpen") + shape("mouthClose")
    gap = closed[head.rows.upper_lip, middle, 1] - closed[head.rows.lower_lip, middle, 1]
    assert abs(gap) < 0.35


def test_smile_pulls_the_corner_up_and_back(grid, shape, head):
    corner = column_at(grid, head.rows.upper_lip, MOUTH_HALF_WIDTH)
    x, y, z = shape("mouthSmileLeft")[head.rows.upper_lip, corner]
    assert x > 0.3
    assert y > 0.3
    assert z < -0.2


def vertical_strain(grid, displacement, low, high, x):
    """Relative change of the length of a front column between two heights."""
    column = column_at(grid, near(grid, (x, (low + high) / 2, 9))[0], x)
    rows = np.flatnonzero((grid[:, column, 1] > low) & (grid[:, column, 1] < high))
    before, after = (
        np.linalg.norm(np.diff(points[rows, column], axis=0), axis=1).sum() for points in (grid, grid + displacement)
    )
    return after / before - 1


@pytest.mark.parametrize(
    ("name", "low", "high", "x"),
    [("browInnerUp", 3.5, 7.0, 0.3), ("browOuterUpLeft", 3.5, 7.0, 3.8), ("noseSneerLeft", -1.8, 0.6, 1.1)],
)
def test_compresses_where_wrinkles_grow(grid, shape, name, low, high, x):
    assert vertical_strain(grid, shape(name), low, high, x) < -0.04


def test_frowning_draws_the_brows_together(grid, shape):
    total = shape("browDownLeft") + shape("browDownRight")
    left, right = (total[near(grid, (x, 2.3, 8.3))][0] for x in (1.4, -1.4))
    assert left < -0.1
    assert right > 0.1


def test_puckering_narrows_the_mouth_and_pushes_it_forward(grid, shape, head):
    row = head.rows.upper_lip
    pucker = shape("mouthPucker")
    assert pucker[row, column_at(grid, row, 2.0), 0] < -0.4
    assert pucker[row, column_at(grid, row, -2.0), 0] > 0.4
    assert pucker[row, head.shape[1] // 2, 2] > 0.4
