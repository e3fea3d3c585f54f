"""Any valid model, of whatever maps, tiles, names and ranges, comes back from its pack as it was quantised."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facezip.character.maps import Map
from facezip.character.meshes import Meshes
from facezip.files.obj import Topology
from facezip.names import folded, is_safe_name
from facezip.pack.model import CompressedTextures, Part
from facezip.pack.quantise import quantise
from facezip.pack.read import read_pack
from facezip.pack.verification import verify_pack
from facezip.pack.write import write_pack

SIDES = st.integers(1, 9)
SIZES = st.tuples(SIDES, SIDES)
PRINTABLE = st.characters(codec="utf-8", exclude_categories=["C", "Z"]) | st.just(" ")
NAMES = st.text(PRINTABLE, min_size=1, max_size=30).filter(is_safe_name)
MAP_NAMES = st.from_regex(r"[a-z][a-z0-9_]{0,31}", fullmatch=True).filter(lambda name: name not in ("weights", "mask"))
ENDS = st.floats(-1e6, 1e6, width=32)


@st.composite
def map_kinds(draw):
    name, encoding = draw(MAP_NAMES), draw(st.sampled_from(["srgb", "data", "normal"]))
    if encoding == "normal":
        return Map(name, encoding, -1.0, 1.0)
    low, high = sorted(draw(st.tuples(ENDS, ENDS).filter(lambda ends: abs(ends[1] - ends[0]) > 1e-3)))
    return Map(name, encoding, low, high)


@st.composite
def models(draw):
    names = tuple(draw(st.lists(NAMES, min_size=1, max_size=6, unique_by=folded)))
    maps = tuple(draw(st.lists(map_kinds(), min_size=1, max_size=3, unique_by=lambda kind: kind.name)))
    tiles = sorted(draw(st.sets(st.integers(1001, 1999), min_size=1, max_size=3)))
    slots, uniform = draw(st.integers(1, 8)), draw(st.booleans())
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    channels = {kind.name: 2 if kind.is_normal else draw(st.integers(1, 4)) for kind in maps}
    parts, weights, shared = {}, {}, random.normal(0, 1, (len(names), 1, 1, slots)).astype(np.float32)
    for tile in tiles:
        sizes = {kind.name: draw(SIZES) for kind in maps}
        for kind in maps:
            shape, reach = (*sizes[kind.name], channels[kind.name]), draw(st.sampled_from([0, 1e-6, 0.1, 10]))
            neutral, differences = random.random(shape), random.normal(0, reach, (slots, *shape))
            bits = draw(st.sampled_from([8, 16]))
            parts[kind.name, tile] = Part(neutral.astype(np.float32), differences.astype(np.float32), bits)
        most = sizes[maps[0].name]
        least = draw(st.tuples(st.integers(1, most[0]), st.integers(1, most[1])))
        grid = random.normal(0, 1, (len(names), *least, slots)).astype(np.float32)
        weights[tile] = shared if uniform else grid
    if not uniform and any(grid.shape[1:3] == (1, 1) for grid in weights.values()):
        weights = dict.fromkeys(tiles, shared)
    meshes = draw(st.none() | st.just(_meshes(random, len(names))))
    return CompressedTextures("refined", names, maps, parts, weights, meshes)


def _meshes(random, count):
    """Triangles anywhere, seams wherever layouts differ from faces, some vertices of no triangle."""
    faces, layout = (random.integers(0, 7, (5, 3)).astype(np.int32) for _ in range(2))
    neutral = (random.normal(0, 1, (8, 3)) * 10 ** random.uniform(-3, 3)).astype(np.float32)
    moves = random.normal(0, 0.1, (count, 8, 3)) * np.ptp(neutral)
    return Meshes(
        Topology(faces, random.random((7, 2), np.float32), layout), neutral, (neutral + moves).astype(np.float32)
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("packs")


@given(models(), st.text(PRINTABLE, max_size=20))
@settings(max_examples=40, deadline=None)
def test_any_model_comes_back_as_it_was_quantised(folder, model, name):
    write_pack(model, folder / "me.facezip", name=name, overwrite=True)
    back, expected = read_pack(folder / "me.facezip"), quantise(model).dequantised()
    assert verify_pack(folder / "me.facezip").name == (name or "me")
    assert (back.expressions, back.maps, back.tiles) == (model.expressions, model.maps, model.tiles)
    for key, part in expected.parts.items():
        np.testing.assert_array_equal(back.parts[key].neutral, part.neutral)
        np.testing.assert_allclose(back.parts[key].differences, part.differences, rtol=1e-5, atol=1e-6)
        assert back.parts[key].bits == part.bits
    for tile, weights in expected.weights.items():
        np.testing.assert_array_equal(back.weights[tile], weights)
    assert (back.meshes is None) == (model.meshes is None)
    if model.meshes is not None:
        assert_meshes(back.meshes, model.meshes)


def assert_meshes(back, meshes):
    """Corners and the neutral exactly; a vertex of an expression within what the format promises."""
    topology = meshes.topology
    assert np.array_equal(back.topology.faces, topology.faces)
    assert np.array_equal(back.topology.uv[back.topology.face_uv], topology.uv[topology.face_uv])
    assert np.array_equal(back.neutral, meshes.neutral)
    reach = 1e-5 * np.ptp(meshes.neutral, axis=0).max()
    distances = np.linalg.norm(back.vertices.astype(np.float64) - meshes.vertices, axis=-1)
    # A position is rounded to float32 too.
    assert distances.max() <= reach + 1e-6 * np.abs(meshes.vertices).max()
