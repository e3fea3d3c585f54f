"""Arrays of every kind come back from a GLB, where viewers look for them."""

import numpy as np
import pytest

from facezip.files.accessors import COMPONENTS
from facezip.files.glb import Glb
from facezip.files.glb_builder import VERTICES, GlbBuilder


@pytest.mark.parametrize("kind", COMPONENTS.values())
@pytest.mark.parametrize("width", [1, 2, 3])
@pytest.mark.parametrize("share", [0, 0.1, 1])
def test_arrays_of_every_kind_come_back(kind, width, share):
    rng = np.random.default_rng(0)
    values = rng.integers(0, 100, (500, width)).astype(kind)
    values[rng.random(500) >= share] = 0
    builder = GlbBuilder({})
    places = [
        builder.array(values, VERTICES),
        builder.sparse(values),
        builder.sparse(values[::-1]),
        builder.array(values),
    ]
    glb = Glb.parse(builder.finish().to_bytes())
    for place, expected in zip(places, [values, values, values[::-1], values], strict=True):
        read = glb.array(place)
        assert read.dtype == kind
        np.testing.assert_array_equal(read, expected)
    for view in glb.document["bufferViews"]:
        assert view["byteOffset"] % 4 == 0
        if view.get("target") == VERTICES:
            assert view.get("byteStride", values[:1].nbytes) % 4 == 0


@pytest.mark.parametrize(("row", "itemsize"), [(2**16 - 1, 2), (2**16, 4)])
def test_rows_of_sparse_arrays_are_as_short_as_they_can_be(row, itemsize):
    values = np.zeros((2**17, 3), np.int16)
    values[row] = 1
    builder = GlbBuilder({})
    builder.array(np.ones_like(values))
    builder.sparse(values)
    glb = Glb.parse(builder.finish().to_bytes())
    np.testing.assert_array_equal(glb.array(1), values)
    kind = COMPONENTS[glb.document["accessors"][1]["sparse"]["indices"]["componentType"]]
    assert np.dtype(kind).itemsize == itemsize


def test_sparse_arrays_have_views_that_end_where_they_end_or_share_one():
    """Godot prints an error for every other view of its own."""
    values = np.zeros((500, 3), np.float32)
    values[[3, 77, 400]] = 1
    own, shared = GlbBuilder({}), GlbBuilder({}, gathered=True)
    for builder in (own, shared):
        builder.array(values)
        builder.sparse(values)
        builder.sparse(-values)
        glb = Glb.parse(builder.finish().to_bytes())
        np.testing.assert_array_equal(glb.array(2), -values)
    assert [view["byteLength"] for view in own.document["bufferViews"]] == [values.nbytes, 6, 36, 6, 36]
    assert len(shared.document["bufferViews"]) == 2


def test_normalised_integers_are_read_as_numbers_up_to_one():
    builder = GlbBuilder({})
    builder.array(np.array([[-127, 0, 127]], np.int8), VERTICES, normalized=True)
    np.testing.assert_array_equal(Glb.parse(builder.finish().to_bytes()).array(0), [[-1, 0, 1]])
