import numpy as np
import pytest

from facezip.files.obj import Topology
from render.regions import NAMES, face_regions, locate
from scenes.face.head import build_head
from scenes.face.shapes import ARKIT_SHAPES, shape_deltas


@pytest.fixture(scope="module")
def head():
    return build_head()


@pytest.fixture(scope="module")
def regions(head):
    return face_regions(head.topology, head.vertices)


def named(regions, name):
    return regions == NAMES.index(name)


def test_every_triangle_has_a_region_and_every_region_a_triangle(regions):
    assert {*np.unique(regions)} == {*range(len(NAMES))}


@pytest.mark.parametrize(
    ("shape", "allowed"),
    [
        ("eyeBlinkLeft", {"left eye"}),
        ("eyeBlinkRight", {"right eye"}),
        ("browInnerUp", {"brows", "forehead"}),
        ("mouthPucker", {"mouth"}),
        ("noseSneerLeft", {"nose", "left cheek", "left eye"}),
        ("cheekSquintLeft", {"left cheek"}),
    ],
)
def test_a_shape_moves_the_region_that_is_named_for_it(head, regions, shape, allowed):
    """Of the triangles, the one that a shape moves farthest lies where anatomy says."""
    moved = np.linalg.norm(shape_deltas(head)[ARKIT_SHAPES.index(shape)], axis=1)
    farthest = moved[head.topology.faces].mean(axis=1).argmax()
    assert NAMES[regions[farthest]] in allowed


def test_left_mirrors_right(head):
    """x and -x exchanged: left becomes right and nothing else changes."""
    mirrored = face_regions(head.topology, head.vertices * np.float32([-1, 1, 1]))
    other = {"left": "right", "right": "left"}
    names = [NAMES[i].split() for i in face_regions(head.topology, head.vertices)]
    swapped = [" ".join(other.get(word, word) for word in name) for name in names]
    same = np.mean([a == NAMES[b] for a, b in zip(swapped, mirrored, strict=True)])
    assert same > 0.99


@pytest.mark.parametrize("scale", [0.01, 10.0])
def test_neither_unit_nor_place_matters(head, regions, scale):
    moved = (head.vertices * np.float32(scale) + np.float32([3, -7, 20]) * np.float32(scale)).astype(np.float32)
    assert np.mean(face_regions(head.topology, moved) == regions) > 0.995


def test_a_bust_is_named_as_its_head(head, regions):
    """Shoulders, far broader than the head, change no name on it."""
    shoulders = np.float32([[-28, -30, -8], [28, -30, -8], [0, -34, -2]])
    count = len(head.vertices)
    faces = np.concatenate([head.topology.faces, np.int32([[count, count + 1, count + 2]])])
    bust = Topology(faces, head.topology.uv, np.concatenate([head.topology.face_uv, head.topology.face_uv[:1]]))
    found = face_regions(bust, np.concatenate([head.vertices, shoulders]))
    assert np.mean(found[:-1] == regions) > 0.99
    assert NAMES[found[-1]] == "neck"


def test_an_error_is_found_where_it_is():
    labels = np.full((60, 40), NAMES.index("forehead"), np.int32)
    labels[30:] = NAMES.index("mouth")
    error = np.full((60, 40), 0.1, np.float32)
    error[46:56, 28:38] = 5
    errors, worst = locate(error, np.ones((60, 40), bool), labels)
    top, left, height, width = worst.box
    assert worst.region == "mouth"
    assert top <= 46 < 56 <= top + height
    assert left <= 28 < 38 <= left + width
    assert errors == pytest.approx({"forehead": 0.1, "mouth": worst.delta_e_p95})


def test_a_place_too_small_for_any_percentile_is_found():
    labels = np.full((200, 200), NAMES.index("forehead"), np.int32)
    labels[100:] = NAMES.index("mouth")
    error = np.zeros((200, 200), np.float32)
    error[150:160, 90:100] = 40
    errors, worst = locate(error, np.ones((200, 200), bool), labels)
    assert errors["mouth"] == 0
    assert worst.region == "mouth"


def test_pixels_beside_the_head_and_slivers_name_no_place():
    labels = np.full((60, 40), NAMES.index("nose"), np.int32)
    labels[0, :5] = NAMES.index("chin")
    error, head = np.ones((60, 40), np.float32), np.ones((60, 40), bool)
    head[20:] = False
    error[0, :5] = error[30:] = 9
    assert locate(error, head, labels)[0] == {"nose": 1.0}


def test_without_an_error_there_is_no_place():
    nothing = np.zeros((20, 20), np.float32)
    errors, worst = locate(nothing, nothing == 0, np.zeros((20, 20), np.int32))
    assert worst is None
    assert errors == {NAMES[0]: 0.0}
